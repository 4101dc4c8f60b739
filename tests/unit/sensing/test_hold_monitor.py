"""What is watched while a part is held, in virtual time against the testbench's physics."""

from __future__ import annotations

from collections.abc import Callable
from math import exp
from random import Random

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.control import Status
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.sensing import SENT_INVALID, SensorSet
from end_effector_hal.sensing._hold_monitor import HoldMonitor
from end_effector_hal.signals import Frame
from tests.support.nightly import first_of
from tests.support.virtual_tool import VirtualTool

GRIP_ERROR, GRIPPED, STAND_BY = 2, 3, 6


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


def gripped(description: Description, scenario: str = "nominal", seconds: float = 3.0) -> VirtualTool:
    tool = VirtualTool(description, scenario)
    tool.run(1.0)
    assert tool.command("grip").accepted
    tool.run(seconds)
    assert tool.status.ee == GRIPPED
    return tool


def first(tool: VirtualTool, such: Callable[[Status], bool]) -> float:
    """Seconds at which a status was first such."""
    return next(status.at for status in tool.statuses if such(status)) / 1e6


def has(words: str) -> Callable[[Status], bool]:
    return lambda status: any(words in alarm for alarm in status.alarm_texts)


def choose(tool: VirtualTool, scenario: str) -> None:
    tool.bench.choose(scenario, tool.at)


def test_a_good_grip_is_confirmed_then_secure_and_nothing_is_told(description: Description) -> None:
    tool = gripped(description)
    confirmed, secure = first(tool, lambda status: status.ee == GRIPPED), first(tool, lambda s: s.secure)
    assert 0.3 < secure - confirmed < 1.0  # the physics: 55 kPa after 0.33 s, 75 kPa after 0.95 s
    assert tool.status.lift_allowed
    tool.run(60.0)
    assert not any(status.alarm_texts for status in tool.statuses if status.ee == GRIPPED)
    assert tool.status.secure
    tool.command("drop")
    assert not tool.status.secure


def test_a_vacuum_that_never_gets_secure_is_weak_after_its_time(description: Description) -> None:
    tool = gripped(description, "leak:top_vacuum", 6.0)
    weak, since = first(tool, has("Weak grip")), first(tool, lambda status: status.ee == GRIPPED)
    assert weak - since == pytest.approx(2.02)  # 2 s, seen with the next frame
    assert tool.status.alarm_texts == (
        "Weak grip: Top vacuum did not reach 75 kPa within 2 s (67.6 kPa).",
    )  # fmt: skip
    assert tool.status.lift_allowed  # confirmed and fresh: a warning is no refusal
    assert not tool.status.secure


def test_where_a_lift_needs_a_secure_grip_it_waits_for_it(description: Description) -> None:
    hold = description.hold.model_copy(update={"lift_needs": "secure"})
    strict = description.model_copy(update={"hold": hold})
    assert not gripped(strict, "leak:top_vacuum", 6.0).status.lift_allowed
    tool = gripped(strict)
    assert first(tool, lambda status: status.lift_allowed) == first(tool, lambda status: status.secure)


def test_secure_has_a_hysteresis_of_15_kpa(description: Description) -> None:
    tool = gripped(description)
    choose(tool, "leak:top_vacuum")  # settles at 68 kPa, between 60 and 75
    tool.run(10.0)
    assert tool.status.secure
    choose(tool, "leak:top_vacuum:8")  # settles at 58 kPa
    tool.run(10.0)
    assert not tool.status.secure
    assert any(alarm.startswith("Weak grip: Top vacuum fell to ") for alarm in tool.status.alarm_texts)
    choose(tool, "leak:top_vacuum")
    tool.run(10.0)
    assert not tool.status.secure
    choose(tool, "nominal")
    tool.run(10.0)
    assert tool.status.secure


def test_a_weak_grip_that_is_over_stays_told_until_a_drop(description: Description) -> None:
    tool = gripped(description)
    choose(tool, "leak:top_vacuum:8")
    tool.run(5.0)
    choose(tool, "nominal")
    tool.run(5.0)
    assert [alarm for alarm in tool.status.alarm_texts if alarm.startswith("Over: Top vacuum was not secure")]
    assert tool.command("drop").accepted
    assert tool.status.alarm_texts == ()
    tool.run(3.0)
    assert tool.status.ee == STAND_BY


def test_acknowledged_is_what_is_over_and_nothing_else(description: Description) -> None:
    tool = gripped(description, "leak:bottom_vacuum", 6.0)
    choose(tool, "leak:bottom_vacuum,leak:top_vacuum:8")
    tool.run(5.0)
    choose(tool, "leak:bottom_vacuum")
    tool.run(5.0)
    assert len([alarm for alarm in tool.status.alarm_texts if "secure" in alarm or "Weak" in alarm]) == 2
    tool.controller.acknowledge(tool.at)
    assert [alarm.split(" (")[0] for alarm in tool.status.alarm_texts] == [
        "Weak grip: Bottom vacuum did not reach 75 kPa within 2 s",
    ]


def test_a_growing_leak_is_told_before_the_grip_is_lost(description: Description) -> None:
    tool = gripped(description)
    edges = tool.edges.copy()
    choose(tool, "leak-grows:top_vacuum:2")
    tool.run(20.0)
    assert tool.status.ee == GRIP_ERROR
    told, lost = (
        first(tool, has("Leak: Top vacuum falls")),
        first(tool, lambda status: status.ee == GRIP_ERROR),
    )
    assert lost - told > 2.0
    at_leak = next(status for status in tool.statuses if has("Leak:")(status))
    assert at_leak.ee == GRIPPED
    assert at_leak.evidence == (3, 3, 3)
    assert not at_leak.lift_allowed  # what is about to be lost is not lifted
    assert tool.edges == edges  # a warning moves no line, nor does the loss


def test_a_leak_that_goes_on_is_told_without_a_break(description: Description) -> None:
    tool = gripped(description)
    choose(tool, "leak:top_vacuum:9,leak-grows:top_vacuum:0.4")
    tool.run(25.0)
    assert tool.status.ee == GRIP_ERROR
    leaking = [status for status in tool.statuses if has("Leak:")(status)]
    assert leaking
    assert not any(has("Over: Top vacuum leaked")(status) for status in tool.statuses)


def test_the_time_to_get_secure_begins_with_each_grip(description: Description) -> None:
    tool = gripped(description, "leak:top_vacuum", 6.0)
    assert tool.command("drop").accepted
    tool.run(3.0)
    assert tool.command("grip").accepted
    again = tool.at / 1e6
    tool.run(6.0)
    later = [status for status in tool.statuses if status.at / 1e6 > again]
    gripped_at = next(status.at for status in later if status.ee == GRIPPED)
    weak_at = next(status.at for status in later if has("Weak grip")(status))
    assert (weak_at - gripped_at) / 1e6 == pytest.approx(2.02)


@pytest.mark.parametrize("leak", first_of(["11", "11.3", "11.6"]))
def test_noise_near_the_threshold_is_no_leak(description: Description, leak: str) -> None:
    """Steady at some 50.5 to 52 kPa, where a little fall would be a loss."""
    tool = gripped(description)
    choose(tool, f"leak:top_vacuum:{leak}")
    tool.run(60.0)
    assert tool.status.ee == GRIPPED, tool.status.reason
    assert not any(has("Leak:")(status) for status in tool.statuses)


@pytest.mark.parametrize("leak", first_of(["8", "1", "2", "4", "6"], 2))
def test_a_leak_that_the_ejector_keeps_up_with_is_no_trend(description: Description, leak: str) -> None:
    tool = gripped(description)
    choose(tool, f"leak:top_vacuum:{leak}")
    tool.run(30.0)
    assert tool.status.ee == GRIPPED
    assert not any(has("Leak:")(status) for status in tool.statuses)


@pytest.mark.parametrize("noise_kpa", first_of([0.3, 0.1]))
@pytest.mark.parametrize("tau_s", first_of([0.05, 0.8, 0.3, 0.45], 2))
@pytest.mark.parametrize("fall_kpa", first_of([10, 25, 17], 2))
def test_a_fall_to_another_level_is_no_leak(
    description: Description, fall_kpa: float, tau_s: float, noise_kpa: float
) -> None:
    """Faster than the window and noisier than the bench."""
    random = Random(f"{fall_kpa} {tau_s} {noise_kpa}")
    senses = SensorSet(description, get_codec("ees1-ascii"))
    monitor = HoldMonitor(description, senses, get_codec("ees1-ascii"))
    for at in range(20_000, 12_000_000, 20_000):
        past_s = max(0.0, at / 1e6 - 4.0)
        kpa = 85 - fall_kpa * (1 - exp(-past_s / tau_s)) + random.gauss(0.0, noise_kpa)
        values = {"bottom": round(-1000 * kpa), "top": -85_000, "cylinder_extended": True, "supply": 600_000}
        senses.frame(Frame(at, None, None, values))
        monitor.sample(at, held=True)
        assert monitor.allows_lift, (at, monitor.alarms)


def test_stale_while_held_is_told_and_stays_told_when_it_is_over(description: Description) -> None:
    tool = gripped(description)
    choose(tool, "invalid:top_vacuum")
    tool.run(1.0)
    status = tool.status
    assert (status.ee, status.evidence[2], status.held, status.lift_allowed) == (GRIPPED, 0, True, False)
    assert status.alarm_texts == (
        f"No valid reading of Top vacuum while it holds a part ({SENT_INVALID}); active outputs stay active, only a "
        "Drop releases.",
    )
    choose(tool, "nominal")
    tool.run(3.0)
    assert tool.status.lift_allowed
    assert tool.status.alarm_texts == (
        "Over: Top vacuum had no valid reading for a while; it is read again.",
    )


def test_a_supply_that_falls_while_held_is_told_and_releases_nothing(description: Description) -> None:
    tool = gripped(description)
    edges = tool.edges.copy()
    choose(tool, "supply:430")
    tool.run(5.0)
    assert any(alarm.startswith("Low supply: under 450 kPa while") for alarm in tool.status.alarm_texts)
    assert tool.status.ee == GRIPPED
    assert tool.edges == edges


def test_a_lost_grip_says_what_was_seen_and_what_to_do(description: Description) -> None:
    tool = gripped(description, "lost-after:bottom_vacuum:6", 10.0 - 5.0)
    tool.run(5.0)
    status = tool.status
    assert status.ee == GRIP_ERROR
    assert status.reason.startswith("Bottom vacuum was lost: ")
    assert status.reason.endswith(" kPa below ambient, 50 kPa required.")
    kpa = float(status.reason.split()[4])
    assert kpa < 50.0
    assert status.alarm_texts == (
        f"GRIP_ERROR: {status.reason} Active outputs stay active; only a Drop releases.",
    )


def test_an_adopted_part_is_watched_as_well(description: Description) -> None:
    levels = {actuator.line: True for _, actuator in description.ordered}
    tool = VirtualTool(description, "leak:top_vacuum", levels=levels)
    tool.run(4.0)
    assert tool.status.ee == GRIPPED
    assert any(alarm.startswith("Weak grip: Top vacuum did not reach") for alarm in tool.status.alarm_texts)


@pytest.mark.parametrize(
    ("scenario", "reason"),
    [
        ("supply:395", "IL-06: the supply pressure is 395 kPa, a grip requires at least 400 kPa."),
        (
            "supply:410",
            "IL-06: the supply pressure was too low and is 410 kPa, a grip requires at least 420 kPa again.",
        ),
    ],
)
def test_too_little_air_refuses_a_grip_and_says_how_much_it_takes(
    description: Description, scenario: str, reason: str
) -> None:
    tool = VirtualTool(description, "supply:300")
    tool.run(1.0)
    choose(tool, scenario)
    tool.run(2.0)
    assert tool.command("grip").reason == reason
    choose(tool, "supply:425")
    tool.run(2.0)
    assert tool.command("grip").accepted
    tool.run(3.0)
    assert tool.status.ee == GRIPPED  # under 450 kPa: a warning only
    assert any(alarm.startswith("Low supply: under 450 kPa") for alarm in tool.status.alarm_texts)
