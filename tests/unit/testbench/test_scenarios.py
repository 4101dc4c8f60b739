"""Scenarios as text: what is read, refused, and offered."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Channel, Description, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.faults import FaultOffer
from end_effector_lab.testbench import (
    FAULTS,
    Scenario,
    chosen_models,
    offered_faults,
    parse_scenario,
    possible_faults,
)
from end_effector_lab.testbench._scenario import Effect
from end_effector_lab.testbench._units import shown_by_models
from tests.support.places import ROOT

ASKED = """
schema: 2
name: asked
link: {port: /dev/ttyS0, period_ms: 50, frame: {text: {ask: "READ\\r"}}}
channels: {cup: {text: {field: 1}, unit: kPa}}
sequence: [cup]
actuators: {cup: {kind: vacuum, line: A, channel: cup}}
supply: {channel: none}
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("nominal", Scenario("nominal")),
        ("fails-once:cylinder", Scenario("", {"cylinder": Effect(dead_activations=1)})),
        ("fails:cylinder:2", Scenario("", {"cylinder": Effect(dead_activations=2)})),
        ("never-confirms:tool_changer", Scenario("", {"tool_changer": Effect(dead_activations=10**9)})),
        ("stuck-release:top_vacuum", Scenario("", {"top_vacuum": Effect(stuck=True)})),
        ("leak:top_vacuum", Scenario("", {"top_vacuum": Effect(leak_l_min=4.0)})),
        ("leak:top_vacuum:20", Scenario("", {"top_vacuum": Effect(leak_l_min=20.0)})),
        ("lost-after:cylinder:2.5", Scenario("", {"cylinder": Effect(lost_after_us=2_500_000)})),
        ("locked-shows:tool_changer:0", Scenario("", {"tool_changer": Effect(locked_shows=False)})),
        ("unlocked-shows:tool_changer:1", Scenario("", {"tool_changer": Effect(unlocked_shows=True)})),
        ("stand-shows:tool_changer:1", Scenario("", {"tool_changer": Effect(stand_shows=True)})),
        ("silent-after:5", Scenario("", silent_after_us=5_000_000)),
        ("noise:0.01", Scenario("", noise=0.01)),
        ("supply:380,no-tool", Scenario("", supply_kpa=380.0, tool_present=False)),
        (
            "fails-once:cylinder, leak:top_vacuum:4, stuck-release:cylinder, noise:0.1",
            Scenario(
                "",
                {"cylinder": Effect(dead_activations=1, stuck=True), "top_vacuum": Effect(leak_l_min=4.0)},
                noise=0.1,
            ),
        ),
    ],
)
def test_reads(verdin: Description, text: str, expected: Scenario) -> None:
    scenario = parse_scenario(text, verdin)
    assert scenario.text == text
    assert (
        scenario.effects,
        scenario.silent_after_us,
        scenario.noise,
        scenario.supply_kpa,
        scenario.tool_present,
    ) == (
        expected.effects,
        expected.silent_after_us,
        expected.noise,
        expected.supply_kpa,
        expected.tool_present,
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nominale", "Did you mean 'nominal'?"),
        ("", "no fault is named ''. There are: nominal, fails-once, "),
        ("never-confirm:cylinder", "Did you mean 'never-confirms'?"),
        ("fails-once:cylinda", "no actuator is named 'cylinda'. Did you mean 'cylinder'?"),
        ("fails-once", "names no actuator. There are: tool_changer, bottom_vacuum, cylinder, top_vacuum."),
        ("leak:cylinder", "cylinder cannot have this fault. It can have: fails-once,"),
        ("no-part:cylinder", "cylinder cannot have this fault"),
        ("lost-after:tool_changer:1", "tool_changer cannot have this fault"),
        ("locked-shows:cylinder:1", "cylinder cannot have this fault"),
        ("locked-shows:tool_changer", "needs a number. Expected: bit, a whole number from 0 to 1."),
        ("locked-shows:tool_changer:0.5", "bit must be a whole number from 0 to 1."),
        ("fails:cylinder:1.5", "'fails:cylinder:1.5': times must be a whole number from 1 to 1000."),
        ("lost-after:cylinder", "needs a number. Expected: seconds, a number from 0.001 to 86400."),
        ("lost-after:cylinder:soon", "seconds must be a number from 0.001 to 86400."),
        ("lost-after:cylinder:nan", "seconds must be a number from 0.001 to 86400."),
        ("noise:1.5", "'noise:1.5': rate must be a number from 0 to 1."),
        ("leak:top_vacuum:4:5", "has too many parts. Expected: leak:<actuator>[:<l_min>]."),
        ("nominal:cylinder", "has too many parts. Expected: nominal."),
        (
            "fails-once:cylinder,never-confirms:cylinder",
            "'never-confirms:cylinder' contradicts 'fails-once:cylinder'. Remove one of them.",
        ),
        ("noise:0.1,noise:0.2", "contradicts"),
        ("nominal,,", "no fault is named ''"),
    ],
)
def test_refuses_and_says_why(verdin: Description, text: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_scenario(text, verdin)
    assert message in str(caught.value)


def test_without_a_tool_changer_it_cannot_fail(verdin: Description) -> None:
    bare = verdin.model_copy(update={"tool_changer": None})
    with pytest.raises(UsageError, match="no actuator is named 'tool_changer'"):
        parse_scenario("never-confirms:tool_changer", bare)


def with_alarm(verdin: Description) -> Description:
    place = {"modbus": {"address": 1}}
    channels = {
        "pump": Channel.model_validate({**place, "alarm": [{"code": 8, "text": "too hot"}]}),
        "door": Channel.model_validate({**place, "alarm": "it is open"}),
    }
    return verdin.model_copy(update={"channels": channels})


def test_a_device_says_that_it_has_a_fault(verdin: Description) -> None:
    assert parse_scenario("alarm:pump:8,alarm:door", with_alarm(verdin)).alarms == {"pump": 8, "door": 1}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("alarm", "it names no channel. There are: pump, door."),
        ("alarm:dor", "no alarm is named 'dor'. Did you mean 'door'?"),
        ("alarm:pump:hot", "code must be a whole number"),
        ("alarm:pump:8:9", "has too many parts. Expected: alarm:<channel>[:<code>]."),
        ("alarm:pump:8,alarm:pump:9", "contradicts"),
    ],
)
def test_a_fault_of_a_device_that_it_cannot_have(verdin: Description, text: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_scenario(text, with_alarm(verdin))
    assert message in str(caught.value)
    with pytest.raises(UsageError, match="has no channel that is an alarm"):
        parse_scenario("alarm:pump", verdin)


def test_the_table_has_each_name_once() -> None:
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)


@pytest.mark.parametrize("number", ["١٢", "1_0", "nan", "inf", " 5", "5 ", "0x5", "1e", "", "9" * 50])
def test_a_number_stands_in_plain_digits(verdin: Description, number: str) -> None:
    with pytest.raises(UsageError, match="must be a number"):
        parse_scenario(f"supply:{number}:", verdin)


@pytest.mark.parametrize(("number", "kpa"), [("12", 12.0), ("1e2", 100.0), ("+.5", 0.5), ("3.", 3.0)])
def test_plain_digits_are_read(verdin: Description, number: str, kpa: float) -> None:
    assert parse_scenario(f"supply:{number}", verdin).supply_kpa == kpa


EXAMPLES = sorted(Path(__file__).parents[3].glob("examples/tools/*/end_effector.yaml"))


def text_of(offer: FaultOffer, place: str) -> str:
    number = "" if offer.number is None else f"{offer.number.low:g}"
    return ":".join(filter(None, (offer.name, place, number)))


@pytest.mark.parametrize("path", [profile_path(), *EXAMPLES], ids=lambda path: path.parent.name)
def test_what_is_offered_can_be_played_and_nothing_else(path: Path) -> None:
    """In each place that an offer names, and in none when it may be left out; what is not offered is refused."""
    tool = load_tool(path)
    offers = {offer.name: offer for offer in offered_faults(tool)}
    for offer in offers.values():
        assert offer.anywhere or offer.places
        for place in [*offer.places, *([""] if offer.anywhere else [])]:
            assert parse_scenario(text_of(offer, place), tool).text
        if not offer.anywhere:
            with pytest.raises(UsageError):
                parse_scenario(text_of(offer, ""), tool)
        else:
            assert offer.name in possible_faults(tool)
    own = shown_by_models(tool, chosen_models(None, tool))  # a testbench may play these from the description
    places = ["", "tool_changer", *(tool.actuators.keys() - own), *tool.named_links, *tool.channels]
    for fault in FAULTS:
        number = "" if fault.number is None else f"{fault.number.low:g}"
        allowed = offers[fault.name].places if fault.name in offers else ()
        for place in places:
            if place in allowed or (fault.name in offers and offers[fault.name].anywhere and not place):
                continue
            with pytest.raises(UsageError):
                parse_scenario(":".join(filter(None, (fault.name, place, number))), tool)


def test_a_sensor_in_a_unit_that_has_a_model_cannot_be_faulty() -> None:
    tool = load_tool(ROOT / "examples/tools/epick_commanded/end_effector.yaml")
    offered = {*possible_faults(tool)}
    assert {"leak:cup", "alarm:cup_fault", "wrong-answers"} <= offered
    assert {"invalid:cup", "shows:cup", "frozen-after:cup", "swapped:cup"}.isdisjoint(offered)
    assert "invalid:cup" in {
        f"{each.name}:{place}" for each in offered_faults(tool, {}) for place in each.places
    }


def test_the_answer_of_another_unit_is_a_fault_of_a_modbus_link(tmp_path: Path) -> None:
    (tmp_path / "tool.yaml").write_text(ASKED)
    tool = load_tool(tmp_path / "tool.yaml")
    offered = {*possible_faults(tool)}
    assert "no-answers" in offered
    assert "wrong-answers" not in offered
    with pytest.raises(UsageError, match="is a fault of a Modbus link, and asked is not Modbus"):
        parse_scenario("wrong-answers:0.5", tool)


def test_an_offer_says_what_the_list_says(verdin: Description) -> None:
    leak = next(offer for offer in offered_faults(verdin) if offer.name == "leak")
    assert leak.meaning == "it leaks: confirmed, but never secure"
    assert leak.usage == "leak:<actuator>[:<l_min>]"
    assert leak.places == ("bottom_vacuum", "top_vacuum")
    assert leak.number is not None
    assert (leak.number.low, leak.number.high, leak.number.default) == (0.1, 2000, 4.0)
    assert "leak:top_vacuum" in possible_faults(verdin)
    assert "alarm" not in possible_faults(verdin), "this tool has no channel that is an alarm"
