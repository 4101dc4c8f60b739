from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.faults import FaultOffer
from end_effector_lab.testbench import FAULTS, offered_faults, parse_scenario, possible_faults

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
    places = ["", "tool_changer", *tool.actuators, *tool.named_links, *tool.channels]
    for fault in FAULTS:
        number = "" if fault.number is None else f"{fault.number.low:g}"
        allowed = offers[fault.name].places if fault.name in offers else ()
        for place in places:
            if place in allowed or (fault.name in offers and offers[fault.name].anywhere and not place):
                continue
            with pytest.raises(UsageError):
                parse_scenario(":".join(filter(None, (fault.name, place, number))), tool)


def test_an_offer_says_what_the_list_says(verdin: Description) -> None:
    leak = next(offer for offer in offered_faults(verdin) if offer.name == "leak")
    assert leak.meaning == "it leaks: confirmed, but never secure"
    assert leak.usage == "leak:<actuator>[:<l_min>]"
    assert leak.places == ("bottom_vacuum", "top_vacuum")
    assert leak.number is not None
    assert (leak.number.low, leak.number.high, leak.number.default) == (0.1, 2000, 4.0)
    assert "leak:top_vacuum" in possible_faults(verdin)
    assert "alarm" not in possible_faults(verdin), "this tool has no channel that is an alarm"
