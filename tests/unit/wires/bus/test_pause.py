"""A pause between two requests, for devices that lose what comes too early."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import codec_of
from tests.unit.wires.bus.played_bus import ANSWER_US, MS, VG10, Bus, Registers, S, described

PAUSE_US = 15 * MS
A, B = "modbus:65/0x0000", "modbus:65/0x0001"


class Timed(Bus):
    """Notes when each request began."""

    def __init__(self, pause_ms: int) -> None:
        text = VG10.replace("{modbus: {}}", f"{{modbus: {{pause_ms: {pause_ms}}}}}")
        super().__init__(described(text), {65: Registers()})
        self.begun: list[int] = []
        self.lost = False

        def noted(request: bytes, answer: bytes) -> bytes:
            self.begun.append(self.at)
            return b"" if self.lost else answer

        self.wire = noted

    def shortest(self) -> int:
        return min(after - before for before, after in zip(self.begun, self.begun[1:], strict=False))


@pytest.mark.parametrize("lost", [False, True])
def test_reads_and_writes_keep_the_pause_after_an_answer_and_after_none(lost: bool) -> None:
    for pause_ms in (0, PAUSE_US // MS):
        bus = Timed(pause_ms)
        bus.to(1 * S)
        bus.lost = lost
        for level in (True, False, True):
            bus.outputs.command({A: level}, bus.at)
            bus.outputs.command({B: level}, bus.at)
            bus.to(bus.at + 500 * MS)
        answered_us = 0 if lost else ANSWER_US
        assert (bus.shortest() >= PAUSE_US + answered_us) is (pause_ms > 0)


def test_a_cycle_lasts_as_much_longer() -> None:
    periods = [
        codec_of(described(VG10.replace("{modbus: {}}", f"{{modbus: {{pause_ms: {pause_ms}}}}}"))).period_us
        for pause_ms in (0, 300)
    ]
    assert periods[1] - periods[0] > 200 * MS
