"""How a node starts, talks and ends; the only module that knows how rospy does that."""

from __future__ import annotations

import importlib
import os
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import rospy

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, RosError, UsageError
from end_effector_hal.wires import be_steady, now_us

from ._at_once import send_at_once
from ._encodable import encodable
from ._logging import node_logger
from ._master import MasterWatch
from ._name_faults import load_for_nodes
from ._name_taken import node_name, refuse_taken_name
from ._peers import Publishers, caller_of, nodes_of
from ._strangers import Strangers
from ._table import DESCRIPTION, Parameter, Service, Topic
from ._ticker import Ticker
from ._tool_named import private_parameter, tool_named

LAST_WORDS_S = 0.05
"""For the last messages to leave the queues."""
LONGEST_END_S = 5.0


class Node:
    """One ROS node. Callbacks of topics and services come in rospy's threads, one thread per connection.

    Raises:
        RosError: there is no master, or a node of this name runs already.
        UsageError: no tool is named, where the node needs one; or an argument is none of a node.
    """

    def __init__(self, name: str, argv: Sequence[str]) -> None:
        self._failed: ReportedError | None = None
        self._watch = MasterWatch(lambda why: self.fail(RosError(why)))
        full = node_name(name)
        needs_tool = name in DESCRIPTION.nodes
        self._tool = tool_named(argv, private_parameter(full)) if needs_tool else None
        refuse_taken_name(full, str(self._tool or ""))
        send_at_once()
        try:
            rospy.init_node(name, argv=list(argv))
        except rospy.ROSInitException as error:
            raise UsageError(f"{error}.", todo="Private parameters are given as _name:=value.") from None
        self.name = rospy.get_name().lstrip("/")
        self.log = node_logger(name)
        self.strangers = Strangers(lambda alarm: self.log.warning("%s", alarm), now_us)
        self._ended = threading.Event()
        self._closing = False
        self._closers: list[Callable[[], None]] = []
        self._tickers: list[Ticker] = []
        rospy.on_shutdown(self._close)
        rospy.core.add_shutdown_hook(lambda reason: self._ended.set())

    def description(self) -> Description:
        """The tool that ``~description`` or ``~profile`` names; raises DescriptionError."""
        assert self._tool is not None, "the table says which nodes have a description"
        return load_for_nodes(self._tool)

    def parameter(self, parameter: Parameter, default: str = "") -> str:
        """A private parameter."""
        return str(rospy.get_param("~" + parameter.name, default))

    def publisher(self, topic: Topic) -> Callable[[Any], None]:
        """What publishes a message on a topic."""
        publisher = rospy.Publisher(
            topic.name,
            message_class(topic.type),
            tcp_nodelay=True,
            latch=topic.latched,
            queue_size=topic.queue,
        )

        def publish(message: Any) -> None:
            try:
                publisher.publish(message)
            except UnicodeEncodeError:  # a text from outside, such as a third party's codec
                publish(encodable(message))
            except rospy.ROSException:
                if not self._closing:
                    raise

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        """Have every message of a topic that comes from a node that the table names; others are dropped and told."""
        kind, options = message_class(topic.type), {"queue_size": topic.queue, "tcp_nodelay": True}
        if topic.public:
            rospy.Subscriber(topic.name, kind, callback, **options)
            return

        def admitted(message: Any) -> None:
            if publishers.admit(message):
                callback(message)

        # the callback only once it is known whose messages count
        subscriber = rospy.Subscriber(topic.name, kind, **options)
        publishers = Publishers(
            subscriber.resolved_name,
            nodes_of(topic.name, topic.publishers),
            self.strangers,
            lambda: subscriber.impl.connections,
        )
        subscriber.impl.add_callback(admitted, None)

    def refuse_stranger(self, service: Service, request: Any) -> str:
        """Why a call of an internal service is refused; empty: it comes from a node that the table names."""
        caller, known = caller_of(request), nodes_of(service.name, service.callers)
        if caller in known:
            return ""
        return self.strangers.drop(str(rospy.resolve_name(service.name)), caller, " and ".join(sorted(known)))

    def serve(self, service: Service, answer: Callable[[Any], Any]) -> None:
        """Answer the calls of a service."""
        rospy.Service(service.name, service_class(service.type), answer)

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        """Have a callback called at a rate, in a thread of its own."""
        self._tickers.append(Ticker(1 / rate_hz, callback, self.log))

    def on_close(self, callback: Callable[[], None]) -> None:
        """Have a callback called at the end, while the node can still publish; the last added comes first."""
        self._closers.insert(0, callback)

    def spin(self) -> int:
        """Wait for the end; the exit code. Raises what :meth:`fail` was given."""
        be_steady()
        self._ended.wait()
        if self._failed is not None:
            raise self._failed
        return 0

    def fail(self, error: ReportedError) -> None:
        """End the node with an error, so that roslaunch starts it again; may be called in any thread."""
        if self._failed is None:
            self._failed = error
            # without its master, or with a thread that hangs, rospy may not come to its end
            threading.Thread(target=_leave_by_force, args=(error,), daemon=True).start()
            rospy.signal_shutdown(str(error))

    def _close(self) -> None:
        self._closing = True
        self._watch.close()
        for ticker in self._tickers:
            ticker.close()
        for callback in self._closers:
            callback()
        time.sleep(LAST_WORDS_S)


def message_class(name: str) -> Any:
    """The class of a message type such as ``std_msgs/Header``; raises RosError when it is not built."""
    return _class(name, "msg")


def service_class(name: str) -> Any:
    """The class of a service type; raises RosError when it is not built."""
    return _class(name, "srv")


def constant_name(message: Any, value: int) -> str:
    """What a message with one enumeration calls a value."""
    constants = vars(type(message)).items()
    return next((name for name, each in constants if name.isupper() and each == value), str(value))


def stamp(at_us: int | None = None) -> Any:
    """ROS time of a moment on the monotonic clock (µs), default: now."""
    before, now, after = time.monotonic_ns(), rospy.Time.now(), time.monotonic_ns()
    if at_us is None or not rospy.rostime.is_wallclock():
        return now
    past = (before + after) // 2 - 1000 * at_us
    return now - rospy.Duration(0, max(past, 0))


def _class(name: str, kind: str) -> Any:
    package, _, plain = name.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), plain)
    except (ImportError, AttributeError):
        raise RosError(
            f"The ROS type {name} is not there.", todo="Run ros/build.sh, then . build/catkin/devel/setup.sh"
        ) from None


def _leave_by_force(error: ReportedError) -> None:
    time.sleep(LONGEST_END_S)
    os._exit(error.exit_code)
