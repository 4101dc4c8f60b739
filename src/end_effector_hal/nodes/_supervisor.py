"""The Supervisor gives the commands of Table II, from a prompt or a script, and prints their results."""

from __future__ import annotations

import signal
import sys
import threading
import time
from contextlib import suppress
from types import FrameType

from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import ScriptCommand, read_command, read_script
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_hal.wires import PipedLines

from ._sent_goals import GoalClients
from .interface import (
    ARM_TOOL_CHANGER,
    END_EFFECTOR_STATE,
    GIVE_UP_S,
    RESET_FAULTS,
    RESUME_GRIP,
    SCRIPT,
    STOP_TOOL,
    SUPERVISOR_COMMANDS,
    Service,
)
from .transport import CommandMessage, NodeTransport, StateMessage

PROMPT = "> "
HELP = (
    "commands: lock, unlock, grip, grip <part>, drop (or release), cancel, resume, stop, arm, reset, "
    "wait <seconds>, quit"
)


class Supervisor:
    """Gives commands to HALMain."""

    def __init__(self, node: NodeTransport) -> None:
        self._node = node
        self._prompting = self._reset_failed = False
        self._piped: PipedLines | None = None
        self._publish = node.publisher(SUPERVISOR_COMMANDS)
        self._goals = GoalClients(node, self.say)
        self._adopted = threading.Event()
        node.subscribe(END_EFFECTOR_STATE, self._on_state)

    def say(self, text: str) -> None:
        """Print a line; a visible prompt is moved below it."""
        before, after = ("\r", PROMPT) if self._prompting else ("", "")
        sys.stdout.write(f"{before}{text}\n{after}")
        sys.stdout.flush()

    def run_script(self, orders: tuple[ScriptCommand, ...]) -> int:
        """Execute orders one after the other; return 1 if any did not succeed."""
        self._goals.wait_for_servers()
        if not self._adopted.wait(GIVE_UP_S):
            self.say(
                "the end-effector is still OFF: it has not adopted its lines. Is `eehal arbiter` running? "
                "`eehal doctor` says what is missing."
            )
        for order in orders:
            if self._node.ending or not self.give(order):
                break
        self._goals.wait_for_all()
        return int(self._goals.any_failed or self._reset_failed)

    def run_prompt(self) -> int:
        """Execute orders from standard input until `quit`, its end or Ctrl-C; at a terminal goals are not
        waited for.
        """
        terminal = sys.stdin.isatty()
        self._piped = None if terminal else PipedLines(sys.stdin.fileno())
        self._goals.wait_for_servers()
        self.say(HELP)
        while not self._node.ending:
            try:
                line = self._read()
                order = read_command(line) if line.strip() else None
            except EOFError:
                self.give(ScriptCommand(Command.QUIT))
                break
            except UsageError as error:
                self.say(str(error))
                continue
            if order is not None and not self.give(order, wait=not terminal):
                break
        return 0 if terminal else int(self._goals.any_failed or self._reset_failed)

    def give(self, order: ScriptCommand, *, wait: bool = True) -> bool:
        """Execute one order; return False when it was `quit`."""
        for asked, word, service in (
            (order.resume, "resume", RESUME_GRIP),
            (order.arm, "arm", ARM_TOOL_CHANGER),
            (order.stop, "stop", STOP_TOOL),
            (order.reset, "reset", RESET_FAULTS),
        ):
            if asked:
                self.say(self._call(word, service))
                return True
        if order.show or order.output or order.scenario or order.reload:
            self.say(
                "status, help, set, reload and scenario exist in `eehal run` only; use the topic EndEffectorState, the "
                "services Set…, and the standard input of the testbench."
            )
            return True
        if order.command is None:
            time.sleep(order.wait_s)
            return True
        self._publish(CommandMessage(order.command, order.command.name, order.part))
        if order.command is Command.QUIT:
            return False
        if order.command is Command.CANCEL:
            if not self._goals.cancel():
                self.say("cancel: no goal of this Supervisor is running; those of others were cancelled.")
            if wait and not order.background:
                self._goals.wait_for_all()
            return True
        goal = self._goals.send(order.command, order.part)
        if wait and not order.background:
            self._goals.wait(goal)
        else:
            with suppress(RuntimeError):  # without a thread only a HALMain that is silent is not reported
                threading.Thread(target=self._goals.wait, args=(goal,), daemon=True).start()
        return True

    def _call(self, word: str, service: Service) -> str:
        answer = self._node.call(service)
        if answer is None:
            self._reset_failed = True
            return f"{word}: UNREACHABLE. The node {service.server} cannot be reached."
        self._reset_failed = self._reset_failed or not answer.accepted
        return f"{word}: {'SUCCEEDED' if answer.accepted else 'FAILED'}. {answer.reason}"

    def _read(self) -> str:
        if self._piped is not None:
            if (line := self._piped.next()) is None:
                raise EOFError
            return line
        self._prompting = True
        try:
            return input(PROMPT)
        finally:
            self._prompting = False

    def _on_state(self, message: StateMessage) -> None:
        self._goals.seen(message.since_us)
        if message.state != EndEffectorState.OFF:
            self._adopted.set()


def run_supervisor(node: NodeTransport) -> int | None:
    """Run the script or the prompt to its end, or to the end of the node; the end-effector keeps working without it.

    Returns:
        The exit code; None: the node was ended from outside.
    """
    script = read_script(node.parameter_once(SCRIPT))
    supervisor = Supervisor(node)
    interrupt = _Interrupt(node)
    try:
        code = supervisor.run_script(script) if script else supervisor.run_prompt()
    except KeyboardInterrupt:
        supervisor.say("")
        code = 0
    finally:
        interrupt.disarm()
    return None if node.ending else code


class _Interrupt:
    """Ends a blocking read on Ctrl-C, SIGTERM and the end of the node; the signal handlers of ROS do not."""

    def __init__(self, node: NodeTransport) -> None:
        self._armed = True
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._raise)
        node.on_close(self._shut_down)

    def disarm(self) -> None:
        """Stop interrupting the main thread."""
        self._armed = False

    def _raise(self, _number: int, _frame: FrameType | None) -> None:
        if self._armed:
            self._armed = False
            raise KeyboardInterrupt

    def _shut_down(self) -> None:
        if self._armed:
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
