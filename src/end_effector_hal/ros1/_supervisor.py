"""Supervisor: gives the commands of Table II, from a prompt or a script, and says what became of them."""

from __future__ import annotations

import signal
import sys
import threading
from types import FrameType
from typing import Any

import rospy
from end_effector_msgs.msg import SupervisorCommand

from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import Order, read_order, read_script
from end_effector_hal.vocabulary import Command, EndEffectorState

from ._goals import GIVE_UP_S, PATIENCE_S, ActionClients
from ._node import Node, service_class, stamp
from ._table import (
    ARM_TOOL_CHANGER,
    END_EFFECTOR_STATE,
    PATIENCE,
    RESET_FAULTS,
    SCRIPT,
    SUPERVISOR,
    SUPERVISOR_COMMANDS,
    Parameter,
    Service,
)

LEAST_PATIENCE_S, MOST_PATIENCE_S = 3.0, 3600.0
PROMPT = "> "
HELP = "commands: lock, unlock, grip, drop (or release), cancel, arm, reset, wait <seconds>, quit"


class Supervisor:
    """Gives orders to HALMain.

    Args:
        node: it speaks through this.
    """

    def __init__(self, node: Node) -> None:
        self._prompting = self._reset_failed = False
        self._tell = node.publisher(SUPERVISOR_COMMANDS)
        self._goals = ActionClients(self.say, _patience_s(node))
        self._adopted = threading.Event()
        node.subscribe(END_EFFECTOR_STATE, self._state_came)

    def say(self, text: str) -> None:
        """Print a line, before a prompt that stands there."""
        before, after = ("\r", PROMPT) if self._prompting else ("", "")
        sys.stdout.write(f"{before}{text}\n{after}")
        sys.stdout.flush()

    def run_script(self, orders: tuple[Order, ...]) -> int:
        """Give orders one after the other; 1 when any did not succeed."""
        self._goals.wait_for_servers()
        if not self._adopted.wait(GIVE_UP_S):
            self.say("the end-effector is OFF still: it has not adopted its lines.")
        for order in orders:
            if rospy.is_shutdown() or not self.give(order):
                break
        self._goals.wait_for_all()
        return int(self._goals.any_failed or self._reset_failed)

    def run_prompt(self) -> int:
        """Obey standard input until `quit`, its end or Ctrl-C; at a terminal goals run in the background."""
        terminal = sys.stdin.isatty()
        self._goals.wait_for_servers()
        self.say(HELP)
        while not rospy.is_shutdown():
            try:
                line = self._read(terminal)
                order = read_order(line) if line.strip() else None
            except EOFError:
                self.give(Order(Command.QUIT))
                break
            except UsageError as error:
                self.say(str(error))
                continue
            if order is not None and not self.give(order, wait=not terminal):
                break
        return 0 if terminal else int(self._goals.any_failed or self._reset_failed)

    def give(self, order: Order, *, wait: bool = True) -> bool:
        """Give one order; False when it was `quit`."""
        if order.arm or order.reset:
            self.say(self._call("arm", ARM_TOOL_CHANGER) if order.arm else self._call("reset", RESET_FAULTS))
            return True
        if order.command is None:
            rospy.rostime.wallsleep(order.wait_s)
            return True
        message = SupervisorCommand(command=int(order.command))
        message.header.stamp = stamp()
        self._tell(message)
        if order.command is Command.QUIT:
            return False
        if order.command is Command.CANCEL:
            if not self._goals.cancel():
                self.say("cancel: no goal of this Supervisor is running; those of others were cancelled.")
            if wait and not order.background:
                self._goals.wait_for_all()
            return True
        goal = self._goals.send(order.command)
        if wait and not order.background:
            self._goals.wait(goal)
        else:
            threading.Thread(target=self._goals.wait, args=(goal,), daemon=True).start()
        return True

    def _call(self, word: str, service: Service) -> str:
        try:
            answer = rospy.ServiceProxy(service.name, service_class(service.type))()
        except rospy.ServiceException:
            self._reset_failed = True
            return f"{word}: UNREACHABLE. The node {service.server} cannot be reached."
        self._reset_failed = self._reset_failed or not answer.success
        return f"{word}: {'SUCCEEDED' if answer.success else 'FAILED'}. {answer.message}"

    def _read(self, terminal: bool) -> str:
        if not terminal:
            line = sys.stdin.readline()
            if not line:
                raise EOFError
            return line
        self._prompting = True
        try:
            return input(PROMPT)
        finally:
            self._prompting = False

    def _state_came(self, message: Any) -> None:
        if message.state != EndEffectorState.OFF:
            self._adopted.set()


def main(argv: list[str]) -> int:
    """Run the node; ends by itself after its script, or at `quit`: the end-effector goes on without it."""
    node = Node(SUPERVISOR, argv)
    script = read_script(_once(node, SCRIPT))
    supervisor = Supervisor(node)
    interrupt = _Interrupt()
    try:
        code = supervisor.run_script(script) if script else supervisor.run_prompt()
    except KeyboardInterrupt:
        supervisor.say("")
        code = 0
    finally:
        interrupt.disarm()
    if rospy.is_shutdown():
        return node.spin()
    rospy.signal_shutdown("quit")
    return code


def _once(node: Node, parameter: Parameter) -> str:
    """A parameter; it does not stay on the parameter server, or the next Supervisor would have it as well."""
    text = node.parameter(parameter)
    if text:
        rospy.delete_param(f"~{parameter.name}")
    return text


def _patience_s(node: Node) -> float:
    text = _once(node, PATIENCE) or str(PATIENCE_S)
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not LEAST_PATIENCE_S <= seconds <= MOST_PATIENCE_S:
        bounds = f"{LEAST_PATIENCE_S:g} to {MOST_PATIENCE_S:g} s"
        raise UsageError(f"~{PATIENCE.name} is {text!r}.", todo=f"It is a number of seconds, {bounds}.")
    return seconds


class _Interrupt:
    """Ctrl-C, SIGTERM and rospy's shutdown end a blocking read; by rospy's own handlers they do not."""

    def __init__(self) -> None:
        self._armed = True
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._raise)
        rospy.on_shutdown(self._shut_down)

    def disarm(self) -> None:
        """The main thread is not to be interrupted any more."""
        self._armed = False

    def _raise(self, _number: int, _frame: FrameType | None) -> None:
        if self._armed:
            self._armed = False
            raise KeyboardInterrupt

    def _shut_down(self) -> None:
        if self._armed:
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
