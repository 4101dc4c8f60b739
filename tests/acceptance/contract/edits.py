"""Edits of the transport, each of which a check of the list must find.

``python -m tests.acceptance.contract.edits`` applies those of the generation of ROS that this environment has, each to
a copy of the source, and runs the checks that should notice. It prints the rows of the table in README.md; the exit
code is 1 when an edit was not found. ``make contract-edits`` runs both generations.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.acceptance.contract.hal import GENERATION
from tests.support.places import ROOT

CHECKS = Path(__file__).parent.relative_to(ROOT)
HAL = "src/end_effector_hal"
LONGEST_S = 600


@dataclass(frozen=True)
class Edit:
    """What is changed, in which generation it is tried, and the checks that should notice (file::check)."""

    name: str
    generation: int
    file: str
    old: str
    new: str
    checks: tuple[str, ...]

    def apply(self, folder: Path) -> None:
        """Change a copy of the source."""
        path = folder / HAL / self.file
        text = path.read_text(encoding="utf-8")
        if text.count(self.old) != 1:
            raise SystemExit(
                f"{self.file}: {self.old!r} stands there {text.count(self.old)} times: mend {__file__}."
            )
        path.write_text(text.replace(self.old, self.new), encoding="utf-8")


EDITS = (
    Edit(
        "no topic is latched", 1, "ros1/_messages.py",
        "latch=topic.latched", "latch=False",
        ("test_surface::test_a_topic_is_latched_or_not",),
    ),
    Edit(
        "a cancel is not passed on", 1, "ros1/_actions.py",
        "            super().internal_cancel_callback(GoalID(stamp, goal_id.id))\n", "",
        ("test_cancels::test_a_cancel_at_each_step_of_a_grip_unwinds_in_reverse_order",),
    ),
    Edit(
        "feedback is swallowed", 1, "ros1/_actions.py",
        "            super().publish_feedback(status, feedback)", "            pass",
        ("test_goals::test_the_feedback_of_a_grip_names_each_step_in_order",),
    ),
    Edit(
        "the type of a topic", 1, "nodes/interface/_table.py",
        '"PositionToolStand", "end_effector_msgs/ToolStandPosition"',
        '"PositionToolStand", "end_effector_msgs/ToolChangerPosition"',
        ("test_surface::test_a_topic_has_its_type_and_its_publishers",),
    ),
    Edit(
        "services leave their namespace", 1, "ros1/_ros_node.py",
        "rospy.Service(service.name, kind", 'rospy.Service(f"/{service.name}", kind',
        ("test_tools::test_every_name_moves_into_the_namespace",),
    ),
    Edit(
        "the reason of a result is lost", 1, "nodes/_goal_types.py",
        "reason=ending.reason", 'reason=""',
        ("test_goals::test_a_grip_while_gripped_is_refused",),
    ),
    Edit(
        "changes are not counted", 1, "nodes/_hal_main.py",
        "before, self._count = self._status, self._count + 1", "before = self._status",
        ("test_state::test_the_count_tells_changes_apart_from_repetitions",),
    ),
    Edit(
        "held is lost with a HAL that is silent", 1, "nodes/_hal_main.py",
        "held=status.held,", "held=status.held and status.link_up,",
        ("test_served::test_a_hal_that_dies_is_an_alarm_until_it_is_back",),
    ),
    Edit(
        "the last state is not OFF", 1, "nodes/_hal_main.py",
        "        node.on_close(self._close)\n", "",
        ("test_nodes::test_a_node_ends_in_good_order_and_what_is_held_stays_held",),
    ),
    Edit(
        "a writer is as deep as its readers", 2, "ros2/_messages.py",
        "1 if topic.latched else topic.queue", "topic.queue",
        ("test_state::test_a_late_joiner_first_sees_that_a_part_is_held",),
    ),
    Edit(
        "a late joiner hears all that a writer has kept", 2, "ros2/_messages.py",
        "1 if topic.latched else topic.queue", "20 if topic.latched else topic.queue",
        ("test_state::test_a_late_joiner_sees_no_old_held",),
    ),
    Edit(
        "no topic is transient local", 2, "ros2/_messages.py",
        "DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE", "DurabilityPolicy.VOLATILE",
        ("test_surface::test_a_topic_is_latched_or_not",),
    ),
    Edit(
        "every cancel is taken", 2, "ros2/_actions.py",
        "CancelResponse.ACCEPT if taken else CancelResponse.REJECT", "CancelResponse.ACCEPT",
        ("test_cancels::test_a_cancel_of_a_drop_changes_nothing",),
    ),
    Edit(
        "feedback is swallowed", 2, "ros2/_actions.py",
        "        self._server.run(lambda: self._handle.publish_feedback(message))", "        del message",
        ("test_goals::test_the_feedback_of_a_grip_names_each_step_in_order",),
    ),
    Edit(
        "a refused goal succeeds", 2, "ros2/_actions.py",
        "if ending.outcome is Outcome.SUCCEEDED:", "if ending.outcome in (Outcome.SUCCEEDED, Outcome.REJECTED):",
        ("test_goals::test_a_grip_while_gripped_is_refused",),
    ),
    Edit(
        "the reason of a result is lost", 2, "ros2/_messages.py",
        "        for name, convert in self._converters.items():\n",
        "        for name, convert in self._converters.items():\n"
        '            if name == "reason":\n                continue\n',
        ("test_goals::test_a_grip_while_gripped_is_refused",),
    ),
    Edit(
        "topics leave their namespace", 2, "ros2/_messages.py",
        "node.create_publisher(kind, topic.name,",
        "node.create_publisher(kind, '/' + topic.name.lstrip('/'),",
        ("test_tools::test_every_name_moves_into_the_namespace",),
    ),
    Edit(
        "each message has a stamp of its own", 2, "ros2/_messages.py",
        "            self._last = header.at_us, stamp\n", "",
        ("test_state::test_what_one_frame_brought_has_one_stamp",),
    ),
    Edit(
        "parameters can be set", 2, "ros2/_ros_node.py",
        "read_only=True", "read_only=False",
        ("test_services::test_another_tool_cannot_be_named_while_a_node_runs",),
    ),
    Edit(
        "more goals are kept than there is room for", 2, "ros2/_actions.py",
        "if len(self._open) >= OPEN:", "if len(self._open) >= 10 * OPEN:",
        ("test_served::test_more_goals_than_are_kept_are_refused_in_words",),
    ),
)  # fmt: skip


def failed(source: Path, checks: Iterable[str]) -> list[str]:
    """The first of these checks that fails with a source."""
    names = [str(CHECKS / each.replace("::", ".py::", 1)) for each in checks]
    path = os.pathsep.join((str(source / "src"), *filter(None, [os.environ.get("PYTHONPATH")])))
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-rfE", "-p", "no:cacheprovider", *names],
        cwd=ROOT, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=LONGEST_S,
        check=False,
    )  # fmt: skip
    if done.returncode not in (0, 1):
        raise SystemExit(done.stdout + done.stderr)
    return re.findall(r"^(?:FAILED|ERROR) \S*/(\S+?\.py::\S+)", done.stdout, re.MULTILINE)


def copied() -> Iterator[Path]:
    """A copy of the source."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder)
        shutil.copytree(ROOT / "src", source / "src", ignore=shutil.ignore_patterns("__pycache__"))
        yield source


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", help="edits whose names have these words")
    parser.add_argument(
        "--unedited", action="store_true", help="first see these checks pass on a copy without an edit"
    )
    options = parser.parse_args()
    edits = [each for each in EDITS if each.generation == GENERATION and (options.only or "") in each.name]
    if options.unedited:
        for source in copied():
            if found := failed(source, sorted({check for each in edits for check in each.checks})):
                raise SystemExit(f"without an edit fails {found[0]}")
    missed = 0
    for edit in edits:
        for source in copied():
            edit.apply(source)
            found = failed(source, edit.checks)
        missed += not found
        by = f"`{found[0]}`" if found else "**nothing**"
        sys.stdout.write(f"| {edit.name} | {edit.generation} | `{edit.file}` | {by} |\n")
        sys.stdout.flush()
    return bool(missed)


if __name__ == "__main__":
    sys.exit(main())
