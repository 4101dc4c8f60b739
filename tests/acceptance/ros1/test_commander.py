"""What was given up is not executed: also when its answer is lost, and the node is reached once more."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

pytestmark = pytest.mark.ros


class Proxy:
    """A service; ``answers`` of all of them are given in order: an exception is raised."""

    answers: list[Any]
    calls: list[tuple[int, int]]
    transport = SimpleNamespace(header={"callerid": "/Grip"})

    def __init__(self, *_: Any, **__: Any) -> None:
        pass

    def __call__(self, command: int, until_us: int) -> Any:
        self.calls.append((command, until_us))
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def close(self) -> None:
        pass


@pytest.fixture
def commander(monkeypatch: pytest.MonkeyPatch) -> Any:
    import rospy

    from end_effector_hal.nodes.interface import GRIP_COMMAND
    from end_effector_hal.nodes.transport import Commander
    from end_effector_hal.ros1.connections import CommandService

    Proxy.answers, Proxy.calls = [], []
    monkeypatch.setattr(rospy, "ServiceProxy", Proxy)
    return Commander(GRIP_COMMAND.server, lambda: CommandService(GRIP_COMMAND))


def yes() -> Any:
    from end_effector_msgs.srv import HalCommandResponse

    return HalCommandResponse(accepted=True, count=3, decided=True)


def broken() -> Exception:
    import rospy

    return rospy.ServiceException("transport error completing service call")


def test_a_node_that_was_started_again_is_asked_again_within_the_same_time(commander: Any) -> None:
    Proxy.answers = [yes(), broken(), yes()]
    assert commander.ask(2).accepted
    assert commander.ask(3).accepted
    assert [command for command, _ in Proxy.calls] == [2, 3, 3]
    assert Proxy.calls[1] == Proxy.calls[2], "the time does not begin anew"


def test_what_was_given_up_is_not_asked_again(commander: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    Proxy.answers = [yes(), broken(), yes()]
    assert commander.ask(2).accepted
    monkeypatch.setattr("end_effector_hal.nodes.transport._commander.VALID_S", 0.0)
    reply = commander.ask(3)
    assert (reply.accepted, reply.decided) == (False, False)
    assert [command for command, _ in Proxy.calls] == [2, 3]


def test_an_answer_that_the_program_did_not_give_in_time_is_none(commander: Any) -> None:
    from end_effector_msgs.srv import HalCommandResponse

    assert not HalCommandResponse().decided
    Proxy.answers = [HalCommandResponse(reason="The HAL does not answer.")]
    reply = commander.ask(2)
    assert (reply.accepted, reply.decided) == (False, False)
    assert reply.reason == "The HAL does not answer."
    assert len(Proxy.calls) == 1


def test_a_connection_that_breaks_within_a_call_is_an_answer(commander: Any) -> None:
    import rospy

    Proxy.answers = [rospy.exceptions.TransportTerminated("unable to receive data")]
    reply = commander.ask(2)
    assert (reply.decided, reply.reason) == (False, "The node Grip cannot be reached.")
