"""Evidence by conditions: confirmed, gone, lost and empty each by its own; what contradicts itself proves nothing."""

from __future__ import annotations

from typing import Any

from end_effector_hal.kinds.conditions import ConditionDetector
from end_effector_hal.kinds.stanza import EvidenceConditions
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import Evidence

from .samples import Samples

C, G, P, U = Evidence.CONFIRMED, Evidence.GONE, Evidence.PARTIAL, Evidence.UNKNOWN
PERIOD = 20_000
JAW: dict[str, Any] = {
    "confirmed": {"all": [{"on": "closed"}, {"not": {"on": "open"}}], "for_ms": 40},
    "gone": {"on": "open"},
}
CUP: dict[str, Any] = {
    "confirmed": {"channel": "cup", "below_kpa": -55, "samples": 3},
    "gone": {"channel": "cup", "above_kpa": -10},
    "lost": {"channel": "cup", "above_kpa": -50, "samples": 2},
}


class Watched:
    """A detector that is fed at 50 Hz."""

    def __init__(self, evidence: dict[str, Any]) -> None:
        self.detector = ConditionDetector(EvidenceConditions.model_validate(evidence))
        self.at = 0

    def __call__(self, samples: int = 1, **values: Value) -> list[Evidence]:
        levels = []
        for _ in range(samples):
            self.at += PERIOD
            levels.append(self.detector.sample(Samples(values), self.at))
        return levels

    def cup(self, *kpa: float | None) -> list[Evidence]:
        return [self(cup=None if each is None else round(each * 1000))[0] for each in kpa]


def test_each_proof_is_its_own() -> None:
    jaw = Watched(JAW)
    assert jaw(open=True, closed=False) == [G]
    assert jaw(2, open=False, closed=False) == [P, P]  # not gone any more, and not confirmed
    assert jaw(3, open=False, closed=True) == [P, P, C]
    assert jaw(open=False, closed=False) == [P]
    assert jaw(open=True, closed=False) == [G]


def test_hysteresis_is_what_lost_says() -> None:
    cup = Watched(CUP)
    assert cup.cup(0, -60, -60, -60) == [G, P, P, C]
    assert cup.cup(-51, -49, -51, -49) == [C, C, C, C]
    assert cup.cup(-49, -52) == [P, P]
    assert cup.cup(-60, -60, -60) == [P, P, C]


def test_what_was_confirmed_before_silence_is_confirmed_again_at_the_threshold_of_loss() -> None:
    cup = Watched(CUP)
    cup.cup(-60, -60, -60)
    assert cup.cup(-52, None, -52, -52, -52) == [C, U, U, U, C]
    assert cup.cup(None, -49, -49) == [U, U, P]


def test_what_is_lost_during_silence_is_lost() -> None:
    jaw = Watched(JAW)
    jaw(3, open=False, closed=True)
    assert jaw(open=None, closed=None) == [U]
    assert jaw(open=False, closed=False) == [P]


def test_without_one_of_its_readings_nothing_is_proven_that_needs_it() -> None:
    jaw = Watched(JAW)
    assert jaw(3, open=None, closed=True) == [U, U, U]
    assert jaw(open=True, closed=None) == [G]  # which needs `open` alone
    assert jaw(open=False, closed=None) == [U]


def test_a_release_that_is_proven_ends_what_was_confirmed() -> None:
    """``gone`` by a sensor of its own, while that of ``confirmed`` is dead."""
    jaw = Watched({"confirmed": {"on": "part"}, "gone": {"on": "open"}})
    assert jaw(part=True, open=False) == [C]
    assert jaw(part=None, open=False) == [U]
    assert jaw(part=None, open=True) == [G]
    assert jaw(part=None, open=False) == [U]
    assert jaw(part=False, open=False) == [P]


def test_contradicting_sensors_prove_nothing_and_are_broken_when_it_lasts() -> None:
    jaw = Watched({**JAW, "confirmed": {"on": "closed", "for_ms": 40}})
    jaw(3, open=False, closed=True)
    assert jaw(open=True, closed=True) == [U]
    assert jaw.detector.contradicts
    assert not jaw.detector.broken
    assert set(jaw(30, open=True, closed=True)) == {U}
    assert jaw.detector.broken
    # the same switch alone is believed again, and has to last again
    assert jaw(3, open=False, closed=True) == [U, U, C]
    assert not jaw.detector.contradicts
    assert not jaw.detector.broken


def test_what_is_asked_to_be_on_at_both_ends_contradicts_unless_another_fault_is_declared() -> None:
    jaw = Watched(JAW)
    assert jaw(open=True, closed=True) == [U]
    assert jaw(open=True, closed=False) == [G]
    seen = Watched({"confirmed": {"all": [{"on": "part"}, {"not": {"on": "open"}}]}, "gone": {"on": "open"}})
    assert seen(open=True, part=True) == [U]
    beam = {"confirmed": {"all": [{"on": "part"}, {"not": {"on": "open"}}]}, "gone": {"on": "open"}}
    barrier = Watched({**beam, "fault": {"all": [{"on": "open"}, {"on": "closed"}]}})
    assert barrier(open=True, part=True, closed=False) == [
        G
    ]  # a light barrier sees a part that is not gripped
    assert barrier(open=True, part=True, closed=True) == [U]


def test_a_fault_of_its_own_is_declared() -> None:
    jaw = Watched({**JAW, "fault": {"all": [{"on": "air"}, {"on": "no_air"}]}})
    assert jaw(open=True, closed=False, air=True, no_air=True) == [U]
    assert jaw(open=True, closed=False, air=True, no_air=None) == [G]


def test_empty_is_no_confirmation_and_no_release() -> None:
    jaw = Watched(
        {"confirmed": {"on": "part"}, "gone": {"on": "open"}, "empty": {"on": "closed", "for_ms": 20}}
    )
    assert jaw(2, part=False, open=False, closed=True) == [P, P]
    assert jaw.detector.empty
    jaw(part=False, open=False, closed=None)
    assert not jaw.detector.empty


def test_a_confirmation_that_is_lost_at_the_same_time_is_none() -> None:
    odd = Watched({"confirmed": {"on": "a"}, "gone": {"on": "b"}, "lost": {"on": "c"}})
    assert odd(a=True, b=False, c=True) == [P]
    assert odd(a=True, b=False, c=None) == [U]
    assert odd(a=True, b=False, c=False) == [C]
