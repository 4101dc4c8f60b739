"""IL-12: outputs driven in maintenance, with a lease; however it ends, what it engaged is deactivated."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import ArbiterError, LineRefusedError
from end_effector_hal.runtime.outputs._maintenance import Maintenance
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_hal.vocabulary import LastWillStep
from tests.support.lone_program import BOTTOM, CYLINDER, LINES, OFF, ON, TOP, Tool

S = 1_000_000


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


def with_lease(description: Description, seconds: float) -> Description:
    lease = description.maintenance.model_copy(update={"lease_s": seconds})
    return description.model_copy(update={"maintenance": lease})


class TestLease:
    """In virtual time."""

    def test_it_lasts_30_s_from_the_last_call(self, description: Description) -> None:
        mode = Maintenance(description)
        mode.drove(BOTTOM, True, 0)
        mode.drove(TOP, True, 20 * S)
        assert mode.over(50 * S - 1) == []
        assert mode.over(50 * S) == [TOP, BOTTOM]  # in release order
        assert mode.lines == []
        assert mode.ends_at is None
        assert mode.over(51 * S) == []

    def test_what_is_deactivated_by_hand_ends_it(self, description: Description) -> None:
        mode = Maintenance(description)
        mode.drove(BOTTOM, True, 0)
        mode.drove(BOTTOM, False, S)
        assert (mode.lines, mode.ends_at, mode.notice) == ([], None, "")

    def test_its_will_deactivates_everything_in_release_order(self, description: Description) -> None:
        mode = Maintenance(description)
        mode.drove(BOTTOM, True, 0)
        assert mode.will_with(TOP, True) == (LastWillStep(TOP), LastWillStep(BOTTOM))
        assert mode.lines == [BOTTOM]
        assert mode.will_with(BOTTOM, False) == ()

    def test_it_says_what_is_active_and_for_how_long(self, description: Description) -> None:
        mode = Maintenance(description)
        mode.drove(BOTTOM, True, 0)
        mode.drove(CYLINDER, True, 0)
        expected = "Maintenance: Cylinder, Bottom vacuum active, deactivated 30 s after the last call."
        assert mode.notice == expected


@pytest.fixture
def tool(description: Description) -> Iterator[Tool]:
    made = Tool(with_lease(description, 0.6))
    made.program.start()
    made.until(lambda status: status.ee == State.STAND_BY and set(status.evidence) == {1})
    yield made
    made.arbiter.error = None
    made.program.close()


def drive(tool: Tool, name: str, line: str) -> None:
    """Activated in maintenance, and proven; frames come meanwhile from here."""
    tool.confirmed[line] = ON
    index = LINES.index(line)
    tool.until(lambda status: status.evidence[index] == 3)
    answer = tool.program.set_actuator(name, True)
    assert answer.accepted, answer.reason


@pytest.mark.wall
class TestProgram:
    def test_the_end_of_the_lease_deactivates_and_is_seen(self, tool: Tool) -> None:
        drive(tool, "bottom_vacuum", BOTTOM)
        status = tool.until(lambda status: status.maintenance)
        assert status.outputs == (True, False, False)
        assert status.deadline is not None
        assert any(alarm.startswith("Maintenance: Bottom vacuum") for alarm in status.alarm_texts)
        tool.until(lambda status: not status.maintenance)
        assert tool.arbiter.active[BOTTOM] is OFF
        assert not tool.program.status.alarm_texts

    def test_a_grip_is_refused_meanwhile(self, tool: Tool) -> None:
        drive(tool, "cylinder", CYLINDER)
        answer = tool.program.command("grip")
        assert not answer.accepted
        assert answer.reason.startswith("IL-12: a grip is refused during maintenance.")

    def test_its_will_stands_when_everything_is_written_anew(self, tool: Tool) -> None:
        drive(tool, "bottom_vacuum", BOTTOM)
        assert tool.arbiter.will == (LastWillStep(BOTTOM),)
        tool.arbiter.will = ()
        tool.program.arbiter_lost(ArbiterError("the connection broke."))
        tool.until(lambda _: tool.arbiter.will == (LastWillStep(BOTTOM),))

    def test_the_end_of_the_program_deactivates_whatever_is_declared_for_a_grip(
        self, description: Description
    ) -> None:
        gripping = description.endings.gripping.model_copy(update={"sigterm": "hold"})
        endings = description.endings.model_copy(update={"gripping": gripping})
        tool = Tool(description.model_copy(update={"endings": endings}))
        tool.program.start()
        tool.until(lambda status: status.ee == State.STAND_BY)
        drive(tool, "bottom_vacuum", BOTTOM)
        tool.program.close()
        assert tool.arbiter.parting == (LastWillStep(BOTTOM),)

    def test_a_write_without_an_answer_counts_as_driven(self, tool: Tool) -> None:
        """It was executed perhaps: the lease has to end it."""
        tool.arbiter.error = ArbiterError("the answer was lost.")
        assert not tool.program.set_actuator("bottom_vacuum", True).accepted
        tool.arbiter.active[BOTTOM] = ON
        tool.arbiter.error = None
        tool.until(lambda _: tool.arbiter.active[BOTTOM] is OFF)

    def test_a_lease_that_ends_without_an_arbiter_is_ended_when_it_is_back(self, tool: Tool) -> None:
        drive(tool, "cylinder", CYLINDER)
        tool.arbiter.error = ArbiterError("the line arbiter cannot be reached.")
        tool.until(lambda status: any("cannot be reached" in alarm for alarm in status.alarm_texts))
        assert tool.program.alive
        tool.arbiter.error = None
        tool.until(lambda status: not status.alarm_texts and not tool.arbiter.active[CYLINDER])

    def test_what_the_arbiter_refused_was_not_driven(self, tool: Tool) -> None:
        tool.arbiter.error = LineRefusedError("IL-13: the emergency stop is open.")
        assert tool.program.set_actuator("bottom_vacuum", True).reason.startswith("IL-13")
        tool.arbiter.error = None
        tool.frame()
        assert not tool.program.status.maintenance

    def test_a_call_that_no_sensor_proves_is_no_success(self, tool: Tool) -> None:
        answer = tool.program.set_actuator("bottom_vacuum", True, 0.05)
        assert not answer.accepted
        # UNKNOWN: this machine had no time for the frames
        assert answer.reason.replace("UNKNOWN", "GONE") == (
            "Bottom vacuum: its line is written, but its sensor does not prove it within 0.05 s (it says GONE). "
            "It stays active for 0.6 s at most."
        )

    @pytest.mark.parametrize("active", [True, False])
    def test_while_a_part_is_held_every_call_is_refused(self, tool: Tool, active: bool) -> None:
        tool.grip_to(2)
        tool.confirmed[TOP] = ON
        tool.until(lambda status: status.ee == State.GRIPPED)
        before = dict(tool.arbiter.active)
        expected = "IL-12: a part is held (GRIPPED): no maintenance, only a Drop releases it."
        assert tool.program.set_actuator("bottom_vacuum", active).reason == expected
        assert tool.arbiter.active == before

    def test_while_a_grip_runs_it_is_refused(self, tool: Tool) -> None:
        tool.grip_to(1)
        expected = "IL-12: maintenance is possible in STAND_BY only; the end-effector is GRIPPING."
        assert tool.program.set_actuator("top_vacuum", True).reason == expected
