"""A small campaign, and that the judge is not blind: a tool that is broken on purpose is found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from end_effector_hal.codecs import _ees1
from end_effector_hal.control import Status
from end_effector_hal.control._status_builder import StatusBuilder
from end_effector_hal.sensing._link_rules import LinkRules
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.sensing._sensor_set import SensorSet
from tests.acceptance.link_campaign.episode import Found
from tests.acceptance.link_campaign.summary import as_json, holds
from tests.acceptance.link_campaign.virtual import in_virtual_time
from tests.acceptance.link_campaign.wall import play_for
from tests.support.nightly import first_of


def test_nothing_that_a_link_does_harms() -> None:
    found = in_virtual_time(50, seed=1_000_000, jobs=1)
    assert found.tracebacks == []
    assert found.violations == []
    assert (found.undetected, found.false_confirmations) == (0, 0)
    assert holds(found)
    assert found.faults.total() >= 50
    assert found.confirmations > 10


@pytest.mark.nightly
@pytest.mark.wall
@pytest.mark.alone
@pytest.mark.timeout(180)
def test_nor_in_real_time() -> None:
    found = play_for(3.0, seed=7)
    assert (found.violations, found.tracebacks) == ([], [])
    assert found.decoded > 0


def without_crc(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(_ees1, "crc_hqx", lambda data, start: 0)


def without_staleness(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Readings, "look", lambda self, at: setattr(self, "fresh", self._values))
    patch.setattr(Readings, "get", lambda self, channel, at: self._values.get(channel))
    patch.setattr(Readings, "deadline", lambda self, at: None)


def without_ranges(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(LinkRules, "_limits", property(lambda self: {}, lambda self, limits: None), raising=False)


def without_words(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(SensorSet, "notices", lambda self, at, held: ())


def with_a_drop_at_every_doubt(patch: pytest.MonkeyPatch) -> None:
    status = StatusBuilder.status

    def dropping(self: StatusBuilder, at: int, *events: object) -> Status:
        told = status(self, at, *events)
        return told if all(told.evidence) else replace(told, outputs=(False,) * 3)

    patch.setattr(StatusBuilder, "status", dropping)


@pytest.mark.parametrize(
    "broken",
    first_of(
        [
            (with_a_drop_at_every_doubt, "went inactive while a part was held"),
            (without_staleness, "confirmed"),
            (without_ranges, "STAND_BY, and "),
            (without_words, "no alarm"),
        ],
        1,
    ),
)
def test_the_judge_sees_a_broken_tool(
    broken: tuple[Callable[[pytest.MonkeyPatch], None], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    spoil, said = broken
    spoil(monkeypatch)
    found = Found()
    for seed in range(0, 400, 20):
        found.add(in_virtual_time(20, seed=seed, jobs=1))
        if any(said in violation for violation in found.violations):
            break
    else:
        raise AssertionError(found.violations)
    assert not holds(found)
    assert as_json(found)["ok"] is False


def test_the_judge_sees_a_decoder_without_a_checksum(monkeypatch: pytest.MonkeyPatch) -> None:
    without_crc(monkeypatch)
    assert in_virtual_time(20, seed=3, jobs=1).undetected > 0
