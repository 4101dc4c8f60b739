"""Bags that are cut off, changed or no bags: what can be read is imported, the rest is told, and nothing is raised."""

from __future__ import annotations

import bz2
import random
import tracemalloc
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType
from rosbags.rosbag2 import CompressionMode

from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import read_run, read_states
from end_effector_lab.bags import ImportedBag, _unpack, import_bag, open_bag
from tests.support.bags import STATE, frame, state, write_mcap, write_ros1, write_ros2
from tests.support.nightly import examples

S = 1_000_000
MESSAGES = [
    each
    for n in range(200)
    for each in (
        state(n * S, n * S, n % 2, count=n, alarms=["x" * 400]),
        frame(n * S + 9, n * S + 9, bottom=n),
    )
]


def imported(bag: Path, folder: Path) -> ImportedBag:
    with closing(open_bag(bag)) as opened:
        return import_bag(opened, folder)


def of_mcap(tmp_path: Path) -> Path:
    return write_ros2(tmp_path / "run", MESSAGES * 12) / "run.mcap"


def test_an_mcap_that_was_cut_off_is_read_up_to_there(tmp_path: Path) -> None:
    """Its recorder was killed: neither an index nor metadata.yaml is there."""
    bag = of_mcap(tmp_path)
    (bag.parent / "metadata.yaml").unlink()
    bag.write_bytes(bag.read_bytes()[:-300_000])
    found = imported(bag.parent, tmp_path / "imported")
    assert 100 < found.states < 2_400
    assert len(found.faults) == 1
    assert "what follows is lost: it was not closed" in found.faults[0]
    assert read_run(found.folder).gaps[-1] == found.faults[0]
    assert len(read_states(found.folder / "states.csv").rows) > 100


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD, CompressionType.LZ4])
def test_an_mcap_whose_bytes_were_changed_loses_a_chunk_only(
    tmp_path: Path, compression: CompressionType
) -> None:
    bag = write_mcap(tmp_path / "run.mcap", MESSAGES, compression)
    assert imported(bag, tmp_path / "whole").states == 200
    with bag.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    chunk = summary.chunk_indexes[len(summary.chunk_indexes) // 2]
    data = bytearray(bag.read_bytes())
    data[chunk.chunk_start_offset + chunk.chunk_length - 20] ^= 0x10
    bag.write_bytes(data)
    found = imported(bag, tmp_path / "imported")
    assert 180 < found.states < 200
    assert len(found.faults) == 1
    assert "1 chunks cannot be read (" in found.faults[0]
    assert any("changes of the state are not in the bag" in gap for gap in read_run(found.folder).gaps)


def test_a_chunk_that_was_changed_loses_its_messages_only(tmp_path: Path) -> None:
    whole = imported(write_ros1(tmp_path / "whole.bag", MESSAGES * 5), tmp_path / "whole")
    bag = write_ros1(tmp_path / "run.bag", MESSAGES * 5)
    data = bytearray(bag.read_bytes())
    at = data.index(b"op=\x02", len(data) // 3)  # of a message
    data[at : at + 30] = bytes(30)
    bag.write_bytes(data)
    found = imported(bag, tmp_path / "imported")
    assert 0 < found.states < whole.states
    assert any("1 chunks cannot be read to their end" in fault for fault in found.faults)


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_a_chunk_of_mcap_that_would_fill_the_memory_is_left_out(
    tmp_path: Path, compression: CompressionType, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = write_mcap(
        tmp_path / "run.mcap", [*MESSAGES, state(300 * S, 300 * S, alarms=["x" * 2**20])], compression
    )
    monkeypatch.setattr(_unpack, "UNPACKED_BYTES", 2**20)
    found = imported(bag, tmp_path / "imported")
    assert 100 < found.states <= 200
    assert "1 chunks cannot be read (ValueError: it unpacks to more than 1 MiB" in found.faults[0]


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_a_chunk_of_ros1_that_would_fill_the_memory_is_left_out(
    tmp_path: Path, compression: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    long = state(300 * S, 300 * S, alarms=["x" * 2**20])
    bag = write_ros1(tmp_path / "run.bag", [*MESSAGES, long], compression=compression)
    assert imported(bag, tmp_path / "whole").states == 201
    monkeypatch.setattr(_unpack, "UNPACKED_BYTES", 2**20)
    if compression == "none":  # such a chunk is never longer than its file
        assert imported(bag, tmp_path / "imported").states == 201
        return
    with pytest.raises(UsageError, match=r"cannot be read to their end .*it unpacks to more than 1 MiB"):
        imported(bag, tmp_path / "imported")


def test_a_compressed_message_that_would_fill_the_memory_ends_the_reading(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    long = state(300 * S, 300 * S, alarms=["x" * 2**20])
    bag = write_ros2(tmp_path / "run", [*MESSAGES, long], mcap=False, compression=CompressionMode.MESSAGE)
    assert imported(bag, tmp_path / "whole").states == 201
    monkeypatch.setattr(_unpack, "UNPACKED_BYTES", 2**20)
    found = imported(bag, tmp_path / "imported")
    assert found.states == 200
    assert "what follows is lost (ValueError: it unpacks to more than 1 MiB)" in found.faults[0]


PACK: dict[str, Callable[[bytes], bytes]] = {
    "zstd": zstandard.compress,
    "lz4": lz4.frame.compress,
    "bz2": bz2.compress,
}


@pytest.mark.parametrize("compression", PACK)
def test_what_is_unpacked_never_takes_more_memory_than_the_limit(
    compression: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    packed = PACK[compression](bytes(32 * 2**20))
    monkeypatch.setattr(_unpack, "UNPACKED_BYTES", 2**20)
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="unpacks to more than 1 MiB"):
            _unpack.unpack(compression, packed)
        assert tracemalloc.get_traced_memory()[1] < 4 * 2**20
    finally:
        tracemalloc.stop()
    assert _unpack.unpack(compression, PACK[compression](b"some")) == b"some"


def test_several_files_of_a_bag_are_read_in_their_order(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    folder.mkdir()
    for n in (0, 1, 2, 10):
        part = write_ros2(tmp_path / f"part{n}", [state((n + 1) * S, n * S, n % 3, count=n)])
        (part / f"part{n}.mcap").rename(folder / f"bag_{n}.mcap")
    found = imported(folder, tmp_path / "imported")
    assert [row.time_s for row in read_states(found.folder / "states.csv").rows] == [0.0, 1.0, 2.0, 10.0]


@pytest.mark.parametrize(
    ("left", "least", "most"),
    [
        (0.4, 800, 1_100),
        pytest.param(0.8, 1_700, 2_100, marks=pytest.mark.nightly),
        pytest.param(0.999, 2_400, 2_400, marks=pytest.mark.thinned),
    ],
)
def test_a_bag_of_ros1_that_was_cut_off_is_read_up_to_there(
    tmp_path: Path, left: float, least: int, most: int
) -> None:
    bag = write_ros1(tmp_path / "run.bag", MESSAGES * 12)
    bag.write_bytes(bag.read_bytes()[: int(bag.stat().st_size * left)])
    found = imported(bag, tmp_path / "imported")
    assert least <= found.states <= most
    assert "it has no index: it was not closed, or was cut off" in found.faults[0]


def test_a_database_without_definitions(tmp_path: Path) -> None:
    """As rosbag2 wrote it up to Humble."""
    import sqlite3

    folder = write_ros2(tmp_path / "run", MESSAGES, mcap=False)
    with closing(sqlite3.connect(folder / "run.db3")) as database:
        database.execute("DELETE FROM message_definitions")
        database.commit()
    with pytest.raises(
        UsageError, match="does not say what the fields of end_effector_msgs/EndEffectorState are"
    ):
        imported(folder, tmp_path / "imported")


def test_a_database_whose_recorder_was_killed(tmp_path: Path) -> None:
    folder = write_ros2(tmp_path / "run", MESSAGES, mcap=False)
    (folder / "metadata.yaml").unlink()
    (folder / "run.db3-wal").write_bytes(b"x")
    found = imported(folder, tmp_path / "imported")
    assert found.states == 200
    assert "holds messages that its database has not" in found.faults[0]


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("empty.bag", b"", "This is no bag"),
        ("text.mcap", b"not a bag", "This is no bag"),
        ("only_magic.mcap", b"\x89MCAP0\r\n", "no states of an end-effector: it has no topics"),
        ("only_magic.bag", b"#ROSBAG V2.0\n", "it has no topics.* it has no index"),
        ("old.bag", b"#ROSBAG V1.2\n", "Only bags that begin with #ROSBAG V2.0"),
        ("only_magic.db3", b"SQLite format 3\0", "cannot be read"),
    ],
)
def test_what_is_no_bag(tmp_path: Path, name: str, data: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(UsageError, match=said):
        imported(tmp_path / name, tmp_path / "imported")


def test_places_where_no_bag_is(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="There is no such bag"):
        open_bag(tmp_path / "nothing")
    with pytest.raises(UsageError, match="There is no bag in this folder"):
        open_bag(tmp_path)
    (tmp_path / "metadata.yaml").write_text("{")
    with pytest.raises(UsageError, match="The bag cannot be read"):
        open_bag(tmp_path)


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
    """Whatever stands in a bag, it is imported as far as it goes, or refused in a sentence."""
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
