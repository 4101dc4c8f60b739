"""What the page says of two recordings: what `eehal compare` says, where each difference leads to, and how much."""

from __future__ import annotations

import asyncio
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import eehal
from end_effector_hal.cli.recorded import open_recordings
from end_effector_hal.description import Description
from end_effector_hal.page.recorded import (
    ComparedRecording,
    RecordedTables,
    RecordingFiles,
    RecordingPart,
    compare_recordings,
    read_recording,
)
from end_effector_hal.page.recorded import _differences as differences_module
from end_effector_hal.page.web import PageAddress
from end_effector_hal.page.web._recordings import ServedRecording, make_recordings_app
from end_effector_hal.recording import BEGUN, AlarmRow, RunTables, StatesLog
from end_effector_hal.recording._alarms import AlarmsWriter
from end_effector_hal.recording._pressures import PressuresWriter
from end_effector_hal.vocabulary import display_name, received_alarms
from end_effector_lab.recorded import report_html
from tests.support.recorded_tool import recorded
from tests.support.trace_recordings import FAILS_ONCE, INFO, NOMINAL, log, written
from tests.unit.page.test_past import asked

Json = dict[str, Any]
SAME = "what is within 0.1 s and 5 kPa (gauge) of the other one is the same"


def tables_of(folder: Path, states: StatesLog, lower_kpa: float = 0.0, *alarms: tuple[float, str]) -> Path:
    """A folder of tables; the pressure of the bottom cup is lower by that, from 3 s to 4 s."""
    written(folder, states)
    with PressuresWriter(folder / "pressures.csv", ("bottom", "supply")) as writer:
        for tenth in range(120):
            at_s = tenth / 10
            bottom = 0.0 if at_s < 1.5 else -60.0
            writer.write(
                at_s, {"bottom": bottom - (lower_kpa if 3 <= at_s <= 4 else 0.0), "supply": 600.0 - lower_kpa}
            )
    with AlarmsWriter(folder / "alarms.csv") as writer:
        for at_s, text in alarms:
            writer.write(at_s, received_alarms([text]))
    return folder


def compared(path: Path, description: Description, part: RecordingPart | None = None) -> ComparedRecording:
    (files,) = open_recordings([path], Path(description.source))
    return read_recording(files, part).compared


def run(
    states: StatesLog, name: str = "run", *, whole: bool = True, step_s: float = 0.02
) -> ComparedRecording:
    return ComparedRecording(name, RunTables(states, INFO), 0.0, 1000.0, step_s, whole)


def test_the_page_lists_what_the_command_lists(tmp_path: Path, verdin: Description) -> None:
    """States, pressures (also one that no card draws) and alarms, of the same files."""
    first = tables_of(tmp_path / "one", NOMINAL, 0.0, (3.0, "Leak: 1.5 kPa/s"), (5.0, "Late."))
    second = tables_of(tmp_path / "other", FAILS_ONCE, 8.0, (3.0, "Leak: 2 kPa/s"), (9.0, "<b>Cut</b>."))
    said = CliRunner().invoke(eehal, ["compare", str(first), str(second), "--json"])
    listed = json.loads(said.stdout)["differences"]
    found = compare_recordings(compared(first, verdin), compared(second, verdin))
    assert [(each["first_s"], each["second_s"], each["lane"], each["what"]) for each in found["rows"]] == [
        (each["first_s"], each["second_s"], display_name(each["line"]), each["text"]) for each in listed
    ]
    lanes = {each["lane"] for each in found["rows"]}
    assert lanes == {"End effector", "Cylinder", "Bottom", "Supply", "Alarms"}
    assert found["said"] == (
        f"{len(listed)} differences: both are counted from their first command, and {SAME}."
    )
    assert found["more"] == ""


def test_a_difference_leads_to_its_moment_in_both() -> None:
    """What is in the second one only is beside what the first one did at that distance from the last common state."""
    earlier = log(*((row.time_s + 2, *row.states) for row in FAILS_ONCE.rows))
    rows = compare_recordings(run(NOMINAL), run(earlier))["rows"]
    assert [(each["what"], each["first_s"], each["second_s"], each["shift_s"]) for each in rows] == [
        ("EXTENDED: 6.25 s later in the second", 2.0, 10.25, -8.25),
        ("RETRACTED: only in the second", None, 8.5, -2.0),
        ("PENDING EXTEND: only in the second", None, 9.5, -2.0),
        ("RELEASING: 6.25 s earlier in the second", 11.0, 13.0, -2.0),
    ]
    rows = compare_recordings(run(earlier), run(NOMINAL))["rows"]
    alone = {each["what"]: each["shift_s"] for each in rows if each["second_s"] is None}
    assert alone == {"RETRACTED: only in the first": 2.0, "PENDING EXTEND: only in the first": 2.0}


def test_after_a_common_difference_the_second_stays_where_that_has_put_it() -> None:
    """The release is 6.25 s nearer again: a state of one only stands where the last state of both has put it."""
    late = log(*((row.time_s + (6.25 if row.time_s >= 11 else 0.0), *row.states) for row in FAILS_ONCE.rows))
    more = StatesLog(late.actuators, (*late.rows, replace(late.rows[-1], time_s=19.0, actuators=(0, 0, 1))))
    rows = compare_recordings(run(NOMINAL), run(more))["rows"]
    assert (rows[-1]["what"], rows[-1]["second_s"], rows[-1]["shift_s"]) == (
        "PENDING ON: only in the second", 19.0, -6.25
    )  # fmt: skip


def test_what_has_no_time_leads_nowhere() -> None:
    both = run(log((0.0, 6, -1, 0, 0), (1.0, 1, 2, 1, 0), names=["bottom_vacuum", "cylinder"]))
    alone = run(log((0.0, 6, -1, 0), (1.0, 1, 2, 1), names=["bottom_vacuum"]))
    (row,) = compare_recordings(alone, both)["rows"]
    assert row == {
        "first_s": None, "second_s": None, "lane": "Cylinder", "what": "only the second recording has it",
        "shift_s": None,
    }  # fmt: skip


def test_nothing_different_is_one_sentence() -> None:
    assert compare_recordings(run(NOMINAL), run(NOMINAL)) == {
        "said": f"No difference: both are counted from their first command, and {SAME}.",
        "rows": [],
        "more": "",
    }


def test_a_long_list_is_cut_and_says_how_much_more_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    alarms = tuple(AlarmRow(i / 10, BEGUN, f"Alarm {'x' * i}") for i in range(1, 1_001))
    noisy = replace(run(NOMINAL), tables=RunTables(NOMINAL, INFO, alarms=alarms))
    found = compare_recordings(run(NOMINAL), noisy)
    assert found["said"].startswith("1000 differences: ")
    assert len(found["rows"]) == 200
    assert found["more"] == "And 800 more differences."
    monkeypatch.setattr(differences_module, "MOST_DIFFERENCES", 999)
    found = compare_recordings(run(NOMINAL), noisy)
    assert found["more"] == "And 1 more difference."
    assert max(len(each["what"]) for each in found["rows"]) == 300
    assert len(json.dumps(found)) < 500_000


def test_what_cannot_be_shown_is_a_question_mark() -> None:
    alarm = AlarmRow(3.0, BEGUN, "a\x1b[31m\u202eb")
    odd = replace(run(NOMINAL), tables=RunTables(NOMINAL, INFO, alarms=(alarm,)))
    (row,) = compare_recordings(run(NOMINAL), odd)["rows"]
    assert row["what"] == "a?[31m?b: only in the second"


def test_of_a_long_recording_as_near_as_its_pressures_are_kept() -> None:
    quicker = log((0.0, 6, -1, 0), (1.0, 1, 2, 1), (1.5, 3, -1, 2), names=["bottom_vacuum"])
    slower = log((0.0, 6, -1, 0), (1.0, 1, 2, 1), (1.9, 3, -1, 2), names=["bottom_vacuum"])
    assert len(compare_recordings(run(quicker), run(slower))["rows"]) == 1
    found = compare_recordings(run(quicker), run(slower, step_s=0.25))
    assert found["rows"] == []
    assert "what is within 0.5 s and 5 kPa" in found["said"]


def test_what_cannot_be_compared_says_why() -> None:
    nothing = run(log(), "torn")
    for pair in ((nothing, run(NOMINAL)), (run(NOMINAL), nothing)):
        assert compare_recordings(*pair) == {
            "said": "The recordings cannot be compared. torn holds no state that can be read.",
            "rows": [],
            "more": "",
        }
    many = log(*((float(i), 6, -1 + i % 2, 0) for i in range(2_002)), names=["a_vacuum"])
    found = compare_recordings(run(replace(many, source="many")), run(many))
    assert found["rows"] == []
    assert (
        "The recordings cannot be compared. many: Command has 2002 changes; 2000 can be compared."
        in found["said"]
    )


def test_what_could_not_be_read_is_told() -> None:
    found = compare_recordings(run(NOMINAL), run(FAILS_ONCE, "cut", whole=False))
    assert found["said"].endswith(" Not all of cut could be read: what is missing there differs, too.")
    assert len(found["rows"]) == 4


@pytest.fixture(scope="module")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("nominal") / "nominal", "nominal", 1.5, "grip", 4.0, "drop", 3.0)


@pytest.fixture(scope="module")
def retried(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(
        tmp_path_factory.mktemp("retried") / "retried", "fails-once:cylinder", 3.5, "grip", 9.0, "drop", 3.0
    )


@pytest.fixture(scope="module")
def both(nominal: Path, retried: Path) -> tuple[ComparedRecording, ComparedRecording]:
    """Each of them, read once."""
    first, second = (read_recording(RecordingFiles(each)).compared for each in (nominal, retried))
    return first, second


def test_traces_are_compared_by_their_records(
    nominal: Path, both: tuple[ComparedRecording, ComparedRecording]
) -> None:
    """Two runs whose grips begin two seconds apart: a time-out more, and what follows from it."""
    first, second = both
    assert compare_recordings(first, first)["rows"] == []
    found = compare_recordings(first, second)
    told = {(each["lane"], each["what"].partition(":")[0]): each for each in found["rows"]}
    again = told["Cylinder", "RETRACTED"]
    assert again["first_s"] is None
    assert again["second_s"] == pytest.approx(3.5 + 5.7, abs=0.5)
    assert again["shift_s"] == pytest.approx(-2.0, abs=0.001)
    extended = told["Cylinder", "EXTENDED"]
    assert extended["shift_s"] == pytest.approx(extended["first_s"] - extended["second_s"], abs=1e-6)
    assert {"Cylinder"} < {lane for lane, _ in told}
    assert str(nominal.parent) not in json.dumps(found)


def test_of_a_part_only_what_is_in_it(
    nominal: Path, retried: Path, both: tuple[ComparedRecording, ComparedRecording]
) -> None:
    """Of the recordings from 6 s to 12 s: also what is in the part of one of them only."""
    part = RecordingPart(6.0, 12.0)
    first, second = (read_recording(RecordingFiles(each), part).compared for each in (nominal, retried))
    rows = compare_recordings(first, second)["rows"]
    times = {each["what"]: (each["first_s"], each["second_s"]) for each in rows}
    assert times["EXTENDED: 6.00 s later in the second"] == pytest.approx((2.42, 10.42))
    assert times["RETRACTED: only in the second"] == (None, pytest.approx(8.9))
    assert not any(what.startswith(("RELEASING", "up to")) for what in times), "they are at 5.5 s and before"
    listed = [each["what"] for each in compare_recordings(*both)["rows"]]
    assert any(each.startswith("RELEASING") for each in listed)


def test_a_second_recording_that_was_cut_off_is_compared_up_to_there(
    nominal: Path, retried: Path, tmp_path: Path
) -> None:
    cut = Path(shutil.copytree(retried, tmp_path / "cut"))
    for trace in cut.glob("*.mcap"):
        data = trace.read_bytes()
        trace.write_bytes(data[: len(data) // 2])
    first, second = (read_recording(RecordingFiles(each)).compared for each in (nominal, cut))
    found = compare_recordings(first, second)
    assert "Not all of cut could be read" in found["said"]
    assert any("only in the first" in each["what"] for each in found["rows"])


def of_app(*paths: Path) -> tuple[int, bytes]:
    """What the page of these recordings answers when it is asked for the differences."""
    address = PageAddress("127.0.0.1", 1)
    cookie = f"{address.cookie}={address.session}"

    async def ask() -> tuple[int, bytes]:
        app = make_recordings_app(
            address, [ServedRecording(RecordingFiles(each), RecordingPart()) for each in paths]
        )
        while (answer := await asked(app, "/differences", cookie))[0] == 202:
            await asyncio.sleep(0.01)
        return answer

    return asyncio.run(ask())


def test_the_process_of_the_page_answers_with_them(
    nominal: Path, retried: Path, both: tuple[ComparedRecording, ComparedRecording]
) -> None:
    status, body = of_app(nominal, retried)
    assert status == 200
    first, second = both
    assert json.loads(body) == compare_recordings(first, second)
    assert of_app(nominal) == (404, b"There is one recording here: nothing is compared.\n")


@pytest.mark.thinned
def test_they_are_found_again_when_a_recording_has_grown(
    nominal: Path, retried: Path, tmp_path: Path
) -> None:
    grows = Path(shutil.copytree(nominal, tmp_path / "grows"))
    address = PageAddress("127.0.0.1", 1)
    cookie = f"{address.cookie}={address.session}"

    async def ask() -> list[Json]:
        served = [ServedRecording(RecordingFiles(each), RecordingPart()) for each in (nominal, grows)]
        app = make_recordings_app(address, served)
        found = []
        for path in ("/differences", "/", "/differences"):
            while (answer := await asked(app, path, cookie))[0] == 202:
                await asyncio.sleep(0.01)
            if path == "/":
                continue
            found.append(json.loads(answer[1]))
            for trace in retried.glob("*.mcap"):
                shutil.copy(trace, grows)
        return found

    before, after = asyncio.run(ask())
    assert before["rows"] == []
    assert any(each["what"] == "RETRACTED: only in the second" for each in after["rows"])


def test_a_report_of_two_has_them_and_one_of_one_has_none(
    nominal: Path, retried: Path, tmp_path: Path
) -> None:
    def data(*words: str) -> Json:
        out = tmp_path / "out.html"
        ran = CliRunner().invoke(eehal, ["report", *words, "-o", str(out)])
        assert ran.exit_code == 0, ran.output
        text = out.read_text().partition('<script type="application/json" id="recordings">')[2]
        found: Json = json.loads(text.partition("</script>")[0])
        return found

    found = data(str(nominal), str(retried))["differences"]
    assert any(each["what"] == "RETRACTED: only in the second" for each in found["rows"])
    assert data(str(nominal))["differences"] is None


def test_no_difference_ends_the_data_of_a_report(nominal: Path) -> None:
    document = read_recording(RecordingFiles(nominal)).document
    row = {"first_s": 1.0, "second_s": 1.0, "lane": "</script>", "what": "</script><script>alert(1)</script>"}
    html = report_html("run", [document], [], {"said": "<!--", "rows": [row], "more": "</script>"})
    assert html.count("</script>") == 3
    assert "alert(1)<" not in html


def test_tables_without_pressures_beside_some_with(tmp_path: Path, verdin: Description) -> None:
    first, second = tables_of(tmp_path / "one", NOMINAL), tables_of(tmp_path / "other", NOMINAL)
    (second / "pressures.csv").unlink()
    tables = [read_recording(RecordedTables(each, verdin)).compared for each in (first, second)]
    assert {(each["lane"], each["what"]) for each in compare_recordings(*tables)["rows"]} == {
        ("Bottom", "only the first recording has this pressure"),
        ("Supply", "only the first recording has this pressure"),
    }
