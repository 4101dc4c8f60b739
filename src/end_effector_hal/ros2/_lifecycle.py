"""A managed node of ROS 2's lifecycle: the nodes of a tool work in its process while it is active."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from end_effector_hal.description import Description, content_hash, tool_path
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.nodes.interface import (
    DESCRIPTION,
    MANAGER,
    PARAMETERS,
    PROFILE,
    PROVE,
    READY_S,
    load_for_nodes,
)
from end_effector_hal.nodes.launching import require_proof, what_is_missing
from end_effector_hal.nodes.process import node_log
from end_effector_hal.nodes.start import start_node
from end_effector_hal.runtime import Tool
from end_effector_hal.wires import now_us

from ._process import NodeGroup, Process
from ._ros_node import HOW, RclpyNode, declared, writer_of

_OWN_NAME = re.compile(r"__(node|name):=")
_LOOK_S = 0.05


class ToolLifecycle(LifecycleNode):  # type: ignore[misc]  # rclpy has no types
    """Configure loads the tool and checks its proof; activate starts its nodes and waits for the sensors.

    Deactivate ends the nodes as SIGTERM does: the lines get the state that `endings: sigterm` defines; by default held
    parts stay held. Cleanup changes no line. A transition that fails logs the reason.

    Args:
        process: the process that it runs in.
        names: the nodes of the interface table that work while it is active.
        argv: arguments of the program.
    """

    def __init__(self, process: Process, names: Sequence[str], argv: Sequence[str]) -> None:
        try:
            super().__init__(MANAGER, context=process.context)
        except Exception as error:  # noqa: BLE001 rclpy has a class for each part of it
            raise UsageError(f"The node {MANAGER} cannot be made: {error}") from None
        self._process, self._names = process, names
        self._arguments = _without_own_name(argv)
        self._log, self._log_handler = node_log(MANAGER, writer_of(self))
        self._given = {each.name: declared(self, each) for each in PARAMETERS if MANAGER in each.nodes}
        self._hash = ""
        self._group: NodeGroup | None = None
        self._starting = threading.RLock()
        """Held while nodes start, so that a signal during the start ends all of them, not only those that exist
        already.
        """
        self._guard_transitions()
        self._own = NodeGroup(process, (MANAGER,))
        self._own.add(self, MANAGER)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the description, and check its proof."""
        return self._tried("configured", self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start the nodes, adopt the lines, and wait for the sensors."""
        return self._tried("activated", self._activate)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the nodes; by default held parts stay held."""
        self._end_group()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the description."""
        self._hash = ""
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the nodes and the process, from any state; its launcher restarts it."""
        self._end_group()
        self._process.end()
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close everything after an exception in a transition, and return to unconfigured."""
        self._end_group()
        return TransitionCallbackReturn.SUCCESS

    def close(self) -> None:
        """End the node and its group at the end of the process, in any state."""
        self._own.close()
        self._end_group()
        self._log_handler.end()

    def _guard_transitions(self) -> None:
        """Refuse transitions that are not possible now; in rclpy they raise, which would end the executor."""
        service = next(each for each in self.services if each.srv_name.endswith("/change_state"))
        change = service.callback

        def guarded(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except Exception:  # noqa: BLE001 RCLError, which rclpy does not export
                wanted = request.transition.label or request.transition.id
                self._log.warning("refused: transition %s is not possible in this state", wanted)
                response.success = False
                return response

        service.callback = guarded

    def _configure(self) -> None:
        description = self._load()
        verdict = require_proof(description, prove_now=self._given[PROVE.name].lower() == "true")
        self._hash = verdict.hash
        self._log.info("%s: %s", description.name, verdict)

    def _activate(self) -> None:
        ready_s = _seconds(self._given[READY_S.name])
        description = self._load()
        if content_hash(description) != self._hash:
            raise UsageError(
                "The description is not the one that was configured.",
                where=str(description.source),
                todo="Clean up and configure again.",
            )
        try:
            group, tool = self._start_group(description)
            self._wait_until_ready(group, tool, ready_s)
        except BaseException:
            self._end_group()
            raise

    def _start_group(self, description: Description) -> tuple[NodeGroup, Tool]:
        with self._starting:
            if self._process.ending:
                raise UsageError(f"{description.name} was ended before its nodes began.")
            self._group = group = NodeGroup(
                self._process, self._names, self._arguments, self._given, description
            )
            nodes = [RclpyNode(name, group) for name in self._names]
            for name, node in zip(self._names, nodes, strict=True):
                start_node(name, node)
            group.start()
        return group, nodes[0].tool()

    def _wait_until_ready(self, group: NodeGroup, tool: Tool, ready_s: float) -> None:
        description, until = tool.description, now_us() + round(ready_s * 1e6)
        while (why := what_is_missing(description, tool.status)) and now_us() < until and not group.ending:
            time.sleep(_LOOK_S)
        if group.ending:
            raise UsageError(f"{description.name} was ended while it waited for its sensors.")
        if why and any(tool.status.outputs):
            # nodes that ended would leave nobody to drop what is held
            self._log.warning(
                "active because outputs are active, although the tool is not ready: %s", "; ".join(why)
            )
        elif why:
            raise UsageError(
                f"{description.name} is not ready after {ready_s:g} s: {'; '.join(why)}.",
                todo="`eehal doctor` prints what is missing.",
            )

    def _end_group(self) -> None:
        with self._starting:
            group, self._group = self._group, None
        if group is not None:
            group.close()

    def _load(self) -> Description:
        given = [self._given[each.name] for each in (DESCRIPTION, PROFILE)]
        return load_for_nodes(tool_path(*given, how=HOW))

    def _tried(self, what: str, work: Callable[[], None]) -> TransitionCallbackReturn:
        try:
            work()
        except ReportedError as error:
            self._log.error("not %s: %s", what, error)
            return TransitionCallbackReturn.FAILURE
        except Exception:  # noqa: BLE001 rclpy would not say which
            self._log.exception("not %s because of an error in the program", what)
            return TransitionCallbackReturn.ERROR
        self._log.info("%s", what)
        return TransitionCallbackReturn.SUCCESS


def _seconds(text: str) -> float:
    try:
        seconds = float(text or 10)
    except ValueError:
        seconds = -1.0
    if not 0 < seconds <= 600:
        raise UsageError(f"The parameter {READY_S.name} is {text[:40]!r}, expected are seconds, at most 600.")
    return seconds


def _without_own_name(argv: Sequence[str]) -> list[str]:
    """Return the arguments without the rule that names the managed node, because it would rename all nodes."""
    arguments: list[str] = []
    words = iter(argv[1:])
    for word in words:
        if word in ("-r", "--remap"):
            rule = next(words, "")
            if _OWN_NAME.match(rule):
                continue
            arguments += [word, rule]
        else:
            arguments.append(word)
    return arguments
