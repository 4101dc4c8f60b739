"""What a managed node asks before it lets a tool work."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.lifecycle import require_proof, what_is_missing
from end_effector_hal.verification.proof import kept_verdict
from end_effector_hal.vocabulary import ChangerState, EndEffectorState, Evidence


def state(**values: Any) -> Any:
    whole = {
        "state": EndEffectorState.STAND_BY,
        "link_up": True,
        "actuator_names": ["a", "b"],
        "evidence": [Evidence.GONE, Evidence.GONE],
        "tool_changer": ChangerState.LOCKED,
        "alarms": ["The supply is low."],
    }
    return SimpleNamespace(**(whole | values))


@pytest.mark.parametrize(
    ("values", "lacks"),
    [
        ({}, ()),
        ({"link_up": False}, ("no frame comes over the sensor link PORT", "The supply is low")),
        ({"state": EndEffectorState.OFF}, ("its lines are not adopted", "The supply is low")),
        (
            {"evidence": [Evidence.GONE, Evidence.UNKNOWN], "alarms": []},
            ("its sensors do not show b",),
        ),
        (
            {"tool_changer": ChangerState.UNKNOWN, "alarms": []},
            ("its sensors do not show whether the tool is locked",),
        ),
        (
            {"state": EndEffectorState.OFF, "link_up": False, "alarms": []},
            ("no frame comes over the sensor link PORT",),
        ),
    ],
)
def test_what_a_tool_lacks(verdin: Description, values: dict[str, Any], lacks: tuple[str, ...]) -> None:
    said = what_is_missing(verdin, state(**values))
    assert tuple(each.replace(verdin.link.port, "PORT") for each in said) == lacks
    assert what_is_missing(verdin, None) == ("its nodes report nothing",)


def test_a_proof_is_asked_for_then_and_there_and_kept(verdin: Description) -> None:
    with pytest.raises(UsageError, match="No proof is stored of verdin_gripper as it is now"):
        require_proof(verdin, prove_now=False)
    assert require_proof(verdin, prove_now=True).holds
    assert require_proof(verdin, prove_now=False).holds
    verdict = kept_verdict(verdin)
    assert verdict is not None
    assert verdict.holds
