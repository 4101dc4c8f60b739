"""A damaged bag is refused in a sentence that names the tool that repairs it."""

from __future__ import annotations

import random
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import read_run, read_states
from end_effector_lab.bags import Bag, ImportedBag, import_bag
from tests.support.bags import STATE, frame, state, write_ros1, write_ros2
from tests.support.nightly import examples

S = 1_000_000
MESSAGES = [
    each
    for n in range(200)
    for each in (
        state(n * S, n * S, n % 2, count=n, alarms=["x" * 400]),
        *frame(n * S + 9, bottom=n),
    )
]


def imported(bag: Path, folder: Path, description: Description | None = None) -> ImportedBag:
    with closing(Bag(bag)) as opened:
        return import_bag(opened, folder, description=description)


def of_ros1(tmp_path: Path) -> Path:
    return write_ros1(tmp_path / "run.bag", MESSAGES * 12)


def of_mcap(tmp_path: Path) -> Path:
    return write_ros2(tmp_path / "run", MESSAGES * 12) / "run.mcap"


def of_sqlite(tmp_path: Path) -> Path:
    return write_ros2(tmp_path / "run", MESSAGES * 12, mcap=False) / "run.db3"


@pytest.mark.parametrize(
    ("write", "repair"),
    [(of_ros1, "`rosbag reindex`"), (of_mcap, "`mcap recover`"), (of_sqlite, "`ros2 bag reindex`")],
)
def test_a_file_that_was_cut_off_is_refused(
    tmp_path: Path, write: Callable[[Path], Path], repair: str
) -> None:
    bag = write(tmp_path)
    bag.write_bytes(bag.read_bytes()[:-300_000])
    with pytest.raises(UsageError, match=f"is damaged.*{repair}"):
        imported(bag, tmp_path / "imported")


def test_a_folder_whose_recorder_was_killed_is_refused(tmp_path: Path) -> None:
    folder = of_mcap(tmp_path).parent
    (folder / "metadata.yaml").unlink()
    with pytest.raises(UsageError, match=r"no metadata\.yaml.*`ros2 bag reindex`"):
        imported(folder, tmp_path / "imported")


def test_a_bag_that_ros1_was_still_writing_is_refused(tmp_path: Path) -> None:
    bag = of_ros1(tmp_path).rename(tmp_path / "run.bag.active")
    bag.write_bytes(bag.read_bytes()[:-300_000])
    with pytest.raises(UsageError, match=r"is damaged.*`rosbag reindex`"):
        imported(bag, tmp_path / "imported")


def test_a_message_that_was_overwritten_ends_the_import(tmp_path: Path, verdin: Description) -> None:
    bag = of_ros1(tmp_path)
    data = bytearray(bag.read_bytes())
    at = data.index(b"op=\x02", len(data) // 3)
    data[at : at + 30] = bytes(30)
    bag.write_bytes(data)
    with pytest.raises(UsageError, match="is damaged"):
        imported(bag, tmp_path / "imported", verdin)  # with the pressures, one of which it is


def test_a_database_without_definitions(tmp_path: Path) -> None:
    """As rosbag2 wrote it up to Humble."""
    import sqlite3

    folder = write_ros2(tmp_path / "run", MESSAGES, mcap=False)
    with closing(sqlite3.connect(folder / "run.db3")) as database:
        database.execute("DELETE FROM message_definitions")
        database.commit()
    with pytest.raises(UsageError, match="does not define the fields of end_effector_msgs/EndEffectorState"):
        imported(folder, tmp_path / "imported")


def test_a_database_whose_recorder_was_killed_is_refused(tmp_path: Path) -> None:
    folder = write_ros2(tmp_path / "run", MESSAGES, mcap=False)
    (folder / "run.db3-wal").write_bytes(b"x")
    for bag in (folder, folder / "run.db3"):
        with pytest.raises(UsageError, match=r"that its database does not hold.*`ros2 bag reindex`"):
            imported(bag, tmp_path / "imported")


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("run.txt", b"", "This is not a bag"),
        ("empty.bag", b"", "is damaged"),
        ("text.mcap", b"not a bag", "is damaged"),
        ("only_magic.mcap", b"\x89MCAP0\r\n", "is damaged"),
        ("only_magic.bag", b"#ROSBAG V2.0\n", "is damaged"),
        ("old.bag", b"#ROSBAG V1.2\n", "is damaged"),
        ("only_magic.db3", b"SQLite format 3\0", "is damaged"),
    ],
)
def test_what_is_no_bag(tmp_path: Path, name: str, data: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(UsageError, match=said):
        imported(tmp_path / name, tmp_path / "imported")


def test_places_where_no_bag_is(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="There is no such bag"):
        Bag(tmp_path / "nothing")
    with pytest.raises(UsageError, match="There is no bag in this folder"):
        Bag(tmp_path)
    (tmp_path / "metadata.yaml").write_text("{")
    with pytest.raises(UsageError, match="The bag is damaged"):
        Bag(tmp_path)


def test_a_definition_that_is_none(tmp_path: Path) -> None:
    bag = write_ros1(tmp_path / "run.bag", [state(S, 0)])
    bag.write_bytes(bag.read_bytes().replace(b"int64 at_us", b"int64 at-us"))
    with pytest.raises(
        UsageError, match="its definition of end_effector_msgs/EndEffectorState cannot be read"
    ):
        imported(bag, tmp_path / "imported")


def test_a_disk_that_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import resource

    bag = of_mcap(tmp_path)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, before[1]))  # a write fails, as on a full disk
    try:
        with pytest.raises(ReportedError, match="The import has ended early"):
            imported(bag, tmp_path / "imported")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert read_states(tmp_path / "imported" / "states.csv").rows


@pytest.mark.parametrize("kind", ["ros1", "mcap", "sqlite"])
def test_bytes_that_were_changed_anywhere(tmp_path: Path, kind: str) -> None:
    """Any bag is imported, or refused in a sentence."""
    few = MESSAGES[:20]
    bag = {
        "ros1": lambda: write_ros1(tmp_path / "run.bag", few),
        "mcap": lambda: write_ros2(tmp_path / "run", few) / "run.mcap",
        "sqlite": lambda: write_ros2(tmp_path / "run", few, mcap=False) / "run.db3",
    }[kind]()
    whole = bag.read_bytes()
    for seed in range(examples(60, 5_000)):
        chance = random.Random(seed)
        data = bytearray(whole)
        for _ in range(chance.choice((1, 3, 40))):
            data[chance.randrange(len(data))] = chance.randrange(256)
        if chance.random() < 0.5:
            del data[chance.randrange(len(data)) :]
        bag.write_bytes(data)
        folder = tmp_path / f"imported-{seed}"
        try:
            imported(bag, folder)
        except ReportedError as error:
            assert str(error)  # noqa: PT017 either is right
        else:
            read_states(folder / "states.csv")
            assert read_run(folder).note == ""


def test_the_type_of_a_state() -> None:
    assert STATE == "end_effector_msgs/msg/EndEffectorState"
