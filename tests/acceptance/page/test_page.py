"""The live page in a real browser: what an operator sees and does."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.control import load_automata
from end_effector_hal.runtime.stream import ask_program, program_socket
from end_effector_hal.verification.mutation import kept_record
from end_effector_lab.processes import EEHAL
from tests.acceptance.page.conftest import Live
from tests.support.named_parts import gripper_with_parts
from tests.support.patience import wait_until

SHOTS = Path(os.environ.get("EEHAL_SHOTS", "runs/page"))
FRESH_MS = 20_000


@pytest.fixture
def nominal(tmp_path: Path) -> Iterator[Live]:
    with Live(tmp_path, "nominal") as live:
        yield live


def opened(chromium: Any, live: Live, **options: Any) -> Any:
    """A page that has news; it fails on any error in the browser, and remembers whom it asked."""
    context = chromium.new_context(**{"viewport": {"width": 1440, "height": 900}, **options})
    context.set_default_timeout(20_000)
    page = context.new_page()
    page.faults = []
    page.asked = set()
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("console", lambda said: page.faults.append(said.text) if said.type == "error" else None)
    page.on("request", lambda request: page.asked.add(request.url.split("/")[2]))
    page.goto(live.url)
    page.wait_for_selector("body:not(.stale)", timeout=FRESH_MS)
    return page


TOLD = ("state-word", "state-reason", "answer", "why-grip")
"""What the page says of the tool, for a failure."""


def shows(page: Any, name: str, text: str, timeout_ms: int = 20_000) -> None:
    from playwright.sync_api import TimeoutError as LateError

    try:
        page.locator(f"#{name}", has_text=text).wait_for(timeout=timeout_ms)
    except LateError:
        told = {each: page.locator(f"#{each}").all_text_contents() for each in (name, *TOLD)}
        pytest.fail(f"#{name} did not show {text!r} within {timeout_ms / 1000:g} s; the page shows {told}")


def shot(page: Any, name: str, *, whole: bool = False) -> None:
    """A picture of what is seen, or of the whole page; `make pictures` copies those that docs/images has."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=str(SHOTS / f"{name}.png"), full_page=whole, scale="css")


def press_forbidden(page: Any, word: str) -> None:
    """With the keyboard: the browser's driver clicks on nothing that is disabled."""
    page.focus(f"#command-{word}")
    page.keyboard.press("Enter")


def test_a_grip_and_a_drop_by_the_page(chromium: Any, nominal: Live) -> None:
    subprocess.run([*EEHAL, "verify", str(nominal.world.description_path)], check=True, capture_output=True)
    page = opened(chromium, nominal, viewport={"width": 1440, "height": 1000})
    shows(page, "state-word", "STAND_BY")
    page.locator("#fact-verdict", has_text=re.compile("hold")).wait_for()
    assert page.locator("#part").count() == 0, "the tool names no parts"
    shows(page, "why-grip", "Take control first.")
    press_forbidden(page, "grip")
    shows(page, "answer", "Take control first.")
    page.click("#control-take")
    shows(page, "control-who", "This page has the control.")
    page.click("#command-grip")
    shows(page, "state-word", "GRIPPED")
    shows(page, "held-word", "YES")
    shows(page, "lift-word", "YES")
    # a forbidden button: the sentence of the HAL, before and after it is pressed
    sentence = "IL-01: unlock only in STAND_BY; the end-effector is GRIPPED."
    shows(page, "why-unlock", sentence)
    assert page.get_attribute("#command-unlock", "aria-disabled") == "true"
    press_forbidden(page, "unlock")
    shows(page, "answer", sentence)
    page.locator("#held-detail", has_text=re.compile("^secure$")).wait_for()
    assert re.fullmatch(r"\+[\d.]+ kPa from (lost|confirmed)", page.locator(".margin").first.inner_text())
    shot(page, "page")
    page.wait_for_selector("#cards .hold")
    shot(page, "nominal", whole=True)
    # Drop asks again; no is no
    page.click("#command-drop")
    page.click("dialog button[value=no]")
    shows(page, "state-word", "GRIPPED")
    page.click("#command-drop")
    page.click("dialog button[value=yes]")
    shows(page, "state-word", "STAND_BY")
    shows(page, "held-word", "NO")
    log = page.inner_text("#log")
    assert "State GRIPPED" in log
    assert "Page 1: drop." in log
    page.locator("#log button", has_text="State GRIPPED").first.click()
    shows(page, "event", "guard")
    assert page.asked == {nominal.url.split("/")[2]}, "no request leaves the machine"
    assert not page.faults
    page.context.close()


def asked(live: Live, word: str) -> str:
    """Why the HAL itself refuses a command, asked beside the page; empty: it accepts it."""
    answer = ask_program(program_socket(live.world.description), word)
    assert answer.decided, answer.reason
    return "" if answer.accepted else answer.reason


def test_a_forbidden_button_shows_the_sentence_of_the_hal(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    shows(page, "state-word", "STAND_BY")
    page.click("#control-take")
    shows(page, "control-who", "This page has the control.")
    forbidden = {"drop", "resume", "cancel", "arm", "unlock"}
    for state, words in (("STAND_BY", forbidden - {"unlock"}), ("GRIPPED", forbidden - {"drop"} | {"grip"})):
        shows(page, "state-word", state)
        for word in words:
            sentence = asked(nominal, word)
            assert sentence, word
            shows(page, f"why-{word}", sentence)
            assert page.get_attribute(f"#command-{word}", "aria-disabled") == "true"
        if state == "STAND_BY":
            page.click("#command-grip")
            shows(page, "answer", "Grip: accepted.")
    assert page.get_attribute("#command-drop", "aria-disabled") == "false"
    assert page.inner_text("#why-drop") == ""
    assert not page.faults
    page.context.close()


def test_one_actuator_is_driven_in_maintenance(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    shows(page, "state-word", "STAND_BY")
    assert not page.is_visible("#drive-bottom_vacuum")
    page.click("#maintenance")
    shows(page, "why-drive-bottom_vacuum", "Take control first.")
    page.click("#control-take")
    shows(page, "why-drive-bottom_vacuum", "For 30 s at most.")
    page.click("#drive-bottom_vacuum")
    card = page.locator("#card-bottom_vacuum")
    card.get_by_text("● confirmed").wait_for()
    card.locator(".pill", has_text=re.compile("^OUTPUT ON$")).wait_for()
    shows(page, "why-drive-bottom_vacuum", "Deactivated in")
    shows(page, "why-grip", "IL-12: a grip is refused during maintenance.")
    shows(page, "held-word", "NO")
    shot(page, "maintenance")
    page.click("#drive-bottom_vacuum")
    card.get_by_text("○ gone").wait_for()
    card.locator(".pill", has_text=re.compile("^OFF$")).wait_for()
    page.click("#command-grip")
    shows(page, "state-word", "GRIPPED")
    sentence = page.inner_text("#why-drive-cylinder")
    assert sentence.startswith("IL-12"), sentence
    page.focus("#drive-cylinder")
    page.keyboard.press("Enter")
    shows(page, "answer", sentence)
    assert "Page 1: activate Bottom vacuum." in page.inner_text("#log")
    assert not page.faults
    page.context.close()


def test_an_edge_shows_the_requirements_that_need_it_and_that_speak_of_it(
    chromium: Any, nominal: Live
) -> None:
    page = opened(chromium, nominal)
    assert not page.is_visible("#automata"), "folded"
    page.click("#automata-fold > summary")
    page.wait_for_selector("#automata .place.here")
    assert not page.is_visible("#automata .spoken"), "on demand"
    page.click("#automata-requirements > summary")
    choices = page.locator("#automata-edge option").all_inner_texts()
    number = next(at for at, text in enumerate(choices) if text.endswith("StandBy → Activate"))
    page.select_option("#automata-edge", index=number)
    page.locator("#automata .spoken li", has_text="order-step").wait_for()
    page.locator("#automata").scroll_into_view_if_needed()
    shot(page, "requirements")
    gripper = load_automata(nominal.world.description).document.templates[0]
    needed = [kept_record().of_edge(gripper, edge) for edge in range(len(gripper.edges))]
    number = next(edge for edge, needs in enumerate(needed) if needs and needs.needed_by)
    page.select_option("#automata-edge", value=str(number))
    page.locator("#automata .spoken-title", has_text="Needed by").wait_for()
    first = needed[number]
    assert first is not None
    shown = page.locator("#automata .needed li b").all_inner_texts()
    assert shown == [*first.needed_by]
    assert not page.faults
    page.context.close()


def test_two_browsers_and_one_control(chromium: Any, nominal: Live) -> None:
    one, two = opened(chromium, nominal), opened(chromium, nominal)
    one.click("#control-take")
    shows(two, "control-who", "Page 1 has the control.")
    assert two.is_disabled("#control-take")
    shows(two, "why-grip", "Take control first.")  # until the HAL is ready, it says why itself
    press_forbidden(two, "grip")
    shows(two, "answer", "Take control first.")
    one.click("#command-grip")
    shows(two, "state-word", "GRIPPED")
    one.context.close()  # closing it moves no line, and its control ends by itself
    two.wait_for_selector("#control-take:not(:disabled)", timeout=20_000)
    shows(two, "state-word", "GRIPPED")
    two.click("#control-take")
    shows(two, "control-who", "This page has the control.")
    two.context.close()


def test_a_hal_that_dies_turns_the_page_grey_and_comes_back(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    shows(page, "state-word", "STAND_BY")
    nominal.hal.end(signal.SIGKILL)
    page.wait_for_selector("body.stale", timeout=1_200 + 300)
    shows(page, "news", "What you see is old.")
    assert page.get_attribute("#command-grip", "aria-disabled") == "true"
    shot(page, "no-news")
    nominal.hal = nominal.start_hal()
    page.wait_for_selector("body:not(.stale)", timeout=30_000)
    shows(page, "state-word", "STAND_BY")
    # stopped, not dead: the connection is there, and nothing comes
    nominal.hal.child.send_signal(signal.SIGSTOP)
    page.wait_for_selector("body.stale", timeout=1_200 + 600)
    nominal.hal.child.send_signal(signal.SIGCONT)
    page.wait_for_selector("body:not(.stale)", timeout=30_000)
    assert not page.faults
    page.context.close()


def test_a_stop_has_a_card(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    shows(page, "state-word", "STAND_BY")
    assert not page.is_visible("#panel-e-stop"), "there is no input for it"
    page.click("#command-stop")
    shows(page, "e-stop-word", "STOPPED")
    shows(page, "e-stop-detail", "nothing is activated until the faults are reset")
    assert page.get_attribute("#panel-e-stop", "data-tone") == "bad"
    shot(page, "page-stopped")
    assert not page.faults
    page.context.close()


def test_the_marks_of_a_pressure_have_one_size_on_every_width(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    heights = set()
    for width in (390, 800, 1440, 2600):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_timeout(200)
        found = page.evaluate(
            "() => [...document.querySelectorAll('.gauge text')].map((each) => each.getBoundingClientRect())"
        )
        assert found
        heights |= {round(each["height"]) for each in found}
        bar = page.locator(".gauge").first.bounding_box()
        assert min(each["left"] for each in found) >= bar["x"] - 1
    assert len(heights) == 1
    page.context.close()


def test_a_page_that_gets_no_news_says_why_and_can_still_stop(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    page.click("#control-take")
    shows(page, "control-who", "This page has the control.")
    page.context.route(
        "**/events*", lambda route: route.fulfill(status=503, body="12 pages are open already.")
    )
    other = page.context.new_page()
    other.goto(nominal.url.split("/?")[0])
    shows(other, "news-text", "12 pages are open already.")
    assert other.is_visible("#news-reload")
    # the stream of the first one breaks off: no control is kept by a page that sees nothing
    nominal.page.child.send_signal(signal.SIGSTOP)
    page.wait_for_selector("#news-reload:not([hidden])")
    shows(page, "why-grip", "This page is not live.")
    assert page.get_attribute("#command-stop", "aria-disabled") == "false"
    nominal.page.child.send_signal(signal.SIGCONT)
    page.click("#command-stop")
    shows(page, "answer", "Stop:")
    page.context.close()


def test_the_page_itself_that_dies_is_said_too(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    nominal.page.child.send_signal(signal.SIGSTOP)
    page.wait_for_selector("body.stale", timeout=1_200 + 600)
    shows(page, "news", "Lost connection to `eehal page`")
    nominal.page.child.send_signal(signal.SIGCONT)
    page.wait_for_selector("body:not(.stale)", timeout=20_000)
    page.context.close()


def test_a_phone_in_the_dark(chromium: Any, nominal: Live) -> None:
    page = opened(
        chromium,
        nominal,
        viewport={"width": 390, "height": 844},
        color_scheme="dark",
        has_touch=True,
        device_scale_factor=2,
    )
    shows(page, "state-word", "STAND_BY")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390, (
        "nothing stands out to the right"
    )
    boxes = [page.locator(f"#command-{word}").bounding_box() for word in ("cancel", "stop")]
    assert all(box["y"] + box["height"] <= 844 for box in boxes), "both are in reach"
    assert boxes[0]["x"] + boxes[0]["width"] < boxes[1]["x"], "none lies over the other"
    page.click("#control-take")
    page.click("#command-grip")
    shows(page, "state-word", "GRIPPED")
    page.locator("#held-detail", has_text=re.compile("^secure$")).wait_for()
    page.locator("#panel-state").scroll_into_view_if_needed()
    words = page.locator(".panel strong > span:not(.shape)")
    lines = words.evaluate_all(
        "all => all.map(e => e.offsetHeight / parseFloat(getComputedStyle(e).lineHeight))"
    )
    assert max(lines) < 1.5, "no word is broken into two lines"
    shot(page, "page-phone")
    page.context.close()


def test_the_keyboard_reaches_everything(chromium: Any, nominal: Live) -> None:
    page = opened(chromium, nominal)
    reached = set()
    for _ in range(30):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("() => document.activeElement.id"))
    words = ("grip", "drop", "resume", "cancel", "stop", "lock", "arm", "unlock", "reset")
    assert {"control-take", "log-kind", *(f"command-{word}" for word in words)} <= reached
    page.focus("#control-take")
    page.keyboard.press("Enter")
    shows(page, "control-who", "This page has the control.")
    page.context.close()


def test_a_part_is_chosen_from_the_list(chromium: Any, tmp_path: Path) -> None:
    tool = gripper_with_parts(tmp_path)
    (folder := tmp_path / "live").mkdir()
    with Live(folder, "nominal", tool=tool) as live:
        page = opened(chromium, live, viewport={"width": 390, "height": 844})
        shows(page, "state-word", "STAND_BY")
        assert page.locator("#part option").all_text_contents() == ["panel: 600 × 400 mm, 4 kg", "box"]
        assert page.locator(".unused:visible").count() == 0
        assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
        page.click("#control-take")
        shows(page, "control-who", "This page has the control.")
        # by the keyboard alone
        page.focus("#part")
        page.keyboard.press("b")
        assert page.input_value("#part") == "box"
        page.keyboard.press("Shift+Tab")
        assert page.evaluate("() => document.activeElement.id") == "command-grip"
        page.keyboard.press("Enter")
        shows(page, "state-word", "GRIPPED: box")
        page.locator("#card-cylinder .unused", has_text="not used for box").wait_for()
        assert page.locator(".unused:visible").count() == 2
        gauge = page.locator("#card-bottom_vacuum .gauge text", has_text="confirmed 40")
        gauge.wait_for()
        assert page.locator("#card-bottom_vacuum .gauge text", has_text="confirmed 55").count() == 0
        shot(page, "parts-phone", whole=True)
        page.set_viewport_size({"width": 1440, "height": 1000})
        shot(page, "parts", whole=True)
        assert "Grip box accepted." in page.inner_text("#log")
        page.click("#command-drop")
        page.click("dialog button[value=yes]")
        shows(page, "state-word", "STAND_BY")
        assert page.locator(".unused:visible").count() == 0
        assert page.input_value("#part") == "box", "it stays chosen"
        assert not page.faults
        page.context.close()


def test_a_failing_attempt_and_a_cancel(chromium: Any, tmp_path: Path) -> None:
    with Live(tmp_path, "never-confirms:cylinder") as live:
        page = opened(chromium, live)
        shows(page, "state-word", "STAND_BY")
        page.click("#control-take")
        page.click("#command-grip")
        page.locator("#cards .attempts:not([hidden])", has_text="attempt 2 of 3").wait_for(timeout=20_000)
        page.locator("#cards .timer:not([hidden])", has_text="time-out in").wait_for()
        shows(page, "log", "Cylinder was not confirmed within 5 s: attempt 1 of 3; Cylinder RETRACTED")
        shows(page, "goal-detail", "at most 58.00 s")
        shot(page, "page-failing")
        shot(page, "failing-attempt", whole=True)
        page.click("#control-take")  # gives it back: who sees that a grip must end may end it
        shows(page, "control-who", "No page is in control.")
        shows(page, "why-cancel", "No emergency stop.")
        page.click("#command-cancel")
        shows(page, "state-word", "STAND_BY")
        shows(page, "state-reason", "The grip was cancelled.")
        page.context.close()


def test_a_part_that_is_held_with_a_leak(chromium: Any, tmp_path: Path) -> None:
    with Live(tmp_path, "leak-grows:top_vacuum:2") as live:
        page = opened(chromium, live, color_scheme="dark")
        shows(page, "state-word", "STAND_BY")
        page.click("#control-take")
        page.click("#command-grip")
        page.locator("#cards .hold.leak", has_text="lost in").wait_for(timeout=40_000)
        page.locator("#log", has_text="Leak: Top vacuum").wait_for(timeout=30_000)
        shows(page, "held-detail", "not secure")
        assert page.get_attribute("#panel-held", "data-tone") == "warn"
        shot(page, "page-leak")
        shot(page, "held-with-a-leak", whole=True)
        page.context.close()


def test_nobody_comes_in_without_the_token(nominal: Live) -> None:
    host = nominal.url.split("/?")[0]
    for path, headers in (
        ("/", {}),
        ("/static/app.js", {}),
        ("/events?page=0123456789abcdef", {}),
        ("/", {"Host": "evil.example"}),
    ):
        request = urllib.request.Request(f"{host}{path}", headers=headers)
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(request)
        assert refused.value.code in (401, 421)
        assert "default-src 'none'" in refused.value.headers["content-security-policy"]
        refused.value.close()
    posted = urllib.request.Request(f"{host}/command", data=b'{"page":"0123456789abcdef","word":"grip"}')
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(posted)
    refused.value.close()
    wait_until("the HAL works", lambda: nominal.hal.child.poll() is None)
