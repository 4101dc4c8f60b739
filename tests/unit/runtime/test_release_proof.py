"""How long an unlock waits for its proof, in virtual time."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime.programs._release_proof import FALL_S, LAG_S, await_release
from end_effector_hal.vocabulary import EndEffectorState

STAND_BY, RELEASING, GRIPPED = EndEffectorState.STAND_BY, EndEffectorState.RELEASING, EndEffectorState.GRIPPED
UNKNOWN, GONE, PARTIAL = 0, 1, 2


def status(ee: EndEffectorState, evidence: int, *, vented: bool = False) -> Any:
    return SimpleNamespace(ee=ee, evidence=(evidence, GONE), vented=vented)


class Statuses:
    """The statuses of a program, each at its time in s; waiting moves the clock."""

    def __init__(self, **at: Any) -> None:
        self.at_s, self.ended = 0.0, False
        self._coming = [(float(name.removeprefix("ms_")) / 1000, each) for name, each in at.items()]
        _, self.status = self._coming.pop(0)

    def wait(self, until: Callable[[Any], bool], timeout_s: float) -> bool:
        end_s = self.at_s + timeout_s
        while not until(self.status):
            if not self._coming or self._coming[0][0] > end_s:
                self.at_s = end_s
                return False
            self.at_s, self.status = self._coming.pop(0)
        return True


def waited(**at: Any) -> tuple[float, bool]:
    """For how long in s, and whether the proof is there then."""
    changer = load(profile_path()).tool_changer
    assert changer
    statuses = Statuses(**at)
    await_release(statuses, changer)  # type: ignore[arg-type]
    return statuses.at_s, statuses.status.vented


def test_what_is_proven_is_not_waited_for() -> None:
    assert waited(ms_0=status(STAND_BY, GONE, vented=True)) == (0, True)


@pytest.mark.parametrize(
    "before", [status(RELEASING, PARTIAL), status(RELEASING, GONE), status(STAND_BY, PARTIAL)]
)
def test_the_end_of_a_release_that_is_under_way_is_waited_for(before: Any) -> None:
    """A drop has returned: the other program has seen its end, this one not yet."""
    proof = status(STAND_BY, GONE, vented=True)
    assert waited(ms_0=before, ms_700=proof) == (0.7, True)


@pytest.mark.parametrize("state", [GRIPPED, EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR])
def test_what_cannot_come_is_not_waited_for(state: EndEffectorState) -> None:
    assert waited(ms_0=status(state, PARTIAL)) == (0, False)
    assert waited(ms_0=status(RELEASING, PARTIAL), ms_300=status(state, PARTIAL)) == (0.3, False)


@pytest.mark.parametrize("evidence", [GONE, PARTIAL, UNKNOWN])
def test_the_wait_has_an_end(evidence: int) -> None:
    assert waited(ms_0=status(STAND_BY, evidence)) == (pytest.approx(0.5 + FALL_S + LAG_S), False)
