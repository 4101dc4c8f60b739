"""When a reading proves that an actuator on a bus is gone."""

from __future__ import annotations

from end_effector_hal.codecs import load_tool
from end_effector_hal.sensing._output_gate import OutputGate
from end_effector_hal.signals import Frame, memory_of, recall
from end_effector_hal.vocabulary import Evidence
from tests.support.places import ROOT

GONE = Evidence.GONE, Evidence.GONE
REMOTE = ROOT / "examples/tools/remote_io/end_effector.yaml"


def said(at: int, *inactive: str) -> Frame:
    return Frame(at, None, None, {}, inactive)


def test_only_a_later_frame_that_shows_the_output_inactive_opens_the_gate() -> None:
    description = load_tool(REMOTE)
    lift, cup = (actuator.line for _, actuator in description.ordered)
    gate = OutputGate(description)
    assert gate.withheld(GONE) == (), "before any command the sensors decide"
    gate.switch(1, 100, active=True)
    gate.see(said(150, lift, cup))
    assert gate.withheld(GONE) == (1,), "no reading proves it while it is commanded to be active"
    assert gate.withheld((Evidence.GONE, Evidence.CONFIRMED)) == ()
    gate.switch(1, 200, active=False)
    for frame in (said(200, lift, cup), said(250, lift), said(260)):
        gate.see(frame)
        assert gate.withheld(GONE) == (1,), frame
    other = OutputGate(description)
    recall(other, memory_of(gate))
    gate.see(said(300, cup))
    assert gate.withheld(GONE) == ()
    assert other.withheld(GONE) == (1,), "a snapshot remembers it"


def test_lines_of_the_board_obey_at_once() -> None:
    description = load_tool(ROOT / "examples/tools/double_acting_jaw/end_effector.yaml")
    gate = OutputGate(description)
    gate.switch(0, 100, active=True)
    assert gate.withheld(GONE[:1]) == ()
