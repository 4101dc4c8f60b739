"""Each button, wherever the proof's explorer has been: what it says is what the HAL answers there, word for word."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import pytest

from end_effector_hal.control import PROGRAMS, Answer, ControllerSnapshot, Status
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.page.view import ToolView
from end_effector_hal.runtime.boundary import PUBLISHED, STATE, Published
from end_effector_hal.runtime.boundary._open import header_of
from end_effector_hal.runtime.stream import program_of
from end_effector_hal.vocabulary import ChangerState, EndEffectorState
from tests.support.blown import blown
from tests.support.declared import declared
from tests.support.nightly import first_of
from tests.unit.page.reachable import Placed, Reached, reached

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


def of(word: str) -> str:
    """The program that decides; also of a reset, which is asked of both."""
    return "tool_change" if word == "reset" else program_of(word)


class Desk:
    """The page's view, and beside it the HAL, in the same state."""

    def __init__(self, description: Description) -> None:
        self.placed = Placed(description)
        self.view = ToolView(description, 0)
        self.at = self.placed.at
        self._where: dict[str, ControllerSnapshot] = {}
        self._status: dict[str, Status] = {}
        for program in PROGRAMS:
            self._send(program, "header", header_of(description, program, 0))

    def put(self, program: str, where: Reached) -> None:
        """A program is there, and the page hears of it as when it connects."""
        self._where[program] = snapshot = self.placed.snapshot(program, where)
        self._status[program] = self.placed.put(program, snapshot).status()
        self._send(program, STATE, snapshot)
        self._send(program, PUBLISHED, Published(self.at, self._status[program], {}))

    @property
    def words(self) -> tuple[str, ...]:
        """Of the buttons whose command a program decides: a stop is latched by the line arbiter in every state."""
        return tuple(word for word in self.view.buttons if word != "stop")

    def answer(self, word: str) -> Answer:
        """Of the HAL, given the command."""
        program = of(word)
        if word == "reset" and not self._status[program].changer_fault:
            return Answer(True)  # then the tool changer is not asked, see `EndEffector.reset`
        answer, _ = self.placed.put(program, self._where[program]).command(word, self.at)
        return answer

    def _send(self, program: str, kind: str, content: object) -> None:
        self.view.take(program, kind, self.at, content, self.at)


def told_apart(states: list[Reached]) -> Iterator[tuple[Reached, set[str]]]:
    """Each state of each program once, with both where the pair of their states in Table II is new."""
    seen = set[Any]()
    for where in states:
        values = dict(where.values)
        pair = values["ee"], values["changer"], values["changer_fault"]
        new = {program for program in PROGRAMS if pair not in seen or where.seen_by(program) not in seen}
        seen |= {pair, *(where.seen_by(program) for program in new)}
        if new:
            yield where, new


@pytest.mark.parametrize("name", first_of(tools(), 0, 1))
def test_each_button_says_what_the_hal_answers(name: str) -> None:
    description = tools()[name]
    states = reached(description)
    possible = [where for where in states if where.shown.possible]
    assert {where.locations for where in possible} == {where.locations for where in states}
    desk = Desk(description)
    said = defaultdict[str, set[str]](set)
    pairs = set()
    for where, programs in told_apart(possible):
        for program in programs:
            desk.put(program, where)
        status = desk.view.status()
        assert status is not None
        if programs == set(PROGRAMS):
            pairs.add((status.ee, status.changer))
            shown = desk.view.now(desk.at)["buttons"]
            assert shown["stop"] == ""
            buttons = {word: shown[word] for word in desk.words}
        else:
            buttons = {word: desk.view.refusal(word) for word in desk.words if of(word) in programs}
        for word, refusal in buttons.items():
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
