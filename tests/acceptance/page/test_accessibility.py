"""What axe-core finds in the page, live and recorded: nothing that keeps somebody from reading or using it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from end_effector_hal.description import load, profile_path
from tests.acceptance.page import test_recordings
from tests.acceptance.page.conftest import Live
from tests.acceptance.page.test_page import opened, shows
from tests.acceptance.page.test_recordings import nominal, report, retried, served
from tests.support.named_parts import gripper_with_parts
from tests.support.recorded_days import run_of

__all__ = ["nominal", "report", "retried", "served"]
SIZES = {"desktop": {"width": 1440, "height": 900}, "phone": {"width": 390, "height": 844}}
BARRED = ("serious", "critical")


def faults_of(page: Any) -> set[str]:
    """What is serious, on each size and in light and dark: the rule and where it is broken."""
    from axe_playwright_python.sync_playwright import Axe

    found = set()
    for size, viewport in SIZES.items():
        page.set_viewport_size(viewport)
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
            response = Axe().run(page, options={"resultTypes": ["violations"]}).response
            asked = {rule["id"] for kind in ("passes", "violations", "incomplete") for rule in response[kind]}
            assert "color-contrast" in asked
            assert asked & {"button-name", "link-name"}
            found |= {
                f"{size}, {scheme}: {rule['id']} ({rule['help']}) at {node['target']}: {node['failureSummary']}"
                for rule in response["violations"]
                if rule["impact"] in BARRED
                for node in rule["nodes"]
            }
    return found


def assert_no_fault(page: Any, what: str) -> None:
    found = faults_of(page)
    assert not found, "\n".join([f"{what}:", *sorted(found)])


def test_the_live_page(chromium: Any, tmp_path: Path, retried: Path) -> None:
    run_of(retried.parent / "tables", load(profile_path()), "nominal", 0)
    with Live(tmp_path, "nominal", "--recordings", str(retried.parent)) as live:
        page = opened(chromium, live)
        shows(page, "state-word", "STAND_BY")
        page.click("#past-jump")
        shows(page, "past-said", "newest first.")
        page.click("#history-show")
        shows(page, "history-said", "1 grip in 1 recording")
        assert_no_fault(page, "at rest, without the control")
        page.click("#control-take")
        shows(page, "control-who", "This page has the control.")
        page.click("#maintenance")
        assert_no_fault(page, "in maintenance")
        page.click("#maintenance")
        page.click("#command-grip")
        shows(page, "state-word", "GRIPPED")
        page.click("#command-drop")
        page.wait_for_selector("dialog[open]")
        assert_no_fault(page, "asked whether to drop")
        assert not page.faults
        page.context.close()


def test_what_is_wrong_can_be_read(chromium: Any, tmp_path: Path) -> None:
    with Live(tmp_path, "leak-grows:top_vacuum:2") as live:
        page = opened(chromium, live)
        page.click("#control-take")
        page.click("#command-grip")
        shows(page, "state-word", "GRIPPED")
        page.focus("#command-unlock")
        page.keyboard.press("Enter")
        shows(page, "answer", "IL-01")
        page.locator("#log button", has_text="State GRIPPED").first.click()
        shows(page, "event", "guard")
        page.locator("#alarms", has_text="Leak").wait_for(timeout=40_000)
        assert_no_fault(page, "held with a leak, an unlock refused, an event opened")
        live.hal.end()
        page.wait_for_selector("body.stale")
        assert_no_fault(page, "without news")
        assert not page.faults
        page.context.close()


def test_a_list_of_parts(chromium: Any, tmp_path: Path) -> None:
    tool = gripper_with_parts(tmp_path)
    (folder := tmp_path / "live").mkdir()
    with Live(folder, "nominal", tool=tool) as live:
        page = opened(chromium, live)
        shows(page, "state-word", "STAND_BY")
        page.click("#control-take")
        shows(page, "control-who", "This page has the control.")
        page.select_option("#part", "box")
        page.click("#command-grip")
        shows(page, "state-word", "GRIPPED: box")
        page.locator("#card-cylinder .unused", has_text="not used for box").wait_for()
        assert_no_fault(page, "a part is held")
        page.context.close()


def test_a_grip_that_fails(chromium: Any, tmp_path: Path) -> None:
    with Live(tmp_path, "never-confirms:bottom_vacuum") as live:
        page = opened(chromium, live)
        page.click("#control-take")
        page.click("#command-grip")
        page.locator("#cards .attempts:not([hidden])", has_text="attempt 2 of 3").wait_for()
        assert_no_fault(page, "gripping, after a failed attempt")
        page.context.close()


def test_a_recording(chromium: Any, served: Any, retried: Path) -> None:
    page = test_recordings.opened(chromium, served(str(retried)))
    shows(page, "judged", "identical decisions")
    assert_no_fault(page, "at its beginning")
    page.fill("#scrub", "5.2")
    shows(page, "state-word", "GRIPPING")
    page.locator("#log button", has_text="State GRIPPING").first.click()
    shows(page, "event", "guard")
    assert_no_fault(page, "at an event")
    test_recordings.close(page)


def test_two_recordings_in_one_file(chromium: Any, retried: Path, nominal: Path, tmp_path: Path) -> None:
    both = test_recordings.reported(tmp_path, retried, nominal)
    page = test_recordings.opened(chromium, f"file://{both}")
    assert_no_fault(page, "two in a report")
    page.locator("#differences-rows button").first.focus()
    page.keyboard.press("Enter")
    page.wait_for_selector("#differences-rows tr[aria-current]")
    assert_no_fault(page, "at a difference of the two")
    test_recordings.close(page)


def test_many_runs_in_one_file(chromium: Any, retried: Path, tmp_path: Path) -> None:
    """Their table, one of which cannot be read."""
    shutil.copytree(retried, tmp_path / "runs" / "retried")
    (tmp_path / "runs" / "torn").mkdir()
    (tmp_path / "runs" / "torn" / "hal.mcap").write_bytes(b"x")
    many = test_recordings.reported(tmp_path, tmp_path / "runs", expected=1)
    page = test_recordings.opened(chromium, f"file://{many}")
    assert_no_fault(page, "runs in a report")
    test_recordings.close(page)
