"""How ``eehal run`` tells what happens: in words for people, as JSON lines for programs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Protocol

import click

if TYPE_CHECKING:
    from end_effector_hal.control import Status, StepReport
    from end_effector_hal.description import Description
    from end_effector_hal.errors import ReportedError


class Voice(Protocol):
    """What can be told."""

    def state(self, ee: str, actuators: dict[str, str]) -> None:
        """A change of state."""

    def alarm(self, text: str, *, over: bool) -> None:
        """An alarm that came or went."""

    def result(self, name: str, succeeded: bool, reason: str, steps: Sequence[StepReport] = ()) -> None:
        """How a command ended."""

    def error(self, error: ReportedError) -> None:
        """Something that does not end the run."""


class Words:
    """States and results on stdout, the rest on stderr."""

    def state(self, ee: str, actuators: dict[str, str]) -> None:
        """The labels of the figures."""
        from end_effector_hal.vocabulary import display_name

        click.echo(f"{ee}: {', '.join(f'{display_name(name)} {each}' for name, each in actuators.items())}")

    def alarm(self, text: str, *, over: bool) -> None:
        """One line each."""
        click.echo(f"{'no longer' if over else 'alarm'}: {text}", err=True)

    def result(self, name: str, succeeded: bool, reason: str, steps: Sequence[StepReport] = ()) -> None:
        """With the reason in words."""
        click.echo(f"{name}: {'succeeded' if succeeded else 'failed'}{f'. {reason}' if reason else ''}")

    def error(self, error: ReportedError) -> None:
        """The sentence."""
        click.echo(str(error), err=True)


class JsonLines:
    """An object a line on stdout; ``event`` says what it is."""

    def state(self, ee: str, actuators: dict[str, str]) -> None:
        """The same labels."""
        self._tell(event="state", end_effector=ee, actuators=actuators)

    def alarm(self, text: str, *, over: bool) -> None:
        """``over``: it is gone."""
        self._tell(event="alarm", text=text, over=over)

    def result(self, name: str, succeeded: bool, reason: str, steps: Sequence[StepReport] = ()) -> None:
        """With the attempts and the time of each step."""
        told = [asdict(step) for step in steps]
        self._tell(event="result", command=name, succeeded=succeeded, reason=reason, steps=told)

    def error(self, error: ReportedError) -> None:
        """Its faults as everywhere."""
        self._tell(event="error", faults=[fault.as_json() for fault in error.diagnostics])

    def _tell(self, **content: object) -> None:
        click.echo(json.dumps(content, ensure_ascii=False))


class Changes:
    """Tells each change of state and each new alarm once."""

    def __init__(self, description: Description, voice: Voice) -> None:
        self._description, self._voice = description, voice
        self._last: tuple[str, dict[str, str]] | None = None
        self._alarms: tuple[str, ...] = ()

    def status(self, status: Status) -> None:
        """One more."""
        from end_effector_hal.kinds import kind_of
        from end_effector_hal.vocabulary import EndEffectorState

        states = zip(self._description.ordered, status.actuators, strict=True)
        actuators = {name: kind_of(part).states(state).label for (name, part), state in states}
        if (now := (EndEffectorState(status.ee).label, actuators)) != self._last:
            self._last = now
            self._voice.state(*now)
        for alarm in status.alarms:
            if alarm not in self._alarms:
                self._voice.alarm(alarm, over=False)
        for alarm in self._alarms:
            if alarm not in status.alarms:
                self._voice.alarm(alarm, over=True)
        self._alarms = status.alarms
