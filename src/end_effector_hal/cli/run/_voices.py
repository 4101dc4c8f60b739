"""The output of ``eehal run`` about a tool: in words, or as JSON lines."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict
from typing import Any, Self

import click

from end_effector_hal.cli._output import json_text
from end_effector_hal.control import Answer, EventKind, Status, event_line, refused, unanswered
from end_effector_hal.control.goals import CHANNELS, Outcome
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.kinds import kind_of
from end_effector_hal.nodes.process import PER_S, Allowance
from end_effector_hal.runtime import Refused, Result
from end_effector_hal.vocabulary import (
    Alarm,
    Cause,
    Command,
    EndEffectorState,
    alarm_changes,
    display_name,
)
from end_effector_hal.wires import now_us

from ._causes import Causes
from ._journal import SystemdJournal, alarm_fields, event_fields

_ENDED = {
    Outcome.SUCCEEDED: "succeeded",
    Outcome.CANCELLED: "cancelled",
    Outcome.UNREACHABLE: "outcome unknown",
}
CAUGHT_UP_S = 1.0
Fields = Mapping[str, str]
NO_FIELDS: Fields = {}
SCENARIO = "SCENARIO"
"""Name of the command that selects another scenario; its answer is the scenario."""


def ignore_broken_output(write: Callable[..., None]) -> Callable[..., None]:
    """Make a printing function ignore a closed pipe or terminal, so that the tool continues."""

    def written(*args: Any, **options: Any) -> None:
        with suppress(OSError, MemoryError):
            write(*args, **options)

    return written


class _Clock:
    """Seconds since the start for lines that several threads print; the times of successive lines never decrease.

    It is a context: only the thread that is in it prints.
    """

    def __init__(self, begun: int | None) -> None:
        self._begun = now_us() if begun is None else begun
        self._last = self._begun
        self._lock = threading.RLock()

    def __enter__(self) -> Self:
        self._lock.acquire()
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def seconds(self, at: int | None) -> float:
        """Return the seconds since the start at a time in µs; None: now."""
        self._last = max(self._last, now_us() if at is None else at)
        return (self._last - self._begun) / 1e6


class Words:
    """Prints all events of the tool on stdout in one order, and errors on stderr; on a terminal with the seconds since
    the start.

    Alarms and the fate of held parts are printed on stderr if stdout cannot be written.

    Args:
        write: prints a line; ``err``: on stderr; raises OSError.
        timed: whether each line begins with its time.
        begun: time of the start, µs; None: now.
        journal: gets the lines with their fields instead of ``write``.
    """

    def __init__(
        self,
        write: Callable[..., None] = click.echo,
        *,
        timed: bool = False,
        begun: int | None = None,
        journal: SystemdJournal | None = None,
    ) -> None:
        self._write, self._timed, self._journal = write, timed, journal
        self._clock = _Clock(begun)
        self._common, self._worse = Allowance(), Allowance()

    def state(self, at: int, ee: str, actuators: dict[str, str]) -> None:
        """Print the states with the labels of the figures."""
        states = ", ".join(f"{display_name(name)} {each}" for name, each in actuators.items())
        self._paced(self._common, f"{ee}: {states}", at)

    def event(self, at: int, text: str, fields: Fields = NO_FIELDS) -> None:
        """Print a transition or a time-out."""
        self._paced(self._common, text, at, fields=fields)

    def alarm(self, at: int, alarm: Alarm, *, over: bool) -> None:
        """Print the begin or the end of an alarm in one line."""
        self._paced(
            self._worse,
            f"{'over' if over else 'alarm'}: {alarm.text}",
            at,
            urgent=True,
            fg=None if over else "yellow",
            fields=alarm_fields(alarm, over=over),
        )

    def result(self, command: Command, result: Result) -> None:
        """Print how a command ended, with the reason in words."""
        if result.outcome in (Outcome.REJECTED, Outcome.NOT_EXECUTED):
            self._say(refused(CHANNELS[command], result.reason), fg="red")
            return
        if isinstance(result, Refused):
            self._say(unanswered(CHANNELS[command], result.reason), fg="red")
            return
        after = f" after {result.seconds:.2f} s" if self._timed and result.seconds else ""
        steps = "; ".join(self._steps(result)) if self._timed and command is Command.GRIP else ""
        steps = f"{steps}." if steps else ""
        name = "DROP" if command is Command.RELEASE else command.name  # as the user typed it
        text = f"{name}: {_ENDED.get(result.outcome, 'failed')}{after}"
        more = " ".join(filter(None, (result.reason, steps)))
        self._say(f"{text}{f'. {more}' if more else ''}", fg="green" if result.succeeded else "red")

    def answer(self, name: str, answer: Answer) -> None:
        """Print whether a command without an end of its own was accepted."""
        if answer.accepted and name == SCENARIO:
            self._say(f"scenario: {answer.reason}", fg="green")
        elif answer.accepted:
            self._say(f"{name}: succeeded{f'. {answer.reason}' if answer.reason else ''}", fg="green")
        else:
            said = refused if answer.decided else unanswered
            self._say(said(name.lower(), answer.reason), fg="red")

    def status(self, description: Description, status: Status) -> None:
        """Print the complete status of a tool."""
        for line in status_lines(description, status):
            self._say(line, timed=False)

    def ending(self, text: str) -> None:
        """Print what happens to active lines at the end."""
        self._say(text, urgent=True)

    def help(self, text: str) -> None:
        """Print the list of commands."""
        self._say(text, timed=False)

    def error(self, error: ReportedError) -> None:
        """Print the error as a sentence."""
        self._say(error.sentence, err=True, timed=False)

    def _paced(self, allowance: Allowance, text: str, at: int, *, urgent: bool = False, **how: Any) -> None:
        """Print an event that no command caused, at a bounded rate: a flickering reading must not flood the
        terminal.
        """
        left_out = allowance.use()
        if left_out:
            self._say(
                f"{left_out} lines were left out: there were more than {PER_S:g} a second.", at, urgent=urgent
            )
        if left_out is not None:
            self._say(text, at, urgent=urgent, **how)

    def _say(
        self,
        text: str,
        at: int | None = None,
        *,
        err: bool = False,
        urgent: bool = False,
        fg: str | None = None,
        timed: bool = True,
        fields: Fields = NO_FIELDS,
    ) -> None:
        with self._clock as clock:
            if self._journal is not None:
                self._journal.send(text, fields, error=err)
                return
            stamp = f"{clock.seconds(at):9.3f} s  " if timed and self._timed else ""
            line = f"{stamp}{click.style(text, fg=fg) if self._timed and fg else text}"
            try:
                self._write(line, err=err)
            except (OSError, MemoryError):
                if urgent:
                    ignore_broken_output(self._write)(line, err=True)

    def _steps(self, result: Result) -> Iterator[str]:
        for step in result.steps:
            tried = f", attempt {step.attempts}" if step.attempts > 1 else ""
            if step.attempts:
                yield f"{display_name(step.name)} {step.seconds:.2f} s{tried}"


class JsonLines:
    """Prints one JSON object per line on stdout; ``event`` is its type, ``at_s`` its time in seconds since
    the start.
    """

    def __init__(self, begun: int | None = None, write: Callable[..., None] = click.echo) -> None:
        self._write, self._clock = write, _Clock(begun)

    def state(self, at: int, ee: str, actuators: dict[str, str]) -> None:
        """Print the states with the same labels."""
        self._print("state", at, end_effector=ee, actuators=actuators)

    def transition(self, entry: Mapping[str, Any]) -> None:
        """Print a step of the automata with its cause: an entry of `Causes`."""
        told = {name: value for name, value in entry.items() if name != "at"}
        self._print("transition", entry["at"], **told)

    def event(self, at: int, text: str, _fields: Fields = NO_FIELDS) -> None:
        """Print an event with the same words as for people."""
        self._print("log", at, text=text)

    def alarm(self, at: int, alarm: Alarm, *, over: bool) -> None:
        """Print an alarm; ``over``: whether it has ended."""
        self._print("alarm", at, **alarm.as_json() | {"over": over})

    def result(self, command: Command, result: Result) -> None:
        """Print how a command ended, with the attempts and the time of each step."""
        self._print(
            "result", None, command=command.name, succeeded=result.succeeded, outcome=result.outcome.name,
            reason=result.reason, seconds=result.seconds, steps=[asdict(step) for step in result.steps],
        )  # fmt: skip

    def answer(self, name: str, answer: Answer) -> None:
        """Print the answer as a result without steps."""
        refused = Outcome.REJECTED if answer.decided else Outcome.UNREACHABLE
        outcome = (Outcome.SUCCEEDED if answer.accepted else refused).name
        self._print(
            "result", None, command=name, succeeded=answer.accepted, outcome=outcome,
            reason=answer.reason, seconds=0.0, steps=[],
        )  # fmt: skip

    def status(self, description: Description, status: Status) -> None:
        """Print the status with the numbers of Table II and their names."""
        actuators = {
            name: {
                "state": int(state), "state_name": kind_of(actuator).states(state).label,
                "evidence": int(evidence), "evidence_name": evidence.name, "output": output,
            }
            for (name, actuator), state, evidence, output in zip(
                description.ordered, status.actuators, status.evidence, status.outputs, strict=True
            )
        }  # fmt: skip
        self._print(
            "status", status.at, state=int(status.ee), state_name=status.ee.name, command=int(status.command),
            command_name=status.command.name, tool_changer=int(status.changer),
            tool_changer_name=status.changer.name, held=status.held, part=status.part, lift_allowed=status.lift_allowed,
            arbiter_lost=status.arbiter_lost, secure=status.secure, link_up=status.link_up, reason=status.reason,
            alarms=[alarm.as_json() for alarm in status.alarms],
            actuators=actuators, steps=[asdict(step) for step in status.steps],
        )  # fmt: skip

    def ending(self, text: str) -> None:
        """Print what happens to active lines at the end."""
        self._print("ending", None, text=text)

    def help(self, text: str) -> None:
        """Print the list of commands."""
        self._print("help", None, text=text)

    def error(self, error: ReportedError) -> None:
        """Print the faults of the error in the common form."""
        self._print("error", None, faults=[fault.as_json() for fault in error.diagnostics])

    def _print(self, event: str, at: int | None, **content: Any) -> None:
        with self._clock as clock:
            ignore_broken_output(self._write)(
                json_text({"event": event, "at_s": round(clock.seconds(at), 6), **content})
            )


Voice = Words | JsonLines


def status_lines(description: Description, status: Status) -> Iterator[str]:
    """Yield the lines that show the status of a tool."""
    named = f" {status.part}" if status.part and status.command is Command.GRIP else ""
    doing = f", executing {status.command.name}{named}" if status.command != Command.NONE else ""
    lost = ", as last known" if status.arbiter_lost else ""
    unproven = status.cause is Cause.UNPROVEN_AT_START or status.ee is EndEffectorState.OFF
    held = (
        "; whether a part is held is not known" if unproven else f"; {status.part or 'a part'} is held{lost}"
    )
    held = held if status.held else ""
    lift = ", lift allowed" if status.lift_allowed else ", lift not allowed" if status.held else ""
    yield f"{description.name}: {status.ee.name}{doing}{held}{lift}"
    seconds = {step.name: step for step in status.steps}
    width = max(len(display_name(name)) for name in description.sequence)
    for (name, actuator), state, evidence in zip(
        description.for_part(status.part).ordered, status.actuators, status.evidence, strict=True
    ):
        step = seconds.get(name)
        times = (
            f"{step.seconds:.2f} s, attempt {step.attempts} of {actuator.attempts}"
            if step and step.attempts
            else ""
        )
        label = kind_of(actuator).states(state).label
        yield f"  {display_name(name):{width}}  {label:14}  {evidence.name:9}  {times}".rstrip()
    if description.tool_changer is not None:
        yield f"tool changer {status.changer.name}"
    yield f"sensors {'up' if status.link_up else 'DOWN'}"
    for alarm in status.alarms:
        yield f"{'over' if alarm.over else 'alarm'}: {alarm.text}"
    if status.reason:
        yield f"last reason: {status.reason}"


class Changes:
    """Reports each transition, each change of an actuator and each new alarm once.

    Args:
        voice: prints the reports.
        causes: the steps of the automata that led to each change, for programs that read the lines; None: they are not
            printed.
    """

    def __init__(self, description: Description, voice: Voice, causes: Causes | None = None) -> None:
        self._description, self._voice, self._causes = description, voice, causes
        self._last: tuple[str, dict[str, str]] = ("", {})
        self._alarms: tuple[Alarm, ...] = ()
        self._reported = 0, 0  # start of the program and number of its status
        self._told = threading.Condition()

    def begin(self, status: Status) -> None:
        """Start from this status: only later changes are reported."""
        self._last, self._alarms = self._labels(status), status.alarms
        self._reported = status.begun, status.count

    def status(self, status: Status) -> None:
        """Report the changes in a new status."""
        if self._causes is not None and isinstance(self._voice, JsonLines):
            for entry in self._causes.new():
                self._voice.transition(entry)
        for event in status.events:
            if line := event_line(self._description, status, event):
                self._voice.event(
                    status.at, line, event_fields(self._description.for_part(status.part), event)
                )
        now, before = self._labels(status), self._last
        self._last = now
        # in words the transition has said it already; a HAL that is lost or back has none
        said = any(event.kind is EventKind.STATE_CHANGED for event in status.events)
        if now[1] != before[1] or (now != before and (isinstance(self._voice, JsonLines) or not said)):
            self._voice.state(status.at, *now)
        for alarm, change in alarm_changes(self._alarms, status.alarms):
            if change != "ended" or not alarm.over:
                self._voice.alarm(status.at, alarm, over=change != "begun")
        self._alarms = status.alarms
        with self._told:
            self._reported = status.begun, status.count
            self._told.notify_all()

    def _labels(self, status: Status) -> tuple[str, dict[str, str]]:
        """Return the name of the end-effector's state, as in all other lines, and the label of each actuator's."""
        states = zip(self._description.ordered, status.actuators, strict=True)
        return status.ee.name, {
            name: kind_of(actuator).states(state).label for (name, actuator), state in states
        }

    def catch_up(self, status: Status) -> None:
        """Wait until a status has been reported, for a second at most, so that a result is printed after its states."""
        with self._told:
            self._told.wait_for(lambda: self._reported >= (status.begun, status.count), CAUGHT_UP_S)
