"""Each state in which a tool can rest, as the proof's explorer finds them, and a controller put there."""

from __future__ import annotations

import json
import re
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from pydantic import TypeAdapter
from pydantic_core import to_json

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import Controller, ControllerSnapshot, network_of
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.runtime.boundary import STATE, STREAMED
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerState, EndEffectorState, Evidence, ToolEvidence
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
