"""``eehal run``: one tool in this terminal, without ROS."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.errors import EndEffectorError, UsageError

if TYPE_CHECKING:
    from end_effector_hal.control import Answer, Status
    from end_effector_hal.tool import EndEffector, Order, Recording

READY_S = 10.0


@click.command("run")
@click.argument("description", type=click.Path(path_type=Path))
@click.option("--script", help="Commands instead of the prompt, such as 'lock; grip; wait 2; drop'.")
@click.option("--record", type=click.Path(path_type=Path), help="Folder for the recording of the run.")
def command(description: Path, script: str | None, record: Path | None) -> None:
    """Give commands to one tool: lock, unlock, grip, drop, cancel, arm, reset, wait SECONDS, quit.

    The line owner of the tool (`eehal owner DESCRIPTION`) must run. A command followed by `&` goes on in the
    background, so that it can be cancelled. Quitting releases nothing that is held.
    """
    from end_effector_hal.description import load
    from end_effector_hal.tool import EndEffector, Recording, read_script

    orders = read_script(script) if script is not None else None
    tool = EndEffector(load(description), traces=record)
    with ExitStack() as stack:
        if record is not None:
            _record(tool, stack.enter_context(Recording(record, tool.description)))
        _Told(tool)
        stack.enter_context(tool)
        tool.start()
        if not tool.wait_ready(READY_S):
            raise EndEffectorError(
                f"The tool did not adopt its lines within {READY_S:g} s: {'; '.join(tool.status.alarms)}"
            )
        succeeded = _Session(tool).play(iter(orders) if orders is not None else _prompt())
    sys.exit(0 if succeeded else 1)


def _record(tool: EndEffector, recording: Recording) -> None:
    def state(status: Status) -> None:
        recording.state(status.at, status.ee, status.command, status.actuators)
        recording.alarms(status.at, status.alarms)

    tool.subscribe(state)
    tool.subscribe_frames(lambda frame: recording.values(frame.at, frame.values))


class _Told:
    """Prints each change of state and each new alarm once."""

    def __init__(self, tool: EndEffector) -> None:
        self._tool = tool
        self._last = ""
        self._alarms: tuple[str, ...] = ()
        tool.subscribe(self._status)

    def _status(self, status: Status) -> None:
        from end_effector_hal.trace import EndEffectorState, actuator_states, display_name

        kinds = {name: part.kind for name, part in self._tool.description.ordered}
        states = zip(self._tool.description.sequence, status.actuators, strict=True)
        words = [
            f"{display_name(name)} {actuator_states(name, kinds)(state).label}" for name, state in states
        ]
        text = f"{EndEffectorState(status.ee).label}: {', '.join(words)}"
        if text != self._last:
            self._last = text
            click.echo(text)
        for alarm in status.alarms:
            if alarm not in self._alarms:
                click.echo(f"alarm: {alarm}", err=True)
        for alarm in self._alarms:
            if alarm not in status.alarms:
                click.echo(f"no longer: {alarm}", err=True)
        self._alarms = status.alarms


class _Session:
    """Gives orders to a tool and says how they ended."""

    def __init__(self, tool: EndEffector) -> None:
        self._tool = tool
        self._running: list[threading.Thread] = []
        self._succeeded = True

    def play(self, orders: Iterator[Order]) -> bool:
        """Whether every command succeeded."""
        from end_effector_hal.trace import Command

        for order in orders:
            if order.command is Command.QUIT:
                break
            if order.arm:
                self._tell("ARM", self._tool.arm())
                continue
            if order.reset:
                self._tell("RESET", self._tool.reset())
                continue
            if order.command is None:
                time.sleep(order.wait_s)
                continue
            thread = threading.Thread(target=self._run, args=(order.command,), daemon=True)
            thread.start()
            self._running.append(thread)
            if not order.background:
                thread.join()
        for thread in self._running:
            thread.join()
        return self._succeeded

    def _tell(self, name: str, answer: Answer) -> None:
        self._succeeded = self._succeeded and answer.accepted
        said = f". {answer.reason}" if answer.reason else ""
        click.echo(f"{name}: {'succeeded' if answer.accepted else 'failed'}{said}")

    def _run(self, given: int) -> None:
        from end_effector_hal.trace import Command

        tool, order = self._tool, Command(given)
        if order is Command.CANCEL:
            answer = tool.cancel()
            succeeded, reason = answer.accepted, answer.reason
        else:
            outcome = {
                Command.LOCK: tool.lock,
                Command.UNLOCK: tool.unlock,
                Command.GRIP: tool.grip,
                Command.RELEASE: tool.drop,
            }[order]()
            succeeded, reason = outcome.succeeded, outcome.reason
        self._succeeded = self._succeeded and succeeded
        click.echo(f"{order.name}: {'succeeded' if succeeded else 'failed'}{f'. {reason}' if reason else ''}")


def _prompt() -> Iterator[Order]:
    from end_effector_hal.tool import read_order

    while True:
        try:
            text = input("> " if sys.stdin.isatty() else "").strip()
        except EOFError:
            return
        if not text:
            continue
        try:
            yield read_order(text)
        except UsageError as error:
            click.echo(str(error), err=True)
