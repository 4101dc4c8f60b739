"""The driver of ROS 1, with rospy and actionlib: see `wire` and `..driver`."""

from __future__ import annotations

import itertools
import threading
from contextlib import suppress
from typing import Any

import actionlib
import genpy
import rosgraph
import rospy
import rosservice
from actionlib_msgs.msg import GoalID, GoalStatus
from rosgraph_msgs.msg import Clock

from tests.acceptance.contract.drivers.wire import Json, Wire, constants, plain, ros_class

PARTS = {"goal": "Goal", "cancel": "", "status": "", "feedback": "Feedback", "result": "Result"}
OF_EVERY_NODE = ("/rosout", "/get_loggers", "/set_logger_level")
STATUSES = {value: name for name, value in constants(GoalStatus).items() if name not in ("ACTIVE", "PENDING")}


class Ros1:
    """What a check asks of ROS 1."""

    def __init__(self, wire: Wire) -> None:
        self._wire, self._numbers = wire, itertools.count(1)
        self._kept: dict[int, Any] = {}
        self._clients: dict[str, Any] = {}
        self._lock = threading.Lock()
        rospy.init_node("checks", anonymous=True, disable_signals=True)
        self._master = rosgraph.Master(rospy.get_name())

    def graph(self) -> Json:
        """Every entity but those that each node of ROS has: what it is, its type, and whose."""
        publishers, subscribers, services = self._master.getSystemState()
        types = dict(self._master.getTopicTypes())
        found: list[dict[str, Json]] = []
        actions = {
            name.removesuffix("/status") for name in types if types[name] == "actionlib_msgs/GoalStatusArray"
        }
        parts = {f"{action}/{part}": (action, part) for action in actions for part in PARTS}
        for side, entries in (("publisher", publishers), ("subscriber", subscribers)):
            for name, nodes in entries:
                if name not in parts and name not in OF_EVERY_NODE:
                    found += [
                        {"is": side, "name": name, "type": types.get(name, "?"), "node": node}
                        for node in nodes
                    ]
        found += [
            {"is": "action", "name": action, "type": self._action_type(action, types), "node": node}
            for action in actions
            for node in self._servers(action, publishers, subscribers)
        ]
        for name, nodes in services:
            if not name.endswith(OF_EVERY_NODE):
                found += [{"is": "service", "name": name, "type": "", "node": node} for node in nodes]
        return found

    def service_type(self, name: str) -> str | None:
        """The type of a service."""
        found: str | None = rosservice.get_service_type(name)
        return found

    def nodes(self) -> list[str]:
        """The full names of all nodes."""
        state = self._master.getSystemState()
        return sorted({node for entries in state for _, nodes in entries for node in nodes})

    def latched(self, topic: str, kind: str, timeout_s: float) -> bool:
        """Whether a topic is latched: its publisher says so when it is connected."""
        message = rospy.wait_for_message(topic, ros_class(kind, "msg"), timeout_s)
        return bool(message._connection_header.get("latching") == "1")

    def subscribe(self, topic: str, kind: str, latched: bool) -> int:
        """Tell every message of a topic; ``latched`` is the publisher's business in ROS 1."""
        number = next(self._numbers)

        def tell(message: Any) -> None:
            self._wire.event(number, "message", message=as_json(message))

        self._kept[number] = rospy.Subscriber(
            topic, ros_class(kind, "msg"), tell, queue_size=1000, tcp_nodelay=True
        )
        return number

    def advertise(self, topic: str, kind: str) -> int:
        """Be a publisher."""
        number = next(self._numbers)
        self._kept[number] = rospy.Publisher(topic, ros_class(kind, "msg"), queue_size=100, tcp_nodelay=True)
        return number

    def publish(self, of: int, message: dict[str, Json]) -> int:
        """Publish; how many subscribers there are."""
        publisher = self._kept[of]
        made = publisher.data_class()
        genpy.message.fill_message_args(made, [message])
        publisher.publish(made)
        return int(publisher.get_num_connections())

    def leave(self, of: int) -> None:
        """Subscribe or publish no more."""
        self._kept.pop(of).unregister()

    def call(self, service: str, kind: str, request: dict[str, Json], timeout_s: float) -> Json:
        """The response of a service."""
        rospy.wait_for_service(service, timeout_s)
        return as_json(rospy.ServiceProxy(service, ros_class(kind, "srv"))(**request))

    def constants(self, kind: str) -> dict[str, int]:
        """What a message type names."""
        return constants(ros_class(kind, "msg"))

    def send(self, action: str, kind: str, goal: dict[str, Json], timeout_s: float) -> int:
        """Send a goal, and tell its feedback and its result."""
        number, client = next(self._numbers), self._client(action, kind)
        if not client.wait_for_server(rospy.Duration(timeout_s)):
            raise TimeoutError(f"{action} is not served")
        told = threading.Lock()

        def moved(handle: Any) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE and told.acquire(blocking=False):
                result = handle.get_result()
                self._wire.event(
                    number,
                    "result",
                    status=STATUSES[handle.get_goal_status()],
                    result=None if result is None else as_json(result),
                )

        self._kept[number] = client.send_goal(
            ros_class(f"{kind}Goal", "msg")(**goal),
            moved,
            lambda _, feedback: self._wire.event(number, "feedback", message=as_json(feedback)),
        )
        return number

    def cancel(self, of: int) -> None:
        """Cancel a goal; no answer comes in ROS 1."""
        self._kept[of].cancel()

    def cancel_all(self, action: str, kind: str) -> None:
        """Cancel every goal until now: goals and cancels stand on two topics, without an order between them."""
        client = self._client(action, kind)
        client.wait_for_server(rospy.Duration(10))
        client.cancel_goals_at_and_before_time(rospy.Time.now())

    def served(self, action: str, kind: str) -> bool:
        """Whether an action has a server that is connected."""
        return bool(self._client(action, kind).wait_for_server(rospy.Duration(0, 1_000_000)))

    def parameter(self, node: str, name: str) -> Json:
        """The value of a parameter."""
        return rospy.get_param(f"{node}/{name}", None)

    def set_parameter(self, node: str, name: str, value: str) -> Json:
        """Set a parameter; whether that was taken, and why not."""
        rospy.set_param(f"{node}/{name}", value)
        return [True, ""]

    def clock(self, seconds: float) -> None:
        """Tell nodes of simulated time what time it is."""
        with self._lock:
            if "clock" not in self._clients:
                self._clients["clock"] = rospy.Publisher("/clock", Clock, queue_size=10, latch=True)
        self._clients["clock"].publish(Clock(rospy.Time.from_sec(seconds)))

    def _client(self, action: str, kind: str) -> Any:
        with self._lock:
            if action not in self._clients:
                self._clients[action] = actionlib.ActionClient(action, ros_class(f"{kind}Action", "msg"))
            return self._clients[action]

    @staticmethod
    def _servers(action: str, publishers: Any, subscribers: Any) -> set[str]:
        sides = {"goal": subscribers, "cancel": subscribers, "status": publishers}
        sides |= {"feedback": publishers, "result": publishers}
        found = [set(dict(side).get(f"{action}/{part}", ())) for part, side in sides.items()]
        return set.intersection(*found)

    @staticmethod
    def _action_type(action: str, types: dict[str, str]) -> str:
        """That of its messages, where all of them agree."""
        found = {
            types.get(f"{action}/{part}", "?").removesuffix(f"Action{suffix}")
            for part, suffix in PARTS.items()
            if suffix
        }
        others = (types.get(f"{action}/cancel"), types.get(f"{action}/status"))
        fits = others == ("actionlib_msgs/GoalID", "actionlib_msgs/GoalStatusArray")
        return found.pop() if len(found) == 1 and fits else f"? {sorted(found)} {others}"


def as_json(message: Any) -> Json:
    """A message of ROS 1; ``seq`` of a header is left out, for ROS 2 has none."""

    def fields(value: Any) -> list[str] | None:
        return (
            [name for name in value.__slots__ if name != "seq"] if isinstance(value, genpy.Message) else None
        )

    return plain(message, fields)


def main() -> None:
    wire = Wire()
    driver = Ros1(wire)
    names = [name for name in dir(driver) if not name.startswith("_")]
    with suppress(KeyboardInterrupt):
        wire.serve({name: getattr(driver, name) for name in names})
    assert GoalID  # its type is that of every cancel
    rospy.signal_shutdown("the checks are over")


if __name__ == "__main__":
    main()
