"""Faults of a testbench by the page, in a real browser: choose, arm, go, nominal again."""

from __future__ import annotations

import json
import os
import signal
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.acceptance.page.conftest import Live
from tests.acceptance.page.test_page import opened, shot, shows


@pytest.fixture
def nominal(tmp_path: Path) -> Iterator[Live]:
    with Live(tmp_path, "nominal") as live:
        yield live


def choose(page: Any, kind: str, place: str = "", number: str = "") -> None:
    page.select_option("#fault-kind", kind)
    if place:
        page.select_option("#fault-place", place)
    if number:
        page.fill("#fault-number", number)


def press(page: Any, word: str) -> None:
    """With the keyboard: the browser's driver clicks on nothing that is disabled."""
    page.focus(f"#fault-{word}")
    page.keyboard.press("Enter")


def posted(page: Any, path: str, content: dict[str, str], *, csrf: bool = True) -> tuple[int, str]:
    """What the server answers to a POST from the page itself, whatever its buttons allow."""
    script = """async ([path, content, csrf]) => {
        const headers = { "content-type": "application/json" };
        if (csrf) headers["x-eehal-csrf"] = document.querySelector("meta[name=csrf]").content;
        const id = sessionStorage.getItem("eehal-page");
        const answer = await fetch(path, { method: "POST", headers, body: JSON.stringify({ page: id, ...content }) });
        return [answer.status, await answer.text()];
    }"""
    status, text = page.evaluate(script, [path, content, csrf])
    return status, text


def test_a_grip_fails_by_a_fault_that_was_chosen_here(chromium: Any, nominal: Live) -> None:
    page, other = opened(chromium, nominal), opened(chromium, nominal)
    shows(page, "state-word", "STAND_BY")
    page.wait_for_selector("#faults:not([hidden])")
    shows(page, "faults-now", "Nothing is wrong.")
    choose(page, "never-confirms", "bottom_vacuum")
    assert page.input_value("#fault-text") == "never-confirms:bottom_vacuum"
    shows(page, "fault-meaning", "no activation has any effect")
    # nothing without the control, and nothing without arming
    shows(page, "why-fault-arm", "Take control first.")
    press(page, "arm")
    shows(page, "fault-answer", "Arm: Take control first.")
    page.click("#control-take")
    shows(page, "why-fault-go", "Arm it first.")
    press(page, "go")
    shows(page, "fault-answer", "Go: Arm it first.")
    page.click("#fault-arm")
    shows(page, "fault-answer", "Arm: never-confirms:bottom_vacuum is armed.")
    shows(other, "faults-now", "Page 1 has armed never-confirms:bottom_vacuum.")
    shows(other, "why-fault-go", "Take control first.")
    shows(page, "why-fault-go", "s left.")
    shot(page, "fault-armed", whole=True)
    page.click("#fault-go")
    for each in (page, other):
        shows(each, "faults-now", "Now: never-confirms:bottom_vacuum")
    page.click("#command-grip")
    failed = "Bottom vacuum was not confirmed within 5 s in 3 attempts."
    shows(page, "state-reason", failed, timeout_ms=60_000)
    shows(page, "state-word", "STAND_BY")
    # what became of the command stands as large as the state, and nothing says that it went well
    shows(page, "goal-word", "Grip failed")
    shows(page, "goal-detail", failed)
    assert page.get_attribute("#panel-goal", "data-tone") == "bad"
    size = "(name) => parseFloat(getComputedStyle(document.querySelector(name)).fontSize)"
    assert page.evaluate(size, "#goal-word") > 0.9 * page.evaluate(size, "#state-word")
    assert page.inner_text("#answer") == ""
    shows(page, "log", "The testbench plays: never-confirms:bottom_vacuum.")
    shows(page, "log", "Page 1: fault, go never-confirms:bottom_vacuum.")
    shot(page, "fault", whole=True)
    page.click("#fault-nominal")
    shows(other, "faults-now", "Nothing is wrong.")
    page.click("#command-grip")
    shows(page, "state-word", "GRIPPED")
    for each in (page, other):
        assert not each.faults
        each.context.close()


def test_a_bad_scenario_is_refused_in_the_words_of_the_testbench(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    page.wait_for_selector("#faults:not([hidden])")
    page.click("#control-take")
    shows(page, "why-fault-arm", "After arming, press Go within 10 s.")
    choose(page, "lost-after", "top_vacuum", "0")
    page.click("#fault-arm")
    shows(page, "fault-answer", "seconds must be a number from 0.001 to 86400.")
    page.fill("#fault-text", "leek:top_vacuum")
    page.click("#fault-arm")
    shows(page, "fault-answer", "no fault is named 'leek'. Did you mean 'leak'?")
    shows(page, "why-fault-go", "Arm it first.")
    # several, and then another text than what is armed
    page.fill("#fault-text", "leak:top_vacuum:4,no-tool")
    page.click("#fault-arm")
    shows(page, "fault-answer", "leak:top_vacuum:4,no-tool is armed.")
    page.fill("#fault-text", "no-tool")
    shows(page, "why-fault-go", "leak:top_vacuum:4,no-tool is armed, not this scenario. Arm again.")
    # what no button of the page does
    status, text = posted(page, "/fault", {"word": "go", "scenario": "no-tool"})
    assert (status, json.loads(text)["reason"]) == (
        200,
        "Another scenario is armed: leak:top_vacuum:4,no-tool.",
    )
    assert posted(page, "/fault", {"word": "go"}, csrf=False)[0] == 403
    assert posted(page, "/fault", {"word": "play", "scenario": "no-tool"})[0] == 400
    assert posted(page, "/fault", {"word": "arm", "scenario": "x" * 301})[0] == 400
    assert posted(page, "/fault", {"word": "arm", "scenario": "x" * 3_000})[0] == 400
    page.wait_for_timeout(10_500)  # the arming ends by itself
    shows(page, "why-fault-go", "Arm it first.")
    late = posted(page, "/fault", {"word": "go", "scenario": "leak:top_vacuum:4,no-tool"})[1]
    assert json.loads(late)["reason"].startswith("Arm a scenario first")
    page.click("#control-take")  # gives it back
    shows(page, "control-who", "No page is in control.")
    for word in ("arm", "go", "nominal"):
        assert json.loads(posted(page, "/fault", {"word": word})[1])["reason"] == "Take control first."
    shows(page, "faults-now", "Nothing is wrong.")
    page.context.close()


def test_a_testbench_that_is_stopped_is_grey_and_one_that_dies_has_no_panel(
    chromium: Any, nominal: Live
) -> None:
    page = opened(chromium, nominal)
    page.wait_for_selector("#faults:not([hidden]):not(.silent)")
    page.click("#control-take")
    shows(page, "why-fault-arm", "After arming, press Go within 10 s.")
    os.killpg(nominal.world.testbench.pid, signal.SIGSTOP)
    page.wait_for_selector("#faults.silent", timeout=1_200 + 300)
    shows(page, "faults-now", "The testbench is silent.")
    assert page.get_attribute("#fault-arm", "aria-disabled") == "true"
    os.killpg(nominal.world.testbench.pid, signal.SIGCONT)
    page.wait_for_selector("#faults:not([hidden]):not(.silent)")
    os.killpg(nominal.world.testbench.pid, signal.SIGKILL)
    page.wait_for_selector("#faults", state="hidden", timeout=1_200)
    assert (
        json.loads(posted(page, "/fault", {"word": "nominal"})[1])["reason"]
        == "No testbench is at the other end of the wires."
    )
    assert not page.faults
    page.context.close()


def test_the_panel_on_a_phone_and_by_the_keyboard(chromium: Any, nominal: Live) -> None:
    page = opened(
        chromium, nominal, viewport={"width": 390, "height": 844}, color_scheme="dark", device_scale_factor=2
    )
    page.wait_for_selector("#faults:not([hidden])")
    reached = set()
    for _ in range(30):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("() => document.activeElement.id"))
    assert {"fault-kind", "fault-place", "fault-text", "fault-arm", "fault-go", "fault-nominal"} <= reached
    choose(page, "leak", "top_vacuum", "12")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390, (
        "nothing stands out to the right"
    )
    page.locator("#faults").scroll_into_view_if_needed()
    shot(page, "faults-phone")
    page.context.close()


def test_nobody_chooses_a_fault_without_the_token(nominal: Live) -> None:
    host = nominal.url.split("/?")[0]
    asked = urllib.request.Request(f"{host}/fault", data=b'{"page":"0123456789abcdef","word":"nominal"}')
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(asked)
    assert refused.value.code == 401
    refused.value.close()
