"""The driver of ROS 2, with rclpy: see `wire` and `..driver`."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.action import ActionClient
from rclpy.action.graph import get_action_server_names_and_types_by_node
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock

from tests.acceptance.contract.drivers.wire import Json, Wire, constants, fill, plain, ros_class

PATIENCE_S = 60.0
OF_EVERY_NODE = ("/rosout", "/parameter_events", "/clock")
SERVICES_OF_EVERY_NODE = (
    "/describe_parameters", "/get_parameter_types", "/get_parameters", "/list_parameters", "/set_parameters",
    "/set_parameters_atomically", "/get_type_description",
)  # fmt: skip
STATUSES = {
    value: name.removeprefix("STATUS_")
    for name, value in (*constants(type(GoalStatus)).items(), *constants(GoalStatus).items())
    if name.startswith("STATUS_")
}


class Ros2:
    """What a check asks of ROS 2."""

    def __init__(self, wire: Wire) -> None:
        self._wire, self._numbers = wire, itertools.count(1)
        self._kept: dict[int, tuple[Any, Callable[[Any], Any]]] = {}
        self._goals: dict[int, Any] = {}
        self._clients: dict[str, Any] = {}
        self._services: dict[str, Any] = {}
        self._lock = threading.Lock()
        rclpy.init()
        self._node = Node("checks")
        self._group = ReentrantCallbackGroup()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._executor.spin, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self._thread.join(5.0)
        self._node.destroy_node()
        rclpy.try_shutdown()

    def graph(self) -> Json:
        """Every entity but those that each node of ROS has: what it is, its type, and whose."""
        return self._in_executor(self._look)

    def service_type(self, name: str) -> str | None:
        """The type of a service."""
        types = dict(self._node.get_service_names_and_types()).get(name, [])
        return without_folder(types[0]) if len(types) == 1 else None

    def nodes(self) -> list[str]:
        """The full names of all nodes."""
        names = self._node.get_node_names_and_namespaces()
        return sorted(f"{space.rstrip('/')}/{name}" for name, space in names)

    def latched(self, topic: str, kind: str, timeout_s: float) -> bool:
        """Whether all publishers of a topic offer their last message to those who come late."""
        infos = self._node.get_publishers_info_by_topic(topic)
        assert infos, f"nobody publishes {topic}"
        assert {info.qos_profile.reliability.name for info in infos} == {"RELIABLE"}, topic
        (durability,) = {info.qos_profile.durability for info in infos}
        return bool(durability is DurabilityPolicy.TRANSIENT_LOCAL)

    def subscribe(self, topic: str, kind: str, latched: bool) -> int:
        """Tell every message of a topic; where it is ``latched`` the last one before, too."""
        number = next(self._numbers)

        def tell(message: Any) -> None:
            self._wire.event(number, "message", message=as_json(message))

        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        quality = QoSProfile(depth=1000, durability=durability)

        def subscribe() -> Any:
            return self._node.create_subscription(ros_class(kind, "msg"), topic, tell, quality)

        self._kept[number] = self._in_executor(subscribe), self._node.destroy_subscription
        return number

    def advertise(self, topic: str, kind: str) -> int:
        """Be a publisher."""
        number = next(self._numbers)
        made = self._in_executor(lambda: self._node.create_publisher(ros_class(kind, "msg"), topic, 100))
        self._kept[number] = made, self._node.destroy_publisher
        return number

    def publish(self, of: int, message: dict[str, Json]) -> int:
        """Publish; how many subscribers there are."""
        publisher, _ = self._kept[of]
        publisher.publish(made_of(publisher.msg_type, message))
        return int(publisher.get_subscription_count())

    def leave(self, of: int) -> None:
        """Subscribe or publish no more."""
        entity, destroy = self._kept.pop(of)
        self._in_executor(lambda: destroy(entity))

    def call(self, service: str, kind: str, request: dict[str, Json], timeout_s: float) -> Json:
        """The response of a service."""
        return as_json(self._call(service, ros_class(kind, "srv"), request, timeout_s))

    def constants(self, kind: str) -> dict[str, int]:
        """What a message type names."""
        found = ros_class(kind, "msg")
        return constants(type(found)) | constants(found)

    def send(self, action: str, kind: str, goal: dict[str, Json], timeout_s: float) -> int:
        """Send a goal, and tell its feedback and its result."""
        number, client = next(self._numbers), self._client(action, kind)
        if not client.wait_for_server(timeout_s):
            raise TimeoutError(f"{action} is not served")
        made = made_of(client._action_type.Goal, goal)

        def over(future: Any) -> None:
            response = future.result()
            status, result = STATUSES[response.status], as_json(response.result)
            self._wire.event(number, "result", status=status, result=result)

        def feedback(message: Any) -> None:
            self._wire.event(number, "feedback", message=as_json(message.feedback))

        # in the executor's thread: rclpy drops an answer that comes before it has noted the question
        answered = self._in_executor(lambda: client.send_goal_async(made, feedback))
        handle = waited(answered, PATIENCE_S)
        if not handle.accepted:
            self._wire.event(number, "result", status="REJECTED WITHOUT WORDS", result=None)
            return number
        self._goals[number] = handle
        self._in_executor(handle.get_result_async).add_done_callback(over)
        return number

    def cancel(self, of: int) -> bool:
        """Cancel a goal; whether that was taken."""
        answered = self._in_executor(self._goals[of].cancel_goal_async)
        return bool(waited(answered, PATIENCE_S).goals_canceling)

    def cancel_all(self, action: str, kind: str) -> None:
        """Cancel every goal of an action."""
        self._call(f"{action}/_action/cancel_goal", CancelGoal, {}, PATIENCE_S)

    def served(self, action: str, kind: str) -> bool:
        """Whether an action has a server."""
        return bool(self._client(action, kind).server_is_ready())

    def parameter(self, node: str, name: str) -> Json:
        """The value of a parameter."""
        answer = self._call(f"{node}/get_parameters", GetParameters, {"names": [name]}, PATIENCE_S)
        return parameter_value_to_python(answer.values[0]) if answer.values else None

    def set_parameter(self, node: str, name: str, value: str) -> Json:
        """Set a parameter; whether that was taken, and why not."""
        client = self._service(f"{node}/set_parameters", SetParameters)
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        result = waited(self._in_executor(lambda: client.call_async(request)), PATIENCE_S).results[0]
        return [bool(result.successful), result.reason]

    def clock(self, seconds: float) -> None:
        """Tell nodes of simulated time what time it is."""
        with self._lock:
            if "clock" not in self._clients:
                quality = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
                self._clients["clock"] = self._in_executor(
                    lambda: self._node.create_publisher(Clock, "/clock", quality)
                )
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(seconds), int(seconds % 1 * 1e9)
        self._clients["clock"].publish(message)

    def _look(self) -> Json:
        node, found = self._node, list[dict[str, Json]]()
        names = node.get_node_names_and_namespaces()
        questions = {
            "publisher": node.get_publisher_names_and_types_by_node,
            "subscriber": node.get_subscriber_names_and_types_by_node,
            "service": node.get_service_names_and_types_by_node,
        }

        def ask(kind: str, question: Callable[..., Any], name: str, space: str) -> None:
            full = f"{space.rstrip('/')}/{name}"
            for entity, types in question(name, space):
                its_own = (f"{full}{each}" for each in SERVICES_OF_EVERY_NODE)
                if "/_action/" in entity or entity in OF_EVERY_NODE or entity in its_own:
                    continue
                found.extend(
                    {"is": kind, "name": entity, "type": without_folder(each), "node": full} for each in types
                )

        for name, space in names:
            try:
                for kind, question in questions.items():
                    ask(kind, question, name, space)
                ask("action", lambda *own: get_action_server_names_and_types_by_node(node, *own), name, space)
            except Exception as error:
                if "NodeNameNonExistent" not in type(error).__name__:
                    raise
        return found

    def _client(self, action: str, kind: str) -> Any:
        with self._lock:
            if action not in self._clients:
                made = ros_class(kind, "action")
                self._clients[action] = self._in_executor(lambda: ActionClient(self._node, made, action))
            return self._clients[action]

    def _service(self, name: str, kind: Any) -> Any:
        with self._lock:
            if name not in self._services:
                self._services[name] = self._in_executor(
                    lambda: self._node.create_client(kind, name, callback_group=self._group)
                )
        if not self._services[name].wait_for_service(PATIENCE_S):
            raise TimeoutError(f"{name} is not served")
        return self._services[name]

    def _call(self, name: str, kind: Any, request: dict[str, Json], timeout_s: float) -> Any:
        client, made = self._service(name, kind), made_of(kind.Request, request)
        return waited(self._in_executor(lambda: client.call_async(made)), timeout_s)

    def _in_executor(self, job: Callable[[], Any]) -> Any:
        return waited(self._executor.create_task(job), PATIENCE_S)


def waited(future: Any, timeout_s: float) -> Any:
    """The result of a future of rclpy."""
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    if not done.wait(timeout_s):
        raise TimeoutError(f"no answer within {timeout_s:g} s")
    return future.result()


def without_folder(kind: str) -> str:
    """``package/Name`` of ``package/msg/Name``."""
    package, _, name = kind.split("/")
    return f"{package}/{name}"


def made_of(kind: Any, values: dict[str, Json]) -> Any:
    """A message with fields from JSON."""
    types = kind.get_fields_and_field_types()

    def make(message: Any, name: str, value: Json) -> Any:
        return made_of(type(getattr(message, name)), value) if "/" in types[name] else value

    return fill(kind(), values, make)


def as_json(message: Any) -> Json:
    """A message of ROS 2."""

    def fields(value: Any) -> Sequence[str] | None:
        return (
            list(value.get_fields_and_field_types()) if hasattr(value, "get_fields_and_field_types") else None
        )

    return plain(message, fields)


def main() -> None:
    wire = Wire()
    driver = Ros2(wire)
    names = [name for name in dir(driver) if not name.startswith("_") and name != "close"]
    try:
        wire.serve({name: getattr(driver, name) for name in names})
    finally:
        driver.close()


if __name__ == "__main__":
    main()
