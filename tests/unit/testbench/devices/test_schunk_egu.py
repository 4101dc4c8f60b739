"""The EGU and EGK, by the maker's own driver."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench.devices import model_for
from end_effector_lab.testbench.physics import Fingers
from end_effector_lab.virtual import VirtualTool
from tests.unit.testbench.devices.played import PlayedUnit
from tests.unit.virtual.test_unread_outputs import until

GRIP, RELEASE, MOVE, ACKNOWLEDGE, NOTHING = (0x0110,), (0x0108,), (0x0120,), (0x0500,), (0x0100,)
TOOL = """
schema: 2
name: electric
link: {port: /dev/ttyUSB0}
sequence: [jaws]
actuators:
  jaws: {device: schunk-egu}
supply: {channel: none}
"""


class Jaws(PlayedUnit):
    def __init__(self, *, acknowledged: bool = True) -> None:
        model = model_for("schunk-egu")
        assert model is not None
        super().__init__(model, {0: Fingers()})
        if acknowledged:
            self.write(0x47, *ACKNOWLEDGE)

    def bits(self) -> set[int]:
        """Numbers of the bits that are on in the status; bit 5 only toggles with a command."""
        high, low = self.words(0x3F, 2, function=3)
        word = int.from_bytes(high.to_bytes(2, "big") + low.to_bytes(2, "big"), "little")
        return {bit for bit in range(32) if word >> bit & 1} - {5}

    @property
    def micrometres(self) -> int:
        first, second = self.words(0x41, 2, function=3)
        return int.from_bytes(first.to_bytes(2, "big") + second.to_bytes(2, "big"), "little")


def test_it_powers_up_in_an_error_and_obeys_nothing_until_that_is_acknowledged() -> None:
    jaws = Jaws(acknowledged=False)
    assert jaws.bits() == {7}
    assert jaws.words(0x45, 1, function=3) == [0xD900]
    jaws.write(0x47, *GRIP)
    jaws.run(2)
    assert (jaws.bits(), jaws.told) == ({7}, [])
    jaws.write(0x47, *ACKNOWLEDGE)
    assert jaws.bits() == {0}
    assert jaws.words(0x45, 1, function=3) == [0]
    jaws.run(2)
    assert jaws.told == [], "what was commanded in the error is forgotten"


def test_a_grip_and_a_release() -> None:
    jaws = Jaws()
    jaws.write(0x47, *GRIP)
    assert jaws.bits() == {0}
    jaws.run(2)
    assert jaws.bits() == {0, 4, 12}
    jaws.write(0x47, *RELEASE)
    jaws.run(2)
    assert jaws.bits() == {0, 4, 13}
    assert jaws.micrometres == 40_000
    assert jaws.told == [(0, True), (0, False)]


def test_closing_on_nothing_and_a_lost_workpiece() -> None:
    jaws = Jaws()
    fingers = jaws.devices[0]
    fingers.meet(False)
    jaws.write(0x47, *GRIP)
    jaws.run(2)
    assert jaws.bits() == {0, 11}
    jaws.write(0x47, *RELEASE)
    jaws.run(2)
    fingers.meet(True)
    jaws.write(0x47, *GRIP)
    jaws.run(2)
    fingers.lose(jaws.at)
    jaws.run(1)
    assert jaws.bits() == {0, 16}


def test_any_position_in_micrometres_the_low_byte_first() -> None:
    jaws = Jaws()
    wanted = (30_000).to_bytes(4, "little")
    jaws.write(0x49, int.from_bytes(wanted[:2], "big"), int.from_bytes(wanted[2:], "big"))
    jaws.write(0x47, *MOVE)
    jaws.run(2)
    assert (jaws.bits(), jaws.micrometres) == ({0, 4, 13}, 30_000)


def test_a_fast_stop_is_an_error_and_stops() -> None:
    jaws = Jaws()
    jaws.write(0x47, *GRIP)
    jaws.run(0.1)
    jaws.write(0x47, 0)
    where = jaws.micrometres
    jaws.run(2)
    assert (7 in jaws.bits(), jaws.micrometres) == (True, where)


@pytest.mark.parametrize(
    ("pdu", "answer"),
    [("04 003F 0001", "84 01"), ("03 003E 0001", "83 02"), ("10 0046 0001 02 0100", "90 02")],
)
def test_what_it_refuses(pdu: str, answer: str) -> None:
    assert Jaws().ask(pdu) == answer


def test_the_product_gets_it_out_of_its_error_by_a_drop_and_grips(tmp_path: Path) -> None:
    """At the start, and when its power was lost while it held; nothing is written before the Drop."""
    path = tmp_path / "end_effector.yaml"
    path.write_text(TOOL)
    tool = VirtualTool(load_tool(path))
    tool.run(3.0)
    assert tool.status.ee is EndEffectorState.GRIP_ERROR
    assert "Whether a part is held is not known" in tool.status.reason
    for loses in (True, False):
        assert tool.command("drop").accepted
        until(tool, EndEffectorState.STAND_BY)
        assert tool.command("grip").accepted
        until(tool, EndEffectorState.GRIPPED)
        moved = len(tool.edges)
        if loses:
            tool.choose("reboot-after:0")
            tool.run(5.0)
            assert tool.status.ee is EndEffectorState.GRIP_ERROR
            assert len(tool.edges) == moved
            tool.choose("nominal")
