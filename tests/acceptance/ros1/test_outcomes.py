"""The numbers of an outcome have changed once: nobody reads those of one version by the other."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.places import ROOT

pytestmark = pytest.mark.ros
RULES = ROOT / "ros/end_effector_msgs/migrations/outcome_version_2.bmr"
OLD = Path(__file__).parent / "recordings/before_not_executed.bag"
OLD_CHECKSUM = "889c7c9d84ecc1aaf324572b20fcdc19"


def ends(path: Path) -> list[tuple[str, int, int]]:
    """Topic, status and outcome of each result in a bag."""
    import rosbag

    with rosbag.Bag(str(path)) as bag:
        return [(topic, each.status.status, each.result.outcome) for topic, each, _ in bag.read_messages()]


def test_a_client_with_the_other_numbers_is_not_connected() -> None:
    """ROS compares the checksums of both sides, and says so in the log of both."""
    from end_effector_msgs.msg import EndEffectorActionResult, EndEffectorResult

    assert EndEffectorResult.OUTCOME_VERSION == 2
    assert EndEffectorActionResult._md5sum != OLD_CHECKSUM


def test_an_old_recording_is_brought_up_to_date_by_its_version(tmp_path: Path) -> None:
    assert ends(OLD) == [
        ("/TriggerGrip/result", 3, 0),
        ("/TriggerGrip/result", 2, 2),
        ("/TriggerGrip/result", 8, 0),
        ("/Drop/result", 5, 1),
        ("/TriggerGrip/result", 4, 3),
        ("/TriggerGrip/result", 4, 4),
    ]
    old, new = shutil.copy(OLD, tmp_path), tmp_path / "new.bag"
    done = subprocess.run(
        ["rosbag", "fix", str(old), str(new), str(RULES)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert ends(new) == [
        ("/TriggerGrip/result", 3, 5),
        ("/TriggerGrip/result", 2, 2),
        ("/TriggerGrip/result", 8, 0),
        ("/Drop/result", 5, 1),
        ("/TriggerGrip/result", 4, 3),
        ("/TriggerGrip/result", 4, 4),
    ]


def test_the_rules_lead_to_the_messages_of_today() -> None:
    import genpy.dynamic
    from end_effector_msgs.msg import EndEffectorActionResult

    class MessageUpdateRule:
        pass

    names: dict[str, type] = {"MessageUpdateRule": MessageUpdateRule}
    exec(RULES.read_text(), names)  # noqa: S102 as rosbag does
    (rule,) = (each for name, each in names.items() if name.startswith("update_"))
    new = genpy.dynamic.generate_dynamic(rule.new_type, rule.new_full_text)[rule.new_type]
    old = genpy.dynamic.generate_dynamic(rule.old_type, rule.old_full_text)[rule.old_type]
    assert (old._md5sum, new._md5sum) == (OLD_CHECKSUM, EndEffectorActionResult._md5sum)


def test_a_recording_of_today_needs_no_change(tmp_path: Path) -> None:
    import rosbag
    from end_effector_msgs.msg import EndEffectorActionResult

    with rosbag.Bag(str(tmp_path / "today.bag"), "w") as bag:
        bag.write("/Drop/result", EndEffectorActionResult())
    done = subprocess.run(
        ["rosbag", "check", str(tmp_path / "today.bag"), str(RULES)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "does not need any migrations" in done.stdout, done.stdout + done.stderr
