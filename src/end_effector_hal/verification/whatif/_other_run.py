"""Another controller on recorded inputs, to the end of the recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import Any

from end_effector_hal.control import PROGRAMS, Controller, Status, model_constants, network_of, told_to_grip
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.plugins import named
from end_effector_hal.recording import content_hash
from end_effector_hal.runtime.boundary import INPUTS, STATE, RecordedController, feed
from end_effector_hal.verification.replay import Entry

from ._spans import ApartSpan, OutputLevels, apart, at_rest

_PEER = {"grip": "tool_change", "tool_change": "grip"}
MISSING = "Records of the run are missing here"
GUESS, GUESS_OVER = "guess", "guess_over"
"""Kinds of entries that are in no trace: the readings answer other outputs from here on (a sentence), or no longer."""


class OtherRun:
    """What another description would have done with the inputs of a recorded run.

    Rule 1. Recorded readings, commands and starts are the inputs, at their recorded times.
    Rule 2. Time-outs are those of the other description, and on time; but a program that was overdue then for a
    deadline of its own was not running, and neither would the other one have been: it goes on when that one did.
    Rule 3. What a program is told by the other one is as recorded, until the other one would say something else: from
    then on it is that.
    Rule 4. A refusal of the line arbiter counts while the outputs are those of the recorded run: the arbiter was never
    asked about others.
    Rule 5. The recorded tool has not seen the outputs of the other controller. From the first instant at which they
    differ, until both tools are at rest again, the story is a guess (`ApartSpan`).

    Args:
        description: the other tool.
        recorded: the tool that was recorded.

    Attributes:
        spans: of rule 5, in order of time; complete once `play` has ended.
        notes: in words: what could not be played.
    """

    def __init__(self, description: Description, recorded: Description) -> None:
        self.description = description
        self.spans: list[ApartSpan] = []
        self.notes: list[str] = []
        self._network = network_of(description)
        self._hash = content_hash(description)
        self._constants = model_constants(description)
        self._levels, self._recorded_levels = OutputLevels(description), OutputLevels(recorded)
        self._names = self._recorded_levels.names | self._levels.names
        network = network_of(recorded)
        self._sides = {
            program: _Side(program, partial(Controller, recorded, network, program)) for program in PROGRAMS
        }
        self._out: list[Entry] = []
        self._since: tuple[int, str] | None = None
        self._begin: int | None = None
        self._unasked = 0

    @property
    def apart_since(self) -> int | None:
        """µs of the first instant of rule 5; None: the outputs were the same all the time."""
        return self.spans[0].since if self.spans else None

    def play(self, entries: Iterable[Entry]) -> Iterator[Entry]:
        """The records that the other controller would have made.

        Args:
            entries: of the recorded run, both programs in the order of time.
        """
        for at, group in groupby(entries, key=lambda entry: entry.at):
            self._begin = at if self._begin is None else self._begin
            self._until(at)
            for entry in group:
                self._take(entry)
            self._compare(at)
            yield from self._drained()
        if self._since is not None:
            self.spans.append(ApartSpan(self._since[0], None, self._since[1]))
        if self._unasked:
            what = "refusal" if self._unasked == 1 else "refusals"
            self.notes.append(
                f"{self._unasked} {what} of the line arbiter are left out: the other controller had other outputs then."
            )

    def _take(self, entry: Entry) -> None:
        side, kind, record = self._sides[entry.program], entry.kind, entry.record
        if kind == "header":
            self._header(side, entry)
        elif kind == STATE and side.controller is None and not side.over:
            self._resume(side, record)
        elif kind in INPUTS and not side.over:
            side.follow(entry)
            self._feed(side, entry)
        elif kind == "status":
            side.recorded = record
        elif record is None and side.controller is not None:
            self._end(side, entry.at, "its trace cannot be read any further.")

    def _drained(self) -> Iterator[Entry]:
        out, self._out = self._out, []
        yield from out

    def _header(self, side: _Side, entry: Entry) -> None:
        header = replace(
            entry.record,
            description=self.description.name,
            hash=self._hash,
            constants=self._constants,
            source=str(self.description.source),
        )
        self._out.append(Entry(entry.at, side.program, "header", header))
        if entry.record.gap is not None and side.controller is not None:
            self._part(entry.at, f"{MISSING}.")

    def _begun(self, side: _Side) -> RecordedController:
        def put(record: tuple[str, int, object]) -> None:
            kind, at, content = record
            side.at = max(side.at, at)  # what is late is told after what it is late for, as in a recording
            self._out.append(Entry(side.at, side.program, kind, content))
            if isinstance(content, Status):
                side.status = content

        return RecordedController(self.description, self._network, side.program, put)

    def _resume(self, side: _Side, state: Any) -> None:
        """The first records of the run are gone: go on from where the recorded controller stood."""
        controller = self._begun(side)
        try:
            controller.resume(state)
            side.shadow = side.new_shadow()
            side.shadow.resume(state)
            side.status = side.recorded = state.status
        except Exception as error:  # noqa: BLE001 a state of another description fits or does not, in its own ways
            self._end(
                side, state.at, f"it does not take the state with which the recording begins: {named(error)}"
            )
            return
        side.controller = controller
        self._out.append(Entry(state.at, side.program, STATE, state))
        self.notes.append(
            f"The recording begins in the middle of a run: the {side.program} program goes on from the recorded state."
        )

    def _feed(self, side: _Side, entry: Entry) -> None:
        kind, record = entry.kind, entry.record
        if kind == "start":
            side.controller, side.status = self._begun(side), None
        if side.controller is None:
            return
        if kind == "refused" and self._since is not None:
            self._unasked += 1
            return
        if kind == "tell":
            if self._sides[_PEER[side.program]].apart:
                return  # it is told by `_pass_on` then
            side.heard |= record.values
        try:
            feed(side.controller, kind, record)
        except Exception as error:  # noqa: BLE001 what was damaged, or fits no other tool, ends no command
            said = (
                str(error)
                if isinstance(error, ReportedError)
                else f"impossible in this state: {named(error)}"
            )
            self._end(side, entry.at, f"it does not take the recorded {kind}: {said}")
            return
        self._pass_on(side, entry.at)

    def _end(self, side: _Side, at: int, why: str) -> None:
        side.controller, side.over = None, True
        begun = at if self._begin is None else self._begin
        self.notes.append(f"At {(at - begun) / 1e6:.3f} s the {side.program} program ends, for {why}")
        self._part(at, f"The {side.program} program is not played any further.")

    def _until(self, at: int) -> None:
        """What the other controller does by itself before the next input."""
        while True:
            due = [
                (deadline, name)
                for name, side in self._sides.items()
                if side.controller is not None
                and (deadline := side.controller.deadline) is not None
                and deadline < at
                and not side.overdue(deadline)
            ]
            if not due:
                return
            deadline, name = min(due)
            side = self._sides[name]
            assert side.controller is not None
            side.controller.advance(deadline)
            self._pass_on(side, deadline)
            self._compare(deadline)

    def _pass_on(self, side: _Side, at: int) -> None:
        """Tell the peer what has changed, once it is no longer what was recorded."""
        peer = self._sides[_PEER[side.program]]
        if not side.apart or side.status is None or peer.controller is None:
            return
        values = side.says(side.status)
        if any(peer.heard.get(name) != value for name, value in values.items()):
            peer.heard |= values
            peer.controller.update_peer(values, at)

    def _compare(self, at: int) -> None:
        """Whether the outputs are those of the recorded run, at the end of an instant."""
        known = [
            each for each in self._sides.values() if each.status is not None and each.recorded is not None
        ]
        for side in known:
            assert side.status is not None
            assert side.recorded is not None
            if not side.apart and side.says(side.status) != side.says(side.recorded):
                side.apart = True
                self._pass_on(side, at)
        levels = self._levels.of({each.program: each.status for each in known})
        recorded = self._recorded_levels.of({each.program: each.recorded for each in known})
        found = apart(recorded, levels, self._names) if levels != recorded else ""
        if found:
            self._part(at, f"{found}.")
        elif not found and self._since is not None and self._rest_again():
            self.spans.append(ApartSpan(self._since[0], at, self._since[1]))
            self._since = None
            self._out.append(Entry(at, "grip", GUESS_OVER, "Both tools are at rest: no guess any more."))
            for side in self._sides.values():
                side.apart = False

    def _part(self, at: int, why: str) -> None:
        if self._since is None:
            self._since = at, why
            self._out.append(Entry(at, "grip", GUESS, f"From here on a guess: {why}"))

    def _rest_again(self) -> bool:
        """Whether both tools stand where nothing depends on what happened before."""
        grip = self._sides["grip"]
        if any(side.over for side in self._sides.values()) or grip.status is None or grip.recorded is None:
            return False
        same = all(
            side.says(side.status) == side.says(side.recorded)
            for side in self._sides.values()
            if side.status is not None and side.recorded is not None
        )
        return same and at_rest(grip.status) and at_rest(grip.recorded)


class _Side:
    """One program: of the other run, and as it was recorded."""

    def __init__(self, program: str, new_shadow: Callable[[], Controller]) -> None:
        self.program, self.new_shadow = program, new_shadow
        self.shadow: Controller | None = None
        self.controller: RecordedController | None = None
        self.status: Status | None = None
        self.recorded: Status | None = None
        self.heard: dict[str, int] = {}
        self.apart = self.over = False
        self.at = 0

    def overdue(self, at: int) -> bool:
        """Whether the recorded program had something to do then, or before, and had not done it."""
        due = self.shadow.deadline if self.shadow is not None else None
        return due is not None and due <= at

    def follow(self, entry: Entry) -> None:
        """Have the recorded controller do what it did, to know what it waits for."""
        try:
            if entry.kind == "start":
                self.shadow = self.new_shadow()
            if self.shadow is not None:
                feed(self.shadow, entry.kind, entry.record)
        except Exception:  # noqa: BLE001 then nobody knows, and time-outs are on time
            self.shadow = None

    def says(self, status: Status) -> Mapping[str, int]:
        """What the other program is told of a status."""
        if self.program == "grip":
            return {"ee": int(status.ee)}
        return told_to_grip(status)
