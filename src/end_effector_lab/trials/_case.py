"""A case: a sequence of events for a tool, its file, and how it ends."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import EndEffectorState, hint
from end_effector_lab.testbench import parse_scenario, plain_number
from end_effector_lab.virtual import Switching

COMMANDS = ("grip", "drop", "cancel", "resume", "lock", "unlock", "arm", "reset")
ARBITER, HAL, ALL = "arbiter", "hal", "all"
PROCESSES = (HAL, ARBITER, ALL)
SCENARIO, KILL, END, START, DISK, POWER = "scenario", "kill", "end", "start", "disk", "power"
WAIT, NOMINAL = "wait", "nominal"
STORES = ("journal", "sessions", "mark")
TROUBLES = ("full", "fails", "hangs", "well")
MOST, LONGEST_S, LARGEST_BYTES = 500, 3600.0, 1_000_000
"""Limits of a case: number of events, length in seconds, and size of its file in bytes."""
_KNOWN = (
    f"There are: {', '.join(COMMANDS)}; scenario S; kill, end or start PROCESS ({', '.join(PROCESSES)}); "
    f"disk {'|'.join(STORES)} {'|'.join(TROUBLES)}; power."
)


class Happening(NamedTuple):
    """One event of a case.

    Attributes:
        at: time after the tool has come to rest, µs.
        what: a command; ``scenario S`` of the testbench; ``kill``, ``end`` or ``start`` and a process; ``disk`` with
            the arbiter's store and its trouble; ``power``: the power fails and returns.
    """

    at: int
    what: str

    @property
    def verb(self) -> str:
        """The first word."""
        return self.what.partition(" ")[0]

    @property
    def rest(self) -> str:
        """The text after the first word."""
        return self.what.partition(" ")[2]


@dataclass(frozen=True)
class Case:
    """The events of a tool in order of time.

    Attributes:
        seed: seed of the valves, the noise, and the random faults.
        happenings: the events in order.
    """

    seed: int
    happenings: tuple[Happening, ...]

    def with_(self, happenings: Iterable[Happening]) -> Case:
        """Return the case with other events, sorted by time."""
        return Case(self.seed, tuple(sorted(happenings, key=lambda each: each.at)))

    def as_json(self) -> dict[str, Any]:
        """Return the case in the form of its file, with seconds and words."""
        return {"seed": self.seed, "happenings": [[each.at / 1e6, each.what] for each in self.happenings]}

    @property
    def words(self) -> str:
        """The case in one line: ``grip; wait 0.5; kill hal``."""
        said, now = [], 0
        for each in self.happenings:
            wait = f"{(each.at - now) / 1e6:.6f}".rstrip("0").rstrip(".")
            said += [f"wait {wait}"] if each.at > now else []
            said.append(each.what)
            now = each.at
        return "; ".join(said)


def case_from_json(found: object, description: Description, where: str = "") -> Case:
    """Return a case from the content of a file; raises UsageError if it cannot be played with the tool."""
    try:
        assert isinstance(found, Mapping)
        seed, listed = found["seed"], found["happenings"]
        assert type(seed) is int
        assert isinstance(listed, list)
        assert len(listed) <= MOST
        assert all(type(at) in (int, float) and type(what) is str for at, what in listed)
        pairs = [(float(at), what) for at, what in listed]
        assert all(0 <= at <= LONGEST_S for at, _ in pairs)
    except (AssertionError, KeyError, OverflowError, TypeError, ValueError):
        raise UsageError(
            "This is not a case of a campaign.",
            where=where,
            todo='Expected: {"seed": 0, "happenings": [[0.5, "grip"], …]}, '
            f"at most {MOST}, from 0 to {LONGEST_S:g} s.",
        ) from None
    for _, what in pairs:
        check(what, description, where)
    return Case(seed, ()).with_(Happening(round(at * 1e6), what) for at, what in pairs)


def case_from_words(text: str, description: Description, *, seed: int = 0, where: str = "") -> Case:
    """Return a case from words in the form of `Case.words`: ``grip; wait 0.5; kill hal``; raises UsageError."""
    found, at = list[list[object]](), 0.0
    for part in (each.strip() for line in text.splitlines() for each in line.split(";")):
        verb, _, rest = part.partition(" ")
        if verb == WAIT:
            waited = plain_number(rest)
            if waited is None:
                raise UsageError(f"{part!r}: expected is 'wait SECONDS'.", where=where)
            at += waited
        elif part:
            found.append([at, part])
    return case_from_json({"seed": seed, "happenings": found}, description, where)


def read_case(path: Path, description: Description) -> Case:
    """Return the case in a file, as JSON or in words; raises UsageError."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_BYTES + 1)
        if len(data) > LARGEST_BYTES:
            raise ValueError(f"more than {LARGEST_BYTES} bytes")
        text = data.decode()
        found = json.loads(text) if text.lstrip().startswith("{") else None
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"The case cannot be read: {error}.", where=str(path)) from None
    if found is None:
        return case_from_words(text, description, where=str(path))
    return case_from_json(found, description, str(path))


def check(what: str, description: Description, where: str = "") -> None:
    """Raise UsageError if this event is not possible for the tool."""
    verb, _, rest = what.partition(" ")
    if verb == SCENARIO:
        parse_scenario(rest, description)
        return
    known = (
        (what in COMMANDS or what == POWER)
        or (verb == "grip" and rest in description.parts)
        or (verb in (KILL, END, START) and rest in PROCESSES)
        or (
            verb == DISK
            and len(words := rest.split(" ")) == 2
            and words[0] in STORES
            and words[1] in TROUBLES
        )
    )
    if not known:
        every = (*COMMANDS, SCENARIO, KILL, END, START, DISK, POWER, WAIT)
        raise UsageError(f"Nothing is named {what!r}{hint(verb, every)}.", where=where, todo=_KNOWN)


GRIPPED = EndEffectorState.GRIPPED


class CaseEnd(NamedTuple):
    """The state of the tool at the end of a case, before the faults are removed.

    Attributes:
        state: name of the state of the end-effector; empty: its program does not run.
        active: active outputs of the grip.
        moved: the switchings, such as ``cylinder on``.
    """

    state: str
    active: tuple[str, ...]
    moved: tuple[str, ...]

    @classmethod
    def of(
        cls, description: Description, state: str, every: Iterable[Switching], moved: Iterable[Switching]
    ) -> CaseEnd:
        """Return the state from the switchings since the start and since the beginning of the case."""
        active = {each.name: each.active for each in every}
        return cls(
            state,
            tuple(name for name in description.sequence if active.get(name)),
            tuple(map(str, moved)),
        )

    def __str__(self) -> str:
        return f"{self.state or 'not running'}; active: {', '.join(self.active) or 'none'}"


class Outcome(StrEnum):
    """The state of the tool when all movements have ended."""

    AT_REST = "at rest"
    """At rest: no command was begun."""
    REFUSED = "refused"
    """At rest: the last command was refused with a reason."""
    SUCCESS = "gripped"
    FAILED = "declared failure"
    """At rest: the grip failed and was unwound."""
    CANCELLED = "cancelled"
    RELEASED = "dropped on command"
    UNWOUND = "unwound by the last will"
    HELD = "held with alarm"
    """GRIP_ERROR, latched: every output stays."""
    STILL_THERE = "release error"
    """RELEASE_ERROR, latched: not every actuator is proven to be gone."""
    UNFINISHED = "not at rest in its time"


class Story:
    """Follows the commands and deaths of a case, to name its outcome.

    Attributes:
        refused: the times of the refused commands, µs.
    """

    def __init__(self) -> None:
        self._last = Outcome.AT_REST
        self.refused: list[int] = []

    def commanded(self, name: str, at: int, *, accepted: bool) -> None:
        """Process a command at ``at`` µs, and its answer."""
        begun = {"grip": Outcome.FAILED, "cancel": Outcome.CANCELLED, "drop": Outcome.RELEASED}
        if accepted:
            self._last = begun.get(name, self._last)
        else:
            self.refused.append(at)
            self._last = Outcome.REFUSED if self._last is Outcome.AT_REST else self._last

    def gripped(self) -> None:
        """Process the success of a grip."""
        self._last = Outcome.AT_REST if self._last is Outcome.FAILED else self._last

    def hal_dies(self, *, held: bool) -> None:
        """Process a death of the program; ``held``: while a part is held."""
        if held or self._last not in (Outcome.AT_REST, Outcome.REFUSED):
            self._last = Outcome.UNWOUND

    def outcome(self, state: EndEffectorState) -> Outcome:
        """Return the outcome of a tool that has come to rest in this state."""
        latched = {
            GRIPPED: Outcome.SUCCESS,
            EndEffectorState.GRIP_ERROR: Outcome.HELD,
            EndEffectorState.RELEASE_ERROR: Outcome.STILL_THERE,
        }
        return latched.get(state, self._last)
