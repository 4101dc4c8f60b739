"""A trace is there as far as it was written, whatever ends its writer, and says where it ends."""

from __future__ import annotations

import json
import os
import signal
import struct
import subprocess
import sys
import time
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import TraceWriter, read_trace
from end_effector_hal.recording._segment import MAGIC
from end_effector_hal.recording._trace_file import FOOTER_BYTES
from tests.support.places import ROOT


@dataclass
class Seen:
    at: int
    number: int
    text: str | None = None


KINDS = {"seen": Seen}
FILES = {"tool.json": b"{}", "model.xml": b"<nta/>"}


def written(folder: Path, count: int) -> TraceWriter:
    writer = TraceWriter(folder, KINDS, now=0, attachments=FILES)
    for number in range(count):
        writer.put([("seen", number, Seen(number, number, "é" * (number % 7)))])
    writer.close()
    return writer


def test_what_was_written_is_read(tmp_path: Path) -> None:
    found = read_trace(written(tmp_path / "new" / "folder", 5).path)
    assert (found.complete, found.note) == (True, "")
    assert [record.kind for record in found.records] == ["seen"] * 5
    assert [record.content["number"] for record in found.records] == [0, 1, 2, 3, 4]
    assert found.attachments == FILES


def test_a_second_trace_does_not_touch_the_first(tmp_path: Path) -> None:
    first = written(tmp_path, 3).path
    content = first.read_bytes()
    assert [written(tmp_path, 1).path.name for _ in range(2)] == ["hal-2.mcap", "hal-3.mcap"]
    assert first.read_bytes() == content


def test_cut_at_every_byte_it_is_read_up_to_there(tmp_path: Path) -> None:
    data = written(tmp_path, 5).path.read_bytes()
    whole = [record.data for record in read_trace(tmp_path / "hal.mcap").records]
    path = tmp_path / "cut.mcap"
    counts = set()
    for length in [*range(9), *range(data.index(b'{"at":0'), len(data))]:
        path.write_bytes(data[:length])
        found = read_trace(path)
        assert not found.complete or length >= len(data) - 8
        records = [record.data for record in found.records]
        assert records == whole[: len(records)]
        counts.add(len(records))
    assert counts == set(range(6))


def test_a_damaged_byte_never_ends_in_a_traceback(tmp_path: Path) -> None:
    data = written(tmp_path, 2).path.read_bytes()
    path = tmp_path / "damaged.mcap"
    for place in range(8, len(data), 3):
        path.write_bytes(data[:place] + bytes([data[place] ^ 0xFF]) + data[place + 1 :])
        read_trace(path)


def test_every_flipped_bit_of_what_was_recorded_is_found(tmp_path: Path) -> None:
    whole = written(tmp_path, 2).path
    data = whole.read_bytes()
    assert not read_trace(whole).damaged
    path = tmp_path / "flipped.mcap"
    places = range(8, len(data) - len(MAGIC))
    undetected = []
    for place in places:
        path.write_bytes(data[:place] + bytes([data[place] ^ 1 << place % 8]) + data[place + 1 :])
        found = read_trace(path)
        if not found.damaged and found.complete:  # else it is told anyhow
            undetected.append(place)
    assert len(places) > 300
    assert undetected == []


def test_one_that_was_not_closed_has_no_checksum(tmp_path: Path) -> None:
    data = written(tmp_path, 5).path.read_bytes()
    path = tmp_path / "cut.mcap"
    cut = data[: data.index(b'{"at":4')]
    path.write_bytes(cut.replace(b'"number":2', b'"number":7'))
    found = read_trace(path)
    assert (found.damaged, found.complete) == (False, False)
    assert "it was not closed" in found.note


@pytest.mark.parametrize("content", [b"\x89PNG", b"time_s,end_effector\n" * 3])
def test_what_is_no_trace_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(UsageError, match=r"x\.mcap"):
        read_trace(path)
    with pytest.raises(UsageError, match="No such file"):
        read_trace(tmp_path / "missing.mcap")


PROGRAM = """
import sys, time
from pathlib import Path
from tests.unit.recording.test_trace_file import FILES, KINDS, Seen
from end_effector_hal.recording import TraceWriter
writer = TraceWriter(Path(sys.argv[1]), KINDS, now=0, attachments=FILES)
for number in range(1_000_000):
    writer.put([("seen", number, Seen(number, number))])
    time.sleep(0.0005)
"""


def test_after_a_kill_everything_is_there_to_the_last_moments(tmp_path: Path) -> None:
    path = tmp_path / "hal.mcap"
    child = subprocess.Popen([sys.executable, "-c", PROGRAM, str(tmp_path)], cwd=ROOT)
    try:
        end = time.monotonic() + 60
        while not path.exists() or len(read_trace(path).records) < 50:
            assert child.poll() is None
            assert time.monotonic() < end
            time.sleep(0.05)
        seen = len(read_trace(path).records)
        os.kill(child.pid, signal.SIGKILL)
    finally:
        child.kill()
        child.wait()
    found = read_trace(path)
    assert len(found.records) >= seen
    assert [record.content["number"] for record in found.records] == list(range(len(found.records)))
    assert not found.complete
    assert "killed" in found.note


def test_a_robot_writes_traces_without_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the library would write them, but for the summary, which comes with the index."""
    with monkeypatch.context() as blocked:
        for name in ("", ".data_stream", ".opcode", ".records", ".stream_reader", ".writer"):
            blocked.setitem(sys.modules, f"mcap{name}", None)
        path = (writer := written(tmp_path, 5)).path
        writer.close()
    found = read_trace(path)
    assert (found.complete, found.damaged, found.note, len(found.records)) == (True, False, "", 5)
    assert dict(found.attachments) == FILES

    from mcap.records import Attachment, Channel, Header, Message, Schema
    from mcap.stream_reader import StreamReader
    from mcap.writer import CompressionType, Writer

    data, sink = path.read_bytes(), BytesIO()
    theirs = Writer(sink, use_chunking=False, compression=CompressionType.NONE, enable_data_crcs=True)
    for each in StreamReader(BytesIO(data), validate_crcs=True).records:
        if isinstance(each, Header):
            theirs.start(each.profile, each.library)
        elif isinstance(each, Attachment):
            theirs.add_attachment(each.create_time, each.log_time, each.name, each.media_type, each.data)
        elif isinstance(each, Schema):
            theirs.register_schema(each.name, each.encoding, each.data)
        elif isinstance(each, Channel):
            theirs.register_channel(each.topic, each.message_encoding, each.schema_id)
        elif isinstance(each, Message):
            theirs.add_message(each.channel_id, each.log_time, each.data, each.publish_time, each.sequence)
    theirs.finish()
    end = len(data) - FOOTER_BYTES - len(MAGIC)  # the checksum of the data stands before it
    assert sink.getvalue()[:end] == data[:end]


def test_viewers_get_schemas_that_they_understand(tmp_path: Path) -> None:
    """Plain types, no references: as Foxglove reads them."""
    from mcap.reader import make_reader

    from end_effector_hal.runtime.boundary import KINDS as ALL

    writer = TraceWriter(tmp_path, ALL, now=0, attachments={})
    writer.close()
    with writer.path.open("rb") as file:
        summary = make_reader(file).get_summary()
    topics = {channel.topic: summary.schemas[channel.schema_id] for channel in summary.channels.values()}
    assert {f"/hal/{kind}" for kind in ALL} == topics.keys()
    for schema in topics.values():
        assert schema.encoding == "jsonschema"
        text = schema.data.decode()
        assert json.loads(text)["type"] == "object"
        assert "$ref" not in text
        assert '"null"' not in text


def _with_chunk(path: Path, compression: bytes, data: bytes, size: int) -> Path:
    """A trace with nothing but a chunk."""
    header = b"".join(struct.pack("<I", len(text)) + text for text in (b"", b""))
    content = struct.pack("<QQQII", 0, 0, size, 0, len(compression)) + compression
    content += struct.pack("<Q", len(data)) + data
    records = b"".join(
        bytes([kind]) + struct.pack("<Q", len(each)) + each for kind, each in ((1, header), (6, content))
    )
    path.write_bytes(MAGIC + records + MAGIC)
    return path


@pytest.mark.parametrize("compression", [b"lz4", b"zstd"])
def test_compressed_records_are_refused_and_not_unpacked(tmp_path: Path, compression: bytes) -> None:
    """A page opens what it is given: 100 kB may become 4 GB."""
    found = read_trace(_with_chunk(tmp_path / "hal.mcap", compression, b"garbage", 1 << 40))
    assert (found.records, found.damaged) == ((), True)
    assert "records are compressed, as in no trace" in found.note


def test_a_chunk_without_compression_is_read_and_its_damage_told(tmp_path: Path) -> None:
    found = read_trace(_with_chunk(tmp_path / "hal.mcap", b"", b"\x05\xff\xff\xff\xff\0\0\0\0", 9))
    assert (found.records, found.damaged) == ((), True)
    assert "near byte" in found.note
