"""Each button, wherever the proof's explorer has been: what it says is what the HAL answers there, word for word."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Collection, Hashable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import pytest
from pydantic import TypeAdapter
from pydantic_core import to_json

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import Answer, Controller, ControllerSnapshot, Status, network_of
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.kinds import kind_of
from end_effector_hal.page.view import ToolView
from end_effector_hal.runtime.boundary import STATE, STREAMED, Published
from end_effector_hal.runtime.boundary._open import header_of
from end_effector_hal.runtime.stream import PUBLISHED
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerState, EndEffectorState, Evidence, ToolEvidence
from tests.support.blown import blown
from tests.support.declared import declared
from tests.support.nightly import first_of
from timed_automata import Network, State
from timed_automata.explore.search import Search
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits

PERIOD_US, FRAMES = 20_000, 60
WRITTEN = (
    *("ee", "command", "actuator", "valve", "kept", "blow", "cause", "cause_at"),
    *("changer", "changer_command", "changer_fault", "unlock_valve", "armed"),
)
"""What the executed automata write."""
GRIPPING = ("grip", "drop", "cancel", "resume")
"""The commands that the Gripper takes; the others are for the Changer and Arming."""
TOOL = ("changer", "changer_fault", "unlock_valve", "armed", "ee")
"""What the Changer, Arming and their sentences go by beside the sensors."""
VACUUM_PA = {Evidence.GONE: -1_000, Evidence.PARTIAL: -30_000, Evidence.CONFIRMED: -80_000}
CYLINDER = {
    Evidence.GONE: (1_000, False, True),
    Evidence.PARTIAL: (200_000, False, False),
    Evidence.CONFIRMED: (590_000, True, False),
}


@dataclass(frozen=True)
class Shown:
    """What the sensors show, in the levels of the model."""

    evidence: tuple[int, ...]
    tool: int
    supply_ok: bool
    vented: bool
    parked: bool

    @property
    def levels(self) -> dict[str, int]:
        """By the names of the model."""
        evidence = {f"evidence[{index}]": level for index, level in enumerate(self.evidence)}
        bits = {"supply_ok": self.supply_ok, "vented": self.vented, "parked": self.parked}
        return {**evidence, "tool": self.tool, **{name: int(bit) for name, bit in bits.items()}}

    @property
    def possible(self) -> bool:
        """The model lets more be vented than sensors that show it also show to be gone."""
        return not self.vented or set(self.evidence) == {Evidence.GONE}

    @property
    def silent(self) -> bool:
        """Nothing is known: the link is down."""
        known = *self.evidence, self.tool, self.supply_ok, self.vented, self.parked
        return not any(known)


@dataclass(frozen=True)
class Reached:
    """Where the tool rests.

    Attributes:
        locations: of the executed automata, by process.
        values: of the variables, by name.
        shown: by the sensors.
    """

    locations: tuple[tuple[str, str], ...]
    values: tuple[tuple[str, int], ...]
    shown: Shown

    @property
    def of_grip(self) -> Hashable:
        """What a command of `GRIPPING` goes by; the actuators' own automata take none."""
        values = dict(self.values)
        loose = values["unlock_valve"] or values["changer"] == ChangerState.FAULT
        asks_for_air = values["ee"] == EndEffectorState.STAND_BY
        shown = self.shown if asks_for_air else replace(self.shown, supply_ok=True)
        return dict(self.locations)["Gripper"], values["ee"], values["command"], values["cause"], loose, shown

    @property
    def of_tool(self) -> Hashable:
        """What the other commands go by."""
        places = [place for name, place in self.locations if name in ("Changer", "Arming")]
        values = [value for name, value in self.values if name in TOOL]
        return tuple(places), tuple(values), replace(self.shown, supply_ok=True)


def reached(description: Description) -> list[Reached]:
    """All of them, each with enough and with too little air: the model leaves that open."""
    network = network_of(description)
    names = set(description.automata.executed)
    executed = [each for each in network.processes if {each.name, each.template} & names]
    known = {*names, *description.automata.interface, *WRITTEN}
    variables = [name for name in network.offsets if re.split(r"[.\[]", name)[0] in known]
    found: dict[tuple[object, ...], Reached] = {}
    for node in Search(SymbolicSpace(DiscreteSpace(network), Limits(network))).nodes():
        state = node.record.discrete.state
        places = [each.locations[state.locations[each.index]] for each in executed]
        if any(place.committed or place.urgent for place in places):
            continue  # nobody sees it there
        locations = tuple((each.name, place.name) for each, place in zip(executed, places, strict=True))
        values = {name: state.values[network.offsets[name]] for name in variables}
        for supply_ok in (True, False):
            shown = shown_in(description, network, state, supply_ok=supply_ok)
            # the same for all commands: how often it was tried, how far the unwinding is
            asked = tuple(value for name, value in values.items() if "." not in name)
            found.setdefault((locations, asked, shown), Reached(locations, tuple(values.items()), shown))
    return list(found.values())


def shown_in(description: Description, network: Network, state: State, *, supply_ok: bool) -> Shown:
    """What a state's levels are for sensors that the tool has."""

    def value(name: str) -> int:
        return state.values[network.offsets[name]]

    changer, channels = description.tool_changer, carrier_of(description).channels
    evidence = tuple(value(name) for name in network.offsets if name.startswith("evidence["))
    if changer is None:
        return Shown(evidence, ToolEvidence.UNCLEAR, supply_ok, vented=False, parked=False)
    absent = value("tool") == ToolEvidence.ABSENT  # then nothing can be away from its stand
    parked = (bool(value("parked")) or absent) and changer.stand_bit in channels
    return Shown(evidence, value("tool"), supply_ok, bool(value("vented")), parked)


class Placed:
    """Puts a controller of a tool where the explorer has been, with sensors that show what the model says.

    Args:
        description: the tool.
    """

    def __init__(self, description: Description) -> None:
        self.description, self.network = description, network_of(description)
        self.at = FRAMES * PERIOD_US
        self._sensing = cache(self._sense)
        self._controller = Controller(description, self.network)

    def snapshot(self, where: Reached) -> ControllerSnapshot:
        """A controller in that state."""
        sensing = self._sensing(where.shown)
        locations = dict(where.locations)
        variables = {**sensing.execution.variables, **dict(where.values), **where.shown.levels}
        told = dict(sensing.memory["_statuses"])
        told["values"] = {name: variables[name] for name in told["values"]}
        told["adopted"], told["found"] = locations["Gripper"] != "Off", {}
        memory = {**sensing.memory, "_statuses": told, "_adopt_by": None}
        execution = replace(
            sensing.execution,
            at=self.at,
            entered=self.at,
            locations={**sensing.execution.locations, **locations},
            variables=variables,
            zeros=dict.fromkeys(sensing.execution.zeros, self.at),
        )
        return replace(sensing, execution=execution, memory=memory)

    def put(self, snapshot: ControllerSnapshot) -> Controller:
        """The controller, there; until it is put somewhere else."""
        self._controller.resume(snapshot)
        return self._controller

    def _sense(self, shown: Shown) -> ControllerSnapshot:
        """A controller that has seen this for a while."""
        controller = Controller(self.description, self.network)
        controller.start({}, 0)
        for number, values in enumerate(() if shown.silent else self._frames(shown), 1):
            at = number * PERIOD_US
            controller.frame(Frame(at, number, at // 1000, values))
        controller.advance(self.at)
        now = controller.senses.now
        levels = Shown(
            tuple(map(int, now.evidence)), int(now.tool), now.supply.ok, now.nothing_gripped, now.in_stand
        )
        assert levels == shown, "the sensors show what was asked"
        plain = json.loads(to_json(snapshot_of(controller), fallback=dict))
        read: ControllerSnapshot = adapter(STATE).validate_python(plain)
        return read

    def _frames(self, shown: Shown) -> Iterator[dict[str, Any]]:
        """They move a little, as living sensors do."""
        values = self._readings(shown)
        for number in range(FRAMES):
            yield {
                name: value + number % 3 if type(value) is int else value for name, value in values.items()
            }

    def _readings(self, shown: Shown) -> dict[str, Any]:
        values: dict[str, Any] = dict.fromkeys(carrier_of(self.description).channels)
        for (_, actuator), number in zip(self.description.ordered, shown.evidence, strict=True):
            level = Evidence(number)
            if level is Evidence.UNKNOWN:
                continue
            if kind_of(actuator).below_ambient:
                barely_gone = level is Evidence.GONE and not shown.vented
                values[actuator.channel] = -7_000 if barely_gone else VACUUM_PA[level]
            else:
                values |= dict(zip(kind_of(actuator).channel_names(actuator), CYLINDER[level], strict=True))
        values["supply"] = 600_000 if shown.supply_ok else 350_000
        locked, unlocked = {
            ToolEvidence.UNCLEAR: (None, None),
            ToolEvidence.LOCKED: (True, False),
            ToolEvidence.UNLOCKED: (False, True),
            ToolEvidence.FAULTY: (True, True),
            ToolEvidence.ABSENT: (True, False),
        }[ToolEvidence(shown.tool)]
        present = shown.tool != ToolEvidence.ABSENT
        values |= {"locked": locked, "unlocked": unlocked, "tool_present": present, "in_stand": shown.parked}
        return values


def snapshot_of(controller: Controller) -> ControllerSnapshot:
    """Of one that was started."""
    snapshot = controller.snapshot()
    assert snapshot is not None
    return snapshot


@cache
def adapter(kind: str) -> TypeAdapter[Any]:
    """Reads a record of a stream."""
    return TypeAdapter(STREAMED[kind])


# Each button, wherever the proof's explorer has been: what it says is what the HAL answers there, word for word.


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


@pytest.mark.timeout(600)
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
