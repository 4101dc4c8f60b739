"""Each button, wherever the proof's explorer has been: what it says is what the HAL answers there, word for word."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from typing import Any

import pytest

from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.page.view import ToolView
from end_effector_hal.runtime.boundary import STATE, Published
from end_effector_hal.runtime.boundary._open import header_of
from end_effector_hal.runtime.stream import PUBLISHED
from end_effector_hal.vocabulary import ChangerState, EndEffectorState
from tests.support.blown import blown
from tests.support.declared import declared
from tests.support.nightly import first_of
from tests.unit.page.reachable import GRIPPING, Placed, Reached, reached

pytestmark = pytest.mark.timeout(600)


def without_stand(description: Description) -> Description:
    """No sensor shows the tool's stand: an unlock is armed first."""
    changer = description.tool_changer
    assert changer
    return description.model_copy(update={"tool_changer": changer.model_copy(update={"stand_bit": "none"})})


def tools() -> dict[str, Description]:
    """Without a tool changer; the shipped one; one that is armed, and keeps a part after a cancel; with a blow-off."""
    shipped = load(profile_path())
    keeps = declared({"gripping": {"cancel": "hold"}}, il_09=True)
    return {
        "without a tool changer": shipped.model_copy(update={"tool_changer": None}),
        "shipped": shipped,
        "armed, and keeps after a cancel": without_stand(keeps),
        "blown off": blown(),
    }


class Desk:
    """The page's view, and beside it the HAL, in the same state."""

    def __init__(self, description: Description) -> None:
        self.placed = Placed(description)
        self.view = ToolView(description, 0)
        self.at = self.placed.at
        self._send("header", header_of(description, 0))

    def put(self, where: Reached) -> Status:
        """The HAL is there, and the page hears of it as when it connects."""
        self._where = self.placed.snapshot(where)
        status = self.placed.put(self._where).status()
        self._send(STATE, self._where)
        self._send(PUBLISHED, Published(self.at, status, {}))
        return status

    def answer(self, word: str) -> Answer:
        """Of the HAL, given the command."""
        controller = self.placed.put(self._where)
        if word == "reset" and not controller.status().changer_fault:
            return Answer(True)  # then the tool changer is not asked, see `EndEffector.reset`
        return controller.command(word, self.at)[0]

    def _send(self, kind: str, content: object) -> None:
        self.view.take(kind, self.at, content, self.at)


def told_apart(states: list[Reached], words: Collection[str]) -> Iterator[tuple[Reached, set[str]]]:
    """Each state in which a command may be answered in a new way, with these commands.

    All of them where the pair of states in Table II is new.
    """
    gripping, seen = set(GRIPPING), set[Any]()
    for where in states:
        values = dict(where.values)
        pair = values["ee"], values["changer"], values["changer_fault"]
        new = set[str]()
        for key, its in (
            (("grip", where.of_grip), gripping),
            (("tool", where.of_tool), set(words) - gripping),
            (pair, set(words)),
        ):
            if key not in seen:
                seen.add(key)
                new |= its
        if new:
            yield where, new


@pytest.mark.parametrize("name", first_of(tools(), 0, 1))
def test_each_button_says_what_the_hal_answers(name: str) -> None:
    description = tools()[name]
    states = reached(description)
    possible = [where for where in states if where.shown.possible]
    assert {where.locations for where in possible} == {where.locations for where in states}
    desk = Desk(description)
    # a stop is latched by the line arbiter in every state
    words = set(desk.view.buttons) - {"stop"}
    said = defaultdict[str, set[str]](set)
    pairs = set()
    for where, asked in told_apart(possible, words):
        status = desk.put(where)
        if asked == words:
            pairs.add((status.ee, status.changer))
            shown = desk.view.now(desk.at)["buttons"]
            assert shown.pop("stop") == ""
        else:
            shown = {word: desk.view.refusal(word) for word in asked}
        for word, refusal in shown.items():
            answer = desk.answer(word)
            assert (answer.accepted, answer.reason) == (not refusal, refusal), (word, where)
            said[word].add(refusal)
    assert {ee for ee, _ in pairs} == set(EndEffectorState)
    fitted = description.tool_changer
    if fitted is not None:
        assert {changer for _, changer in pairs} == set(ChangerState)
    needs_no_arming = fitted is not None and fitted.stand_bit != "none"
    assert {word for word in said if "" not in said[word]} == ({"arm"} if needs_no_arming else set())
    for word, sentences in said.items():
        # without a tool changer only the line arbiter can refuse a reset
        assert len(sentences) > 1 or (word == "reset" and fitted is None), (word, sentences)
        assert all(each.endswith(".") for each in sentences if each), sentences
