"""Recordings in the page and as one file, in a real browser: what somebody sees who asks why a grip failed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.page.recorded import RecordingFiles, compare_recordings, read_recording
from end_effector_hal.recording import BEGUN, AlarmRow, RecordingLimits
from end_effector_lab.demo import World
from end_effector_lab.recorded import report_html
from tests.acceptance.page.conftest import Live, Process
from tests.acceptance.page.test_page import opened as live_page
from tests.acceptance.page.test_page import shot, shows
from tests.support.patience import wait_until
from tests.support.recorded_days import run_of
from tests.support.recorded_tool import RecordedTool, recorded

READ_MS = 300_000
HOSTILE = '</script><img src=http://evil.example/x onerror="document.title=1">'


@pytest.fixture(scope="module")
def retried(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("retried") / "retried"
    return recorded(folder, "fails-once:cylinder", 1.5, "cancel", "grip", 9.0, "drop", 4.0)


@pytest.fixture(scope="module")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("nominal") / "nominal", "nominal", 3.5, "grip", 6.0, "drop", 3.0)


@pytest.fixture(scope="module")
def report(retried: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return reported(tmp_path_factory.mktemp("report"), retried)


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Any]:
    """Starts `eehal page` with these words; the address."""
    pages: list[Process] = []

    def serve(*words: str) -> str:
        pages.append(Process(tmp_path, "page", *words, "--port", "0"))
        return pages[-1].said(r"http://\S+")[0]

    yield serve
    for page in pages:
        page.end()


def reported(folder: Path, *recordings: Path, expected: int = 0) -> Path:
    """`eehal report` in a process."""
    target = folder / "report.html"
    process = Process(folder, "report", *map(str, recordings), "-o", str(target))
    assert process.child.wait(READ_MS / 1000) == expected, process.log.read_text()
    process.end()
    return target


def opened(chromium: Any, url: str, **options: Any) -> Any:
    """A page with its recording; it fails on any error in the browser, and remembers what it asked for."""
    context = chromium.new_context(**{"viewport": {"width": 1440, "height": 900}, **options})
    context.set_default_timeout(30_000)
    page = context.new_page()
    page.faults = []
    page.asked = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("console", lambda said: page.faults.append(said.text) if said.type == "error" else None)
    page.on("request", lambda request: page.asked.append(request.url))
    page.goto(url)
    is_read(page)
    return page


def is_read(page: Any) -> None:
    """Who reads stands behind whatever else the machine does: only what fails takes so long."""
    page.wait_for_selector("body:not(.stale)", timeout=READ_MS)


def close(page: Any) -> None:
    assert not page.faults
    page.context.close()


def moment(page: Any) -> float:
    return float(page.inner_text("#moment").removesuffix(" s"))


def comes(page: Any, condition: str) -> None:
    """The moment that is shown becomes such, at the next frame."""
    read = "parseFloat(document.getElementById('moment').textContent)"
    page.wait_for_function(f"() => {{ const at = {read}; return {condition}; }}")


def test_a_recording_is_scrubbed_and_stepped(chromium: Any, served: Any, retried: Path) -> None:
    page = opened(chromium, served(str(retried)))
    shows(page, "about", "nothing is commanded here.")
    identical = "Replay and monitor: identical decisions; every step is allowed by the automata."
    shows(page, "judged", identical, READ_MS)
    for absent in ("#buttons", "#control-take", "#maintenance", "#confirm", "#hold-still"):
        assert page.query_selector(absent) is None
    shows(page, "summaries", "Cylinder, attempt 1 of 3: timed out after 5.00 s")
    # it opens where something is known, not at its beginning with empty cards
    assert moment(page) > 0
    assert page.inner_text("#state-word") != "–"
    assert "–" not in page.locator("#cards .reading b").all_inner_texts()
    # by the keyboard from transition to transition, until the grip is decided
    states = [page.inner_text("#state-word")]
    while states[-1] != "GRIPPED":
        before = moment(page)
        page.keyboard.press("ArrowRight")
        page.wait_for_function(f"() => document.getElementById('moment').textContent !== '{before:.3f} s'")
        if (word := page.inner_text("#state-word")) != states[-1]:
            states.append(word)
    assert states[-3:] == ["STAND_BY", "GRIPPING", "GRIPPED"]
    shows(page, "event", "guard")
    shows(page, "event", "readings:")
    assert "#e=" in page.url
    shows(page, "held-word", "YES")
    page.keyboard.press("ArrowLeft")
    shows(page, "state-word", "GRIPPING")
    # the slider
    page.focus("#scrub")
    page.keyboard.press("End")
    shows(page, "state-word", "STAND_BY")
    page.fill("#scrub", "5.2")
    shows(page, "state-word", "GRIPPING")
    page.locator("#cards .timer:not([hidden])", has_text="time-out in").wait_for()
    page.locator("#cards .attempts:not([hidden])", has_text="attempt 1 of 3").last.wait_for()
    shot(page, "recording", whole=True)
    # a goal of the summary, and a refusal
    page.locator("#summaries button", has_text="s").first.click()
    comes(page, "Math.abs(at - 1.5) < 0.1")
    page.fill("#log-find", "no running grip to cancel")
    page.locator("#log li", has_text="Cancel refused").wait_for()
    # a click on the timeline goes there
    box = page.locator("#timeline canvas").first.bounding_box()
    page.mouse.click(box["x"] + box["width"] * 0.6, box["y"] + 60)
    comes(page, "at > 5.5")
    # play
    page.select_option("#speed", "4")
    at = moment(page)
    page.click("#play")
    comes(page, f"at > {at} + 1")
    page.click("#play")
    assert {url.split("/")[2] for url in page.asked} == {page.url.split("/")[2]}, (
        "no request leaves the machine"
    )
    close(page)


def test_a_link_leads_to_a_moment_and_to_an_event(chromium: Any, report: Path) -> None:
    page = opened(chromium, f"file://{report}#t=5.2")
    shows(page, "moment", "5.200 s")
    shows(page, "state-word", "GRIPPING")
    shot(page, "page-recording")
    page.locator("#log button", has_text="State GRIPPING").first.click()
    link = page.get_attribute("#link", "href")
    assert link.startswith("#e=")
    comes(page, "at < 5")
    other = opened(chromium, f"file://{report}{link}")
    shows(other, "event", "State GRIPPING")
    assert moment(other) == moment(page)
    close(other)
    close(page)


def test_two_recordings_under_each_other(chromium: Any, served: Any, retried: Path, nominal: Path) -> None:
    page = opened(chromium, served(str(retried), str(nominal)), color_scheme="dark")
    shows(page, "about", " and of ")
    page.fill("#scrub", "4")
    shows(page, "other", "retried: GRIPPING · nominal: GRIPPING")
    page.fill("#scrub", "3")
    shows(page, "other", "retried: GRIPPING · nominal: STAND_BY")
    page.click("#align")
    shows(page, "other", "retried: GRIPPING · nominal: GRIPPED")
    assert float(page.input_value("#shift")) == pytest.approx(-2.0, abs=0.05)
    page.select_option("#shown", "1")
    shows(page, "state-word", "GRIPPED")
    assert page.locator(".marker:visible").count() == 2
    first, second = (
        page.locator(f"#{each} .uplot").first.bounding_box()["width"] for each in ("timeline", "second")
    )
    assert first == second > 1000, "both are drawn in the same width"
    shot(page, "recordings-compared", whole=True)
    close(page)


def row_of(page: Any, what: str) -> Any:
    """The difference that says this."""
    return page.locator("#differences-rows tr", has_text=what).first


def is_chosen(page: Any, what: str) -> None:
    page.locator("#differences-rows tr[aria-current]", has_text=what).wait_for()


def test_the_differences_of_two_recordings(chromium: Any, served: Any, retried: Path, nominal: Path) -> None:
    """By the mouse and by the keyboard to the moment of each, in both recordings."""
    page = opened(chromium, served(str(retried), str(nominal)))
    shows(page, "differences-said", "differences: both are counted from their first command", READ_MS)
    heads = page.locator("#differences th").all_inner_texts()
    assert [each.lower() for each in heads] == ["in the first", "in the second", "lane", "what"]
    first, second, lane, what = row_of(page, "RETRACTED").locator("td").all_inner_texts()
    assert (second, lane, what) == ("–", "Cylinder", "RETRACTED: only in the first")
    row_of(page, "RETRACTED").locator("td").first.click()
    is_chosen(page, "RETRACTED")
    assert moment(page) == pytest.approx(float(first.removesuffix(" s")), abs=0.001)
    # both as from their first commands: the second was gripped by then
    assert float(page.input_value("#shift")) == pytest.approx(-2.0, abs=0.01)
    shows(page, "other", "retried: GRIPPING · nominal: GRIPPED")
    assert page.locator(".marker:visible").count() == 2
    # the next that is in both, by the keyboard
    row_of(page, "EXTENDED:").get_by_role("button").focus()
    page.keyboard.press("Enter")
    is_chosen(page, "EXTENDED:")
    first, second, *_ = row_of(page, "EXTENDED:").locator("td").all_inner_texts()
    at, other = (float(each.removesuffix(" s")) for each in (first, second))
    assert moment(page) == pytest.approx(at, abs=0.001)
    assert float(page.input_value("#shift")) == pytest.approx(at - other, abs=0.001)
    for shown in ("0", "1"):
        page.select_option("#shown", shown)
        page.locator("#cards .card", has_text="Cylinder").locator(".pill", has_text="EXTENDED").wait_for()
    shot(page, "recordings-differences", whole=True)
    # elsewhere none of them is shown
    page.keyboard.press("Home")
    page.locator("#differences-rows tr[aria-current]").wait_for(state="detached")
    close(page)


def test_a_moment_before_the_first_recording_can_be_reached(
    chromium: Any, served: Any, retried: Path, nominal: Path
) -> None:
    """The first grip of the second one is later, so that it begins earlier once they are aligned."""
    page = opened(chromium, served(str(retried), str(nominal)))
    page.click("#align")
    page.focus("#scrub")
    page.keyboard.press("Home")
    comes(page, "Math.abs(at + 2) < 0.05")
    shows(page, "other", "retried: nothing yet · nominal:")
    close(page)


def test_the_differences_in_one_file(chromium: Any, retried: Path, nominal: Path, tmp_path: Path) -> None:
    page = opened(
        chromium,
        f"file://{reported(tmp_path, retried, nominal)}",
        offline=True,
        viewport={"width": 390, "height": 844},
        color_scheme="dark",
        has_touch=True,
        device_scale_factor=2,
    )
    row_of(page, "RETRACTED").get_by_role("button").tap()
    is_chosen(page, "RETRACTED")
    shows(page, "other", "retried: GRIPPING · nominal: GRIPPED")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    shot(page, "differences-phone")
    assert len(page.asked) == 1
    close(page)


def test_two_recordings_without_a_difference(chromium: Any, retried: Path, tmp_path: Path) -> None:
    page = opened(chromium, f"file://{reported(tmp_path, retried, retried)}")
    shows(page, "differences-said", "No difference: both are counted from their first command")
    assert not page.is_visible("#differences-table")
    assert not page.is_visible("#differences-more")
    close(page)
    alone = opened(chromium, f"file://{reported(tmp_path, retried)}")
    assert not alone.is_visible("#differences")
    close(alone)


def test_what_a_difference_says_is_text_and_a_long_list_is_cut(
    chromium: Any, nominal: Path, tmp_path: Path
) -> None:
    read = read_recording(RecordingFiles(nominal))
    alarms = tuple(AlarmRow(i / 100, BEGUN, f"{HOSTILE}{'x' * i}") for i in range(300))
    noisy = replace(read.compared, tables=replace(read.compared.tables, alarms=alarms))
    found = compare_recordings(read.compared, noisy)
    (tmp_path / "two.html").write_text(report_html("two", [read.document] * 2, [], found))
    page = opened(chromium, f"file://{tmp_path / 'two.html'}", viewport={"width": 390, "height": 844})
    assert page.locator("#differences-rows tr").count() == 200
    shows(page, "differences-more", "And 100 more differences.")
    assert HOSTILE in page.locator("#differences-rows td:last-child").first.inner_text()
    assert page.locator("main img").count() == 0
    assert page.title() == "verdin_gripper"
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    assert page.locator("#differences-table").bounding_box()["height"] < 400, "it scrolls within itself"
    close(page)


def test_a_second_recording_that_was_cut_off_is_compared_as_far_as_it_goes(
    chromium: Any, served: Any, retried: Path, nominal: Path, tmp_path: Path
) -> None:
    cut = Path(shutil.copytree(retried, tmp_path / "cut"))
    for trace in cut.glob("*.mcap"):
        trace.write_bytes(trace.read_bytes()[: trace.stat().st_size // 2])
    page = opened(chromium, served(str(nominal), str(cut)))
    shows(
        page, "differences-said", "Not all of cut could be read: what is missing there differs, too.", READ_MS
    )
    close(page)


def test_a_report_is_one_file_that_asks_for_nothing(chromium: Any, report: Path, tmp_path: Path) -> None:
    alone = tmp_path / "elsewhere" / "mailed.html"
    alone.parent.mkdir()
    shutil.copy(report, alone)
    page = opened(chromium, f"file://{alone}", offline=True)
    shows(page, "summaries", "Cylinder confirmed on attempt 2: GRIPPED")
    shows(page, "judged", "Replay and monitor: identical decisions")
    page.keyboard.press("End")
    shows(page, "state-word", "STAND_BY")
    assert page.asked == [f"file://{alone}"]
    page.emulate_media(media="print")
    assert not page.is_visible("#scrub")
    assert page.is_visible("#summaries")
    shot(page, "report-printed", whole=True)
    close(page)


def test_a_report_of_a_folder_begins_with_a_table_and_opens_each_run(
    chromium: Any, retried: Path, nominal: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "runs"
    for each in (retried, nominal):
        shutil.copytree(each, folder / each.name)
    (folder / "<i>torn").mkdir()
    (folder / "<i>torn" / "hal.mcap").write_bytes((nominal / "hal.mcap").read_bytes()[:1000])
    page = opened(chromium, f"file://{reported(tmp_path, folder, expected=1)}")
    shows(page, "about", "3 runs in the order of their names")
    shows(
        page,
        "judged",
        "2 with identical decisions, every step allowed by the automata; 1 not, or not wholly read.",
    )
    rows = page.locator("#runs-rows tr")
    assert rows.count() == 3
    assert "The trace ends after 1000 bytes" in rows.first.inner_text()
    assert page.locator("#runs-rows a").all_inner_texts() == ["nominal", "retried"]
    assert not page.is_visible("#cards")
    shot(page, "report-runs", whole=True)
    page.locator("#runs-rows a", has_text="retried").click()
    shows(page, "summaries", "Cylinder confirmed on attempt 2: GRIPPED")
    assert not page.is_visible("#runs")
    page.fill("#scrub", "5.2")
    shows(page, "state-word", "GRIPPING")
    link = page.get_attribute("#link", "href")
    assert link == "#run=2&t=5.200"
    other = opened(chromium, f"{page.url.partition('#')[0]}{link}")
    shows(other, "moment", "5.200 s")
    close(other)
    page.click("#all-runs")
    shows(page, "about", "3 runs in the order of their names")
    page.go_back()
    shows(page, "state-word", "GRIPPING")
    assert len({url.partition("#")[0] for url in page.asked}) == 1
    close(page)


def test_what_a_recording_says_is_text(chromium: Any, retried: Path, tmp_path: Path) -> None:
    """A reason of the same length, so that the file is readable but for its checksum."""
    folder = Path(shutil.copytree(retried, tmp_path / "run"))
    trace = folder / "hal.mcap"
    data = trace.read_bytes()
    reason = b"There is no running grip to cancel; the end-effector is STAND_BY."
    assert data.count(reason) == 1
    said = HOSTILE.encode().replace(b'"', b"'")[: len(reason)].ljust(len(reason))
    trace.write_bytes(data.replace(reason, said))
    page = opened(chromium, f"file://{reported(tmp_path, folder, expected=1)}")
    page.keyboard.press("End")
    page.locator("#log li", has_text=said.decode().strip()).wait_for()
    assert page.locator("main img").count() == 0
    assert page.title() == "verdin_gripper"
    assert len(page.asked) == 1
    # and a script that got in all the same is not run
    page.evaluate(
        "() => { const made = document.createElement('script'); made.textContent = 'document.title = 1';"
        " document.body.append(made); }"
    )
    assert page.title() == "verdin_gripper"
    assert any("Content Security Policy" in fault for fault in page.faults)
    page.context.close()


def test_damage_is_told_and_what_was_before_it_is_shown(chromium: Any, served: Any, tmp_path: Path) -> None:
    tool = RecordedTool(
        tmp_path / "run", "never-confirms:cylinder", limits=RecordingLimits(150_000, 100_000_000)
    )
    tool.run(1.5)
    tool.command("grip")
    tool.run(25.0)
    tool.close()
    second, last = tool.folder / "hal-2.mcap", max(tool.folder.glob("hal-*.mcap"))
    data = second.read_bytes()
    place = data.index(b'"device_ms"', len(data) // 2)
    second.write_bytes(data[:place] + b'"Xevice_ms"' + data[place + 11 :])
    last.write_bytes(last.read_bytes()[:-5000])
    page = opened(chromium, served(str(tool.folder)))
    shows(page, "notes", "hal-2.mcap is damaged: bytes in it were changed")
    shows(page, "notes", "What follows in this file is not shown.")
    shows(page, "notes", f"{last.name} is not whole")
    shows(page, "judged", "Replay and monitor: decisions differ, or the trace is incomplete", READ_MS)
    page.fill("#scrub", "4")
    shows(page, "state-word", "GRIPPING")
    shot(page, "recording-damaged", whole=True)
    close(page)


def test_a_recording_on_a_phone_in_the_dark(chromium: Any, report: Path) -> None:
    page = opened(
        chromium,
        f"file://{report}#t=5.2",
        viewport={"width": 390, "height": 844},
        color_scheme="dark",
        has_touch=True,
        device_scale_factor=2,
    )
    shows(page, "state-word", "GRIPPING")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390, (
        "nothing stands out to the right"
    )
    page.evaluate("() => scrollTo(0, 900)")
    box = page.locator("#scrub").bounding_box()
    assert 0 <= box["y"] <= 200, "the slider stays in reach"
    page.tap("#next")
    shows(page, "event", "late by")
    shot(page, "recording-phone")
    close(page)


def test_the_keyboard_reaches_everything_of_a_recording(chromium: Any, report: Path) -> None:
    page = opened(chromium, f"file://{report}")
    reached = set()
    for _ in range(12):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("() => document.activeElement.id"))
    assert {"previous", "play", "next", "speed", "scrub", "link"} <= reached
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("Space")
    comes(page, "at > 0.3")
    page.keyboard.press("Space")
    at = moment(page)
    page.keyboard.press("Home")
    shows(page, "moment", "0.000 s")
    assert at > 0.3
    close(page)


def test_a_recording_that_is_still_written_grows(chromium: Any, served: Any, tmp_path: Path) -> None:
    with World(load(profile_path()), "nominal", tmp_path) as world:
        hal = Process(tmp_path, "run", str(world.description_path), "--record", str(tmp_path / "run"))
        try:
            hal.said("STAND.BY")
            wait_until("the trace", (tmp_path / "run" / "hal.mcap").exists)
            page = opened(chromium, served(str(tmp_path / "run")))
            shows(page, "notes", "the program was killed or still writes")
            assert hal.child.stdin is not None
            hal.child.stdin.write(b"grip\n")
            hal.child.stdin.flush()
            hal.said("GRIPPED")
            shows(page, "news", "The recording has grown since it was read.")
            page.reload()
            is_read(page)
            shows(page, "summaries", "Nominal: GRIPPED")
            close(page)
        finally:
            hal.end()


def test_a_seal_that_wears_is_seen_on_the_page(chromium: Any, tmp_path: Path) -> None:
    for day in range(6):
        run_of(tmp_path / "runs" / str(day), load(profile_path()), f"leak:bottom_vacuum:{day / 2 + 0.5}", day)
    with Live(tmp_path, "nominal", "--recordings", str(tmp_path / "runs")) as live:
        page = live_page(chromium, live)
        assert page.locator("#history rect").count() == 0, "nothing is read before somebody asks"
        page.click("#history-show")
        shows(page, "history-said", "6 grips in 6 recordings, 2026-03-02 to 2026-03-07", READ_MS)
        rows = page.locator("#history-rows tr").all_inner_texts()
        assert rows[-1].split() == ["2026-03-07", "–", "1", "1", "GRIPPED", "100", "%"]
        assert page.locator("#history-trends figure").count() == 6
        worn = page.locator("figure", has_text="Bottom vacuum: margin at the end of the hold, kPa")
        heights = worn.locator("rect").evaluate_all(
            "bars => bars.map((bar) => bar.getBoundingClientRect().height)"
        )
        assert len(heights) == 6
        assert all(later < before for before, later in pairwise(heights)), heights
        assert heights[0] > 30
        assert worn.locator("svg").get_attribute("aria-label").startswith("Bottom vacuum: margin")
        page.locator("#history").scroll_into_view_if_needed()
        shot(page, "history")
        close(page)


def test_the_live_page_lists_what_was_recorded_and_opens_it(
    chromium: Any, tmp_path: Path, retried: Path, nominal: Path
) -> None:
    folder = tmp_path / "runs"
    for number, each in enumerate((retried, nominal)):
        shutil.copytree(each, folder / each.name)
        for file in (folder / each.name).iterdir():
            os.utime(file, (1000.0 + number, 1000.0 + number))
    (folder / "torn").mkdir()
    (folder / "torn" / "hal.mcap").write_bytes((nominal / "hal.mcap").read_bytes()[:20_000])
    os.utime(folder / "torn" / "hal.mcap", (10.0, 10.0))
    with Live(tmp_path, "nominal", "--recordings", str(folder)) as live:
        page = live_page(chromium, live)
        assert page.locator("#past-rows tr").count() == 0, "nothing is read before somebody asks"
        page.click("#past-jump")
        shows(page, "past-said", f"3 in {folder}, newest first.", READ_MS)
        assert page.locator("#past-rows a").all_inner_texts() == [nominal.name, retried.name, "torn"]
        assert live.page.child.poll() is None
        page.locator("#past").scroll_into_view_if_needed()
        shot(page, "recordings-listed")
        with page.context.expect_page() as found:
            page.locator("#past-rows a", has_text="retried").click()
        past = found.value
        is_read(past)
        shows(past, "summaries", "Cylinder, attempt 1 of 3: timed out after 5.00 s")
        identical = "Replay and monitor: identical decisions; every step is allowed by the automata."
        shows(past, "judged", identical, READ_MS)
        assert past.query_selector("#buttons") is None
        # meanwhile the tool is as live as before
        assert page.query_selector("body.stale") is None
        shows(page, "state-word", "STAND_BY")
        assert not page.faults
        page.context.close()
