"""A codec of somebody else's fails while a part is held: it stays held, the tool says why, and works afterwards."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from end_effector_hal.codecs import Decoder, Ees1Ascii
from end_effector_hal.runtime import EndEffector
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import sensors
from end_effector_hal.wires.lines import read_chip
from end_effector_hal.wires.link import LinkState
from end_effector_lab.demo._world import World
from tests.support.patience import wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(90)]
LINES = ("SODIMM_208", "SODIMM_210", "SODIMM_212")


class Failing(Ees1Ascii):
    """Works but while ``fault`` is set."""

    fault: Callable[[list[Frame]], Any] | None = None

    def decoder(self) -> Decoder:
        return _Decoder(self, super().decoder())


class _Decoder:
    def __init__(self, codec: Failing, inner: Decoder) -> None:
        self._codec, self._inner = codec, inner

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def feed(self, data: bytes, at: int) -> Any:
        frames = self._inner.feed(data, at)
        return self._codec.fault(frames) if self._codec.fault else frames


def levels(world: World) -> Mapping[str, bool]:
    state = read_chip(world.chip)
    return {line: bool(state.lines[line].level) for line in LINES}


def leave(frames: list[Frame]) -> list[Frame]:
    raise SystemExit("a codec ends its thread")


def in_2038(frames: list[Frame]) -> list[Frame]:
    return [Frame(2**51, frame.seq, frame.device_ms, frame.values) for frame in frames]


@pytest.mark.parametrize(
    ("fault", "why"),
    [
        (leave, "feed() raised SystemExit: a codec ends its thread"),
        pytest.param(in_2038, "a frame whose stamp is ahead of now", marks=pytest.mark.nightly),
    ],
)
def test_a_codec_that_fails_while_gripped_lets_nothing_go(
    world: World, monkeypatch: pytest.MonkeyPatch, fault: Callable[[list[Frame]], Any], why: str
) -> None:
    codec = Failing()
    monkeypatch.setattr(sensors, "codec_of", lambda description, link: codec)
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        wait_until("a grip", lambda: tool.grip().succeeded)
        codec.fault = fault
        wait_until("DOWN", lambda: tool.link.state is LinkState.DOWN and why in tool.link.error)
        wait_until("the alarm", lambda: any("is down" in alarm for alarm in tool.status.alarm_texts))
        status = tool.status
        assert (status.ee, status.held, status.lift_allowed) == (EndEffectorState.GRIPPED, True, False)
        assert set(status.evidence) == {0}
        assert levels(world) == dict.fromkeys(LINES, True)
        codec.fault = None
        wait_until("evidence", lambda: tool.status.evidence == (3, 3, 3))
        assert (tool.link.state, tool.link.errors["codec"] > 0) == (LinkState.UP, True)
        wait_until("a drop", lambda: tool.drop().succeeded)
        codec.fault = fault
        wait_until("DOWN again", lambda: tool.link.state is LinkState.DOWN)
    assert levels(world) == dict.fromkeys(LINES, False)
