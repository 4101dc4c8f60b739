"""A recording shows at each moment what the live page showed then; what is damaged is told, and the rest is shown."""

from __future__ import annotations

import json
import re
import shutil
from bisect import bisect_right
from itertools import accumulate
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from pydantic_core import to_json

from end_effector_hal.cli._main import eehal
from end_effector_hal.cli.recorded import open_recordings
from end_effector_hal.codecs import carrier_of, load_tool
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.page.recorded import (
    RecordedTables,
    RecordingFiles,
    RecordingPart,
    judge_recording,
    read_recording,
)
from end_effector_hal.page.recorded import _document as document_module
from end_effector_hal.page.recorded import _files as files_module
from end_effector_hal.recording import Recording, RecordingLimits
from end_effector_hal.runtime.boundary import open_recorder
from end_effector_hal.signals import Kind
from end_effector_lab.commands import _report as report_module
from end_effector_lab.recorded import report_html
from tests.support.bags import COMMAND, frame, state, write_ros1
from tests.support.recorded_tool import RecordedTool
from tests.unit.page.test_tool_view import Watched

Json = dict[str, Any]


def plain(content: object) -> Any:
    return json.loads(to_json(content, fallback=dict))


def read(path: Path, part: RecordingPart | None = None) -> Json:
    found: Json = plain(read_recording(RecordingFiles(path), part).document)
    return found


def moment(document: Json, at: int) -> Json:
    """What the browser shows at ``at`` µs, by path."""
    number = bisect_right(document["times"], at - document["drawn"]["epoch"]) - 1
    shown = {}
    for path, (steps, values) in document["tracks"].items():
        index = bisect_right(list(accumulate(steps)), number) - 1
        if index >= 0:
            shown[path] = values[index]
    return shown


class WatchedAndRecorded(Watched):
    """A live page, and a recording of the same run."""

    def __init__(self, description: Description, folder: Path, scenario: str) -> None:
        writer = open_recorder(folder, description, at=0)._writer
        assert writer is not None
        self.writer = writer
        self.seen: list[tuple[int, Json]] = []
        super().__init__(description, scenario)

    def put(self, kind: str, at: int, content: object) -> None:
        self.writer.put([(kind, at, content)])
        super().put(kind, at, content)

    def look(self, seconds: float) -> None:
        self.tool.run(seconds)
        self.seen.append((self.tool.at, plain(self.view.moment())))

    def close(self) -> None:
        self.writer.close()


def test_each_moment_is_what_the_live_page_showed_then(verdin: Description, tmp_path: Path) -> None:
    run = WatchedAndRecorded(verdin, tmp_path, "fails-once:cylinder")
    for word, looks in ((None, 5), ("grip", 30), ("lock", 1), ("drop", 12)):
        if word:
            run.tool.run(0.003)  # the instant that was looked at is over
            run.tool.command(word)
        for _ in range(looks):
            run.look(0.317)
    run.close()
    document = read(tmp_path)
    assert document["recording"]["whole"]
    words = set()
    for at, live in run.seen:
        shown = moment(document, at)
        words.add(live["state"]["word"])
        assert {name: shown[f"state.{name}"] for name in live["state"]} == live["state"]
        assert [shown[f"interlocks.{number}"] for number in range(13)] == live["interlocks"]
        assert {name: shown[f"automata.{name}"] for name in live["automata"]} == live["automata"]
        for number, card in enumerate(live["cards"]):
            for name, value in card.items():
                expected = round(value, 1) if name == "margin_kpa" and value is not None else value
                if name == "values":
                    expected = [None if each is None else round(each, 1) for each in value]
                assert shown[f"cards.{number}.{name}"] == expected, (at, number, name)
    assert words == {"STAND_BY", "GRIPPING", "GRIPPED", "RELEASING"}
    live_log = [entry for entry in run.view.log.entries if entry["kind"] != "page"]
    recorded = [entry for entry in document["log"] if "begins" not in entry["text"]]
    assert sorted(each["text"] for each in recorded) == sorted(each["text"] for each in live_log)
    assert document["drawn"]["source"] == "end_effector.yaml"  # no path: the report may be mailed
    goal, drop = document["summary"]["goals"]
    assert (goal["what"], goal["outcome"], goal["at_most_s"]) == (
        "Grip",
        "GRIPPED",
        verdin.durations.grip_ms / 1000,
    )
    assert goal["why"] == ["Cylinder, attempt 1 of 3: timed out after 5.00 s"]
    assert (drop["what"], drop["outcome"], drop["ok"]) == ("Drop", "STAND_BY", True)


@pytest.fixture(scope="module")
def grip(verdin: Description, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A grip that fails, in segments."""
    limits = RecordingLimits(segment_bytes=110_000, total_bytes=100_000_000)
    short = verdin.actuators["cylinder"].model_copy(update={"timeout_s": 2.5})
    description = verdin.model_copy(update={"actuators": {**verdin.actuators, "cylinder": short}})
    folder = tmp_path_factory.mktemp("run")
    tool = RecordedTool(folder, "never-confirms:cylinder", description=description, limits=limits)
    tool.run(1.5)
    assert tool.command("grip").accepted
    tool.run(12.0)
    tool.close()
    assert (tool.folder / "hal-3.mcap").exists()
    return tool.folder


@pytest.fixture
def copy(grip: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(grip, tmp_path / "run"))


def test_why_a_grip_failed_is_told_in_words(grip: Path) -> None:
    told = read(grip)["summary"]
    assert told["story"].startswith("Cylinder never confirmed: grip ABORTED after 3 attempts")
    failed = told["goals"][0]
    assert (failed["outcome"], failed["ok"]) == ("ABORTED", False)
    assert [why.partition(":")[0] for why in failed["why"][:3]] == [
        f"Cylinder, attempt {number} of 3" for number in (1, 2, 3)
    ]
    assert 0 < failed["took_s"] < failed["at_most_s"]
    assert judge_recording(RecordingFiles(grip))["ok"]


def test_a_trace_that_was_cut_off_is_shown_up_to_there(copy: Path) -> None:
    last = copy / "hal-3.mcap"
    last.write_bytes(last.read_bytes()[:-20_000])
    document = read(copy)
    (note,) = document["recording"]["notes"]
    assert note.startswith("hal-3.mcap is not whole: it was not closed")
    assert not document["recording"]["whole"]
    assert any("Cylinder PENDING EXTEND" in entry["text"] for entry in document["log"])


def test_a_record_that_cannot_be_read_ends_its_file_and_no_other(copy: Path) -> None:
    """Its bytes are valid JSON, and no frame."""
    second = copy / "hal-2.mcap"
    data = second.read_bytes()
    place = data.index(b'"device_ms"', len(data) // 2)
    second.write_bytes(data[:place] + b'"Xevice_ms"' + data[place + 11 :])
    files = RecordingFiles(copy)
    document = plain(read_recording(files).document)
    notes = " ".join(document["recording"]["notes"])
    assert "hal-2.mcap is damaged: bytes in it were changed" in notes
    assert "(frame) cannot be read" in notes
    assert "What follows in this file is not shown." in notes
    assert any("breaks off" in entry["text"] for entry in document["log"])
    # the third segment begins with the state of the program: from there on it is shown again; how the grip ended
    # was recorded in what cannot be read
    assert document["summary"]["goals"][0]["outcome"] == "UNFINISHED"
    verdict = judge_recording(files)
    assert not verdict["ok"]
    assert "hal-2.mcap" in verdict["text"]


def test_a_trace_of_another_description_is_left_out(copy: Path, verdin: Description, tmp_path: Path) -> None:
    actuator = verdin.actuators["cylinder"].model_copy(update={"attempts": 2})
    other = verdin.model_copy(update={"actuators": {**verdin.actuators, "cylinder": actuator}})
    tool = RecordedTool(tmp_path / "other", description=other)
    tool.run(1.0)
    tool.close()
    shutil.copy(tool.folder / "hal.mcap", copy / "hal-9.mcap")
    document = read(copy)
    (note,) = document["recording"]["notes"]
    assert note.startswith("Left out: hal-9.mcap, which is of another description (verdin_gripper, ")
    assert document["summary"]["goals"][0]["outcome"] == "ABORTED"


def test_a_file_that_is_no_trace_is_left_out_and_told(copy: Path) -> None:
    (copy / "hal-8.mcap").write_bytes(b"nothing of the kind")
    document = read(copy)
    assert "This is not an MCAP file." in document["recording"]["notes"][0]
    assert document["summary"]["goals"]


def test_what_is_no_recording_is_refused_in_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UsageError, match="There is no trace here"):
        RecordingFiles(tmp_path)
    (tmp_path / "hal.mcap").write_bytes(b"nothing of the kind")
    with pytest.raises(UsageError, match="This is not an MCAP file"):
        RecordingFiles(tmp_path)
    monkeypatch.setattr(files_module, "MOST_BYTES", 10)
    with pytest.raises(UsageError, match="at most 0 MB are read"):
        RecordingFiles(tmp_path)


def test_a_recording_that_grows_is_noticed(copy: Path) -> None:
    files = RecordingFiles(copy)
    assert not files.grown
    with (copy / "hal-3.mcap").open("ab") as last:
        last.write(b"more")
    assert files.grown


def test_a_part_of_a_recording_stands_where_the_whole_stands(grip: Path) -> None:
    whole_one, part = read(grip), read(grip, RecordingPart(5.0, 9.0))
    assert (part["recording"]["begin_s"], part["recording"]["end_s"]) == (5.0, 9.0)
    assert len(part["times"]) < len(whole_one["times"]) / 2
    assert moment(part, 7_000_000) == moment(whole_one, 7_000_000)
    assert all(5e6 <= entry["at"] <= 9e6 for entry in part["log"])
    assert part["samples"][0][0] >= 5000
    assert part["samples"][0][-1] <= 9000


def test_the_size_of_a_document_is_bounded(grip: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(document_module, "MOST_STEPS", 100)
    coarse = read(grip)
    assert coarse["recording"]["step_s"] == pytest.approx(0.135)
    events = {entry["at"] for entry in coarse["log"]}
    assert len(coarse["times"]) < 110 + 2 * len(events)
    # each event has a moment of its own all the same
    assert {at - coarse["drawn"]["epoch"] for at in events if at} <= set(coarse["times"])
    monkeypatch.setattr(document_module, "MOST_MOMENTS", 40)
    ended = read(grip)
    assert len(ended["times"]) == 40
    assert "Too many events for one page" in ended["recording"]["notes"][-1]


def test_a_spike_between_two_samples_is_drawn() -> None:
    from end_effector_hal.page.recorded._samples import Samples
    from end_effector_hal.page.view import Curve

    samples = Samples([Curve("cup", "cup", "Cup", "kPa", most=100.0)], 0, 100_000)
    for number in range(50):
        samples.take([number * 20_000, 80.0 if number == 22 else 1.0])
    samples.flush()
    assert max(samples.columns[1]) == 80.0
    assert len(samples.columns[0]) < 15


def test_nothing_in_a_report_ends_its_data(grip: Path) -> None:
    document = read(grip)
    document["log"][0]["text"] = "</script><script>alert(1)</script><!--"
    document["recording"]["name"] = "<img src=x onerror=alert(1)>"
    html = report_html("<b>run</b>", [document], [judge_recording(RecordingFiles(grip))])
    assert html.count("</script>") == 3
    assert "alert(1)<" not in html
    assert "<img" not in html
    assert "&lt;b&gt;run&lt;/b&gt;" in html
    assert "http" not in html.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "").replace(
        "https://github.com/leeoniya/uPlot", ""
    )


def test_the_command_writes_one_file(grip: Path, copy: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.html"
    ran = CliRunner().invoke(eehal, ["report", str(grip), "-o", str(out)])
    assert (ran.exit_code, ran.output.splitlines()[0]) == (0, str(out))
    assert "Cylinder never confirmed" in ran.output
    assert out.read_text().startswith("<!doctype html>")
    last = copy / "hal-3.mcap"
    last.write_bytes(last.read_bytes()[:-20_000])
    ran = CliRunner().invoke(eehal, ["report", str(copy), "-o", str(out)])
    assert ran.exit_code == 1
    assert "Note: hal-3.mcap is not whole" in ran.output
    told = CliRunner().invoke(eehal, ["report", str(grip), str(copy), "-o", str(out), "--json"])
    document = json.loads(told.stdout)
    assert (told.exit_code, document["ok"], document["exit_code"], document["file"]) == (
        1,
        False,
        1,
        str(out),
    )
    whole, cut = document["recordings"]
    assert (whole["replay_ok"], whole["notes"]) == (True, [])
    assert "Cylinder never confirmed" in whole["story"]
    assert any("hal-3.mcap is not whole" in note for note in cut["notes"])
    refused = CliRunner().invoke(eehal, ["report", str(tmp_path / "nowhere")])
    assert isinstance(refused.exception, UsageError)


def test_a_folder_of_runs_is_one_file_with_their_table(grip: Path, tmp_path: Path) -> None:
    """One that is torn, or has no description, stands in the table with its reason; the others are in the file."""
    runs, out = tmp_path / "runs", tmp_path / "out.html"
    for name in ("a", "b/deep", "cut", "torn"):
        shutil.copytree(grip, runs / name)
    shutil.copy(grip / "hal.mcap", runs / "b" / "deep" / "other.txt")
    last = runs / "cut" / "hal-3.mcap"
    last.write_bytes(last.read_bytes()[:-20_000])
    for trace in (runs / "torn").glob("*.mcap"):
        trace.write_bytes(trace.read_bytes()[:1000])
    (runs / "tables").mkdir()
    (runs / "tables" / "states.csv").write_text("time_s,end_effector,command,<b>cup\n0.0,6,-1,0\n")
    ran = CliRunner().invoke(eehal, ["report", str(runs), "-o", str(out)])
    assert ran.exit_code == 1
    assert "b/deep: Cylinder never confirmed: grip ABORTED after 3 attempts" in ran.output
    assert "torn: Cannot be read: The trace ends after 1000 bytes" in ran.output
    assert "Note, cut: hal-3.mcap is not whole" in ran.output
    html = out.read_text()
    found = {
        name: json.loads(text)
        for name, text in re.findall(r'<script type="application/json" id="([\w-]+)">(.*?)</script>', html)
    }
    assert list(found) == ["index", "run-0", "run-1", "run-2"]
    rows = {row["name"]: row for row in found["index"]}
    assert list(rows) == ["a", "b/deep", "cut", "tables", "torn"]
    assert [row["ok"] for row in rows.values()] == [True, True, False, False, False]
    assert rows["cut"]["replay"].endswith("It is not whole.")
    assert "Name it: --description FILE." in rows["tables"]["story"]
    assert found["run-1"]["contents"][0]["recording"]["name"] == "deep"
    assert str(tmp_path) not in html  # it may be mailed


def test_a_file_of_runs_is_bounded(grip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_module, "MOST_RUNS", 1)
    runs, out = tmp_path / "runs", tmp_path / "out.html"
    for name in ("a", "b"):
        shutil.copytree(grip, runs / name)
    ran = CliRunner().invoke(eehal, ["report", str(runs), "-o", str(out), "--json"])
    first, second = json.loads(ran.stdout)["recordings"]
    assert (ran.exit_code, first["replay_ok"], second["replay_ok"]) == (1, True, None)
    assert second["story"].startswith("Not read: one file holds")
    assert 'id="run-1"' not in out.read_text()


def test_a_page_of_a_folder_of_runs_says_what_to_name(grip: Path, tmp_path: Path) -> None:
    shutil.copytree(grip, tmp_path / "runs" / "a")
    for words in (
        ("page", "runs"),
        ("report", "runs", "runs/a"),
    ):
        ran = CliRunner().invoke(eehal, [each.replace("runs", str(tmp_path / "runs")) for each in words])
        assert isinstance(ran.exception, UsageError)
        assert "This folder is not a recording: it contains 1 of them." in str(ran.exception), words


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["page", "DESCRIPTION", "DESCRIPTION"], "One description is shown at a time."),
        (["page", "DESCRIPTION", "--from", "3"], "--from, --to and --description are for recordings."),
        (["page", "RUN", "RUN", "RUN"], "3 recordings cannot be compared."),
        (["page", "RUN", "--from", "3", "--to", "2"], "--to 2 is not after --from 3."),
    ],
)  # fmt: skip
def test_what_the_page_cannot_show_is_refused(grip: Path, words: list[str], why: str) -> None:
    named = [str(grip) if word == "RUN" else word for word in words]
    refused = CliRunner().invoke(eehal, named)
    assert isinstance(refused.exception, UsageError)
    assert why in str(refused.exception)


def test_a_recording_is_read_again_when_it_has_grown(copy: Path) -> None:
    import asyncio

    from end_effector_hal.page.web._recordings import ServedRecording

    async def twice() -> tuple[Json, Json]:
        served = ServedRecording(RecordingFiles(copy / "hal.mcap"), RecordingPart())
        first = json.loads(await served.document())
        served.refresh()
        assert served.document().done(), "it is not read again while it is the same"
        shutil.copy(copy / "hal-2.mcap", copy / "hal.mcap")
        assert served.document().done(), "nor for those who look at it already"
        served.refresh()
        return first, json.loads(await served.document())

    first, second = asyncio.run(twice())
    assert first["recording"]["end_s"] != second["recording"]["end_s"] or first["log"] != second["log"]


def bag(path: Path) -> Path:
    """A grip of a second, as ROS carried it."""
    pressures = {"bottom": -500, "cylinder": 2_000, "top": None, "supply": 600_000}
    return write_ros1(path, [
        state(10_000_000, 0),
        *frame(20_000, **pressures),
        state(12_000_000, 2_000_000, 1, command=2, actuators=[1, 0, 0], count=1, alarms=["Frames are late: 3."]),
        *frame(2_020_000, **{**pressures, "bottom": -60_000}),
        state(13_000_000, 3_000_000, 3, actuators=[2, 2, 2], count=2),
        *frame(3_020_000, **{**pressures, "bottom": -80_000}),
    ])  # fmt: skip


def test_a_bag_is_shown_as_far_as_it_goes(tmp_path: Path, verdin: Description) -> None:
    source = bag(tmp_path / "lift.bag")
    (opened,) = open_recordings([source], Path(verdin.source))
    document = plain(read_recording(opened).document)
    assert document["recording"]["name"] == "lift.bag"
    assert document["recording"]["notes"][0].startswith("There is no trace:")
    shown = moment(document, 2_500_000)
    assert (shown["state.word"], shown["state.held"], shown["state.lift_allowed"]) == ("GRIPPING", None, None)
    assert [each["text"] for each in shown["state.alarms"]] == ["Frames are late: 3."]
    assert [shown[f"cards.{number}.state"] for number in range(3)] == ["PENDING ON", "RETRACTED", "OFF"]
    assert (shown["cards.0.values"], shown["cards.2.values"], shown["cards.0.output"]) == (
        [60.0],
        [None],
        None,
    )
    assert "interlocks.0" not in shown
    assert [entry["text"] for entry in document["log"] if entry["kind"] != "alarm"][-2:] == [
        "State GRIPPED; Bottom vacuum ON; Cylinder EXTENDED; Top vacuum ON", "Frames are late: 3."
    ]  # fmt: skip
    assert document["summary"]["goals"][0]["outcome"] == "GRIPPED"
    assert judge_recording(opened)["text"] == "Replay and monitor: there is no trace to judge."


def test_a_bag_that_cannot_be_shown_says_what_it_takes(tmp_path: Path, verdin: Description) -> None:
    source = bag(tmp_path / "lift.bag")
    with pytest.raises(UsageError, match="does not contain its description"):
        open_recordings([source], None)
    strange = write_ros1(tmp_path / "other.bag", [("/elsewhere", COMMAND, 0, {"command": 2})])
    with pytest.raises(
        UsageError, match="The bag has no states of an end-effector: its topics are /elsewhere"
    ):
        open_recordings([strange], Path(verdin.source))
    (tmp_path / "empty.bag").write_bytes(b"")
    with pytest.raises(UsageError, match="The bag is damaged"):
        open_recordings([tmp_path / "empty.bag"], Path(verdin.source))


def test_a_recording_shown_with_another_tool_says_so(grip: Path, verdin: Description) -> None:
    other = verdin.model_copy(update={"sequence": verdin.sequence[:2]})
    files = RecordingFiles(grip, other)
    notes = " ".join(plain(read_recording(files).document)["recording"]["notes"])
    assert "It is shown with another description" in notes
    assert "it is not that of a tool with 2 actuators" in notes
    assert not files.whole


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"actuators":[0,0,0]', b'"actuators":[0,0]  '),
        pytest.param(b'"actuators":[0,0,0]', b'"actuators":[0,0,9]', marks=pytest.mark.nightly),
        (b'"ee":1', b'"ee":9'),
        pytest.param(b'"at":1', b'"at":-', marks=pytest.mark.nightly),
        pytest.param(b'"process":"Gripper"', b'"process":"Grapper"', marks=pytest.mark.nightly),
        (b'"changes":[', b'"changes":{'),
    ],
)
def test_records_that_make_no_sense_end_no_page(copy: Path, old: bytes, new: bytes) -> None:
    """Of the same length, in each trace, wherever they stand."""
    for path in copy.glob("*.mcap"):
        path.write_bytes(path.read_bytes().replace(old, new))
    files = RecordingFiles(copy)
    document = plain(read_recording(files).document)
    assert document["recording"]["notes"]
    assert document["times"]
    assert not judge_recording(files)["ok"]
    assert report_html("run", [document], [])


def test_a_folder_without_a_trace_shows_its_switches(tmp_path: Path) -> None:
    """As ROS leaves it; the pressures are not broken by what comes between two of them."""
    tool = load_tool(Path("examples/tools/diy_record/end_effector.yaml"))
    pressure = next(name for name, kind in carrier_of(tool).channels.items() if kind is Kind.PRESSURE)
    with Recording(tmp_path, tool, now=lambda: 0) as recording:
        recording.state(0, 6, -1, [0] * len(tool.sequence))
        for at, down in ((0, False), (400_000, False), (600_000, True), (800_000, True)):
            recording.values(at, {"down": down, pressure: -10_000 - at // 100})
    document = plain(read_recording(RecordedTables(tmp_path, tool)).document)
    changes = [(each["at"], each["word"]) for each in document["changes"] if each["lane"] == "switch down"]
    assert changes == [(0, "off"), (600_000, "on: confirmed")]
    assert None not in next(column for column in document["samples"][1:] if any(column))
