"""What a managed node asks before it lets a tool work."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.launching import require_proof, what_is_missing
from end_effector_hal.verification.proof import kept_verdict
from end_effector_hal.vocabulary import Alarm, ChangerState, EndEffectorState, Evidence
from tests.support.lone_node import status

LOW, PORT = Alarm("supply.low", values={"warn_kpa": 450}), "no frame comes over the sensor link PORT"
SAID = LOW.text.rstrip(".")
UNKNOWN = (Evidence.GONE, Evidence.UNKNOWN, Evidence.GONE)


@pytest.mark.parametrize(
    ("values", "lacks"),
    [
        ({"alarms": (LOW,)}, ()),
        ({"link_up": False, "alarms": (LOW,)}, (PORT, SAID)),
        ({"ee": EndEffectorState.OFF, "alarms": (LOW,)}, ("its lines are not adopted", SAID)),
        ({"evidence": UNKNOWN}, ("its sensors do not show cylinder",)),
        ({"changer": ChangerState.UNKNOWN}, ("its sensors do not show whether the tool is locked",)),
        ({"ee": EndEffectorState.OFF, "link_up": False}, (PORT,)),
    ],
)
def test_what_a_tool_lacks(verdin: Description, values: dict[str, Any], lacks: tuple[str, ...]) -> None:
    said = what_is_missing(verdin, replace(status(changer=ChangerState.LOCKED), **values))
    assert tuple(each.replace(verdin.link.port, "PORT") for each in said) == lacks


def test_a_proof_is_asked_for_then_and_there_and_kept(verdin: Description) -> None:
    with pytest.raises(UsageError, match="No proof is stored of verdin_gripper as it is now"):
        require_proof(verdin, prove_now=False)
    assert require_proof(verdin, prove_now=True).holds
    assert require_proof(verdin, prove_now=False).holds
    verdict = kept_verdict(verdin)
    assert verdict is not None
    assert verdict.holds
