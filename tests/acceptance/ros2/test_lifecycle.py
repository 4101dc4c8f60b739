"""The managed node, by the services of ROS 2's lifecycle: what each transition does to the lines, and why one fails."""

from __future__ import annotations

import json
import os
import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.control import network_of
from end_effector_hal.description import content_hash, load, profile_path
from end_effector_hal.ros2 import PROGRAMS
from end_effector_hal.verification.proof import Proof, keep_verdict, proof_verdict, prove
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._world import World
from tests.support.patience import PATIENCE_S

from .conftest import System

CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN_INACTIVE = 1, 2, 3, 4, 6
UNCONFIGURED, INACTIVE = 1, 2
GRIP_LINES = ("SODIMM_208", "SODIMM_210", "SODIMM_212")
LINES = (*GRIP_LINES, "SODIMM_206")


class Managed(System):
    """The managed node of a tool, and its world."""

    ready_s = 2

    def start_nodes(self) -> None:
        for program in self.programs:
            # a node's own description does not count: another one was proven
            self.nodes[program] = self.start(
                program, "-p", f"ready_s:={self.ready_s}", "-r", "__node:=tool",
                "-p", "Grip:description:=/nowhere.yaml",
            )  # fmt: skip

    def join(self) -> None:
        """Become a node whose calls are answered: the first answer of a service may find no way back yet."""
        from lifecycle_msgs.srv import ChangeState

        super().join()
        self._transitions = self.node.create_client(ChangeState, "tool/change_state")
        assert self._transitions.wait_for_service(PATIENCE_S)
        self.until("an answer", lambda: self._asked(ACTIVATE, timeout_s=2.0) is not None)

    def change(self, transition: int) -> bool:
        """Ask for a transition; whether it was made."""
        made = self._asked(transition, timeout_s=PATIENCE_S)
        assert made is not None, "not answered"
        return made

    def ask(self, transition: int) -> Any:
        """Ask for a transition; the answer to come."""
        request = self._transitions.srv_type.Request()
        request.transition.id = transition
        return self._transitions.call_async(request)

    def _asked(self, transition: int, *, timeout_s: float) -> bool | None:
        future, answered = self.ask(transition), threading.Event()
        future.add_done_callback(lambda _: answered.set())
        return bool(future.result().success) if answered.wait(timeout_s) else None

    @property
    def now(self) -> int:
        """The state of the managed node."""
        from lifecycle_msgs.srv import GetState

        return int(self.call(GetState, "tool/get_state", GetState.Request()).current_state.id)

    def served(self) -> list[bool]:
        """Of each action, whether it has a server."""
        return [client.server_is_ready() for client in self._clients.values()]

    def said(self) -> str:
        return "".join(child.text() for child in self.nodes.values())

    def edges(self) -> list[tuple[str, int]]:
        """Every write to the lines so far, but those with which the line arbiter has begun."""
        records = [json.loads(line) for line in self.world.chip.read_text().splitlines() if line.strip()]
        return [(record["line"], record["level"]) for record in records if "line" in record][len(LINES) :]


@pytest.fixture(scope="module")
def proof() -> Proof:
    return prove(network_of(load(profile_path())))


@pytest.fixture
def made(tmp_path: Path) -> Iterator[Callable[[Proof], Managed]]:
    """Makes one that is unconfigured; the verdict of its tool is kept."""
    with World(load(profile_path()), "nominal", tmp_path) as world:
        systems: list[Managed] = []

        def make(proof: Proof) -> Managed:
            keep_verdict(proof_verdict(content_hash(load(world.description_path)), proof))
            system = Managed(world, tmp_path, ("lifecycle_hal",))
            system.env["XDG_STATE_HOME"] = os.environ["XDG_STATE_HOME"]
            system.start_nodes()
            system.join()
            systems.append(system)
            return system

        yield make
        for system in systems:
            system.close()


@pytest.fixture
def managed(made: Callable[[Proof], Managed], proof: Proof) -> Managed:
    return made(proof)


def test_a_grip_is_held_through_deactivation_and_adopted_by_the_next_activation(managed: Managed) -> None:
    assert managed.now == UNCONFIGURED
    assert not managed.change(ACTIVATE), "not from here"
    assert managed.change(CONFIGURE)
    managed.until("the verdict", lambda: "requirements hold" in managed.said())
    assert (managed.now, managed.edges(), managed.states) == (INACTIVE, [], [])
    assert managed.change(ACTIVATE)
    managed.connect()
    managed.do("LockToolChanger")
    managed.do("TriggerGrip")
    held = managed.edges()
    assert {line for line, level in held if level} >= set(GRIP_LINES)

    assert managed.change(DEACTIVATE)
    managed.until("OFF", lambda: managed.state.state == EndEffectorState.OFF)
    managed.until("no nodes", lambda: not set(PROGRAMS["lifecycle_hal"]) & set(managed.node.get_node_names()))
    managed.until("no servers", lambda: not any(managed.served()))
    assert managed.change(CLEANUP)
    assert managed.now == UNCONFIGURED
    assert managed.edges() == held, "what is held stays held"
    begun = len(managed.states)
    assert managed.change(CONFIGURE)
    assert managed.change(ACTIVATE)
    managed.until("adopted", lambda: any(each.held for each in managed.states[begun:]))
    managed.connect(EndEffectorState.GRIPPED)
    assert managed.edges() == held
    managed.do("Drop")
    assert {line for line, level in managed.edges()[len(held) :] if not level} >= set(GRIP_LINES)
    assert managed.change(DEACTIVATE)
    assert managed.change(SHUTDOWN_INACTIVE)
    managed.until("its end", lambda: [child.code for child in managed.nodes.values()] == [0])


def test_its_parameters_can_be_read(managed: Managed) -> None:
    from rcl_interfaces.srv import GetParameters

    request = GetParameters.Request(names=["description", "ready_s", "use_sim_time"])
    values = managed.call(GetParameters, "tool/get_parameters", request).values
    assert values[0].string_value == str(managed.world.description_path.absolute())
    assert values[1].integer_value == managed.ready_s
    assert managed.change(CONFIGURE), "it listens still"


def test_what_is_held_can_be_dropped_though_a_sensor_is_lost(managed: Managed) -> None:
    assert managed.change(CONFIGURE)
    assert managed.change(ACTIVATE)
    managed.connect()
    managed.do("LockToolChanger")
    managed.do("TriggerGrip")
    held = managed.edges()
    assert managed.change(DEACTIVATE)
    managed.until("no servers", lambda: not any(managed.served()))
    managed.world.choose("invalid:top_vacuum")
    begun = len(managed.states)
    assert managed.change(ACTIVATE)
    managed.until(
        "why",
        lambda: (
            "active because outputs are active, although the tool is not ready: its sensors do not show top_vacuum"
            in managed.said()
        ),
    )
    managed.until("adopted", lambda: any(each.held for each in managed.states[begun:]))
    assert managed.edges() == held
    managed.until("the servers", lambda: all(managed.served()))
    managed.send("Drop").result()
    assert {line for line, level in managed.edges()[len(held) :] if not level} >= set(GRIP_LINES)


def test_sigterm_while_active_ends_in_good_order_and_holds(managed: Managed) -> None:
    assert managed.change(CONFIGURE)
    assert managed.change(ACTIVATE)
    managed.connect()
    managed.do("LockToolChanger")
    managed.do("TriggerGrip")
    held = managed.edges()
    managed.kill_nodes(signal.SIGTERM)
    assert [child.code for child in managed.nodes.values()] == [0]
    assert managed.edges() == held


@pytest.mark.parametrize(
    ("requirement", "why"), [(None, "No proof is stored"), ("grip", "requirements 1 fail (grip)")]
)
def test_without_a_good_verdict_it_is_not_configured(
    managed: Managed, proof: Proof, requirement: str | None, why: str
) -> None:
    description = load(managed.world.description_path)
    findings = tuple(
        each if each.id != requirement else type(each)(each.id, each.sentence, each.query, False, 1, 0.1)
        for each in proof.findings
    )
    path = keep_verdict(proof_verdict(content_hash(description), Proof(findings, 1, 0.1)))
    if requirement is None:
        path.unlink()
    assert not managed.change(CONFIGURE)
    managed.until("the reason", lambda: why in managed.said())
    assert (managed.now, managed.states) == (UNCONFIGURED, [])


def test_a_description_that_has_changed_is_not_activated(managed: Managed) -> None:
    assert managed.change(CONFIGURE)
    path = managed.world.description_path
    text = path.read_text()
    path.write_text(text.replace("attempts: 3", "attempts: 2", 1))
    assert path.read_text() != text
    assert not managed.change(ACTIVATE)
    managed.until("the reason", lambda: "is not the one that was configured" in managed.said())
    assert managed.now == INACTIVE
    assert managed.edges() == []
    path.write_text(text)
    assert managed.change(ACTIVATE)


def test_sigterm_while_it_waits_for_its_sensors_ends_in_good_order(
    made: Callable[[Proof], Managed], proof: Proof, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Managed, "ready_s", 300)
    managed = made(proof)
    managed.world.choose("silent-after:0")
    assert managed.change(CONFIGURE)
    managed.ask(ACTIVATE)
    managed.until("its last node", lambda: "HALMain" in managed.node.get_node_names())
    managed.kill_nodes(signal.SIGTERM)
    assert [child.code for child in managed.nodes.values()] == [0]
    assert managed.edges() == []


def test_without_the_line_arbiter_it_is_not_activated(managed: Managed) -> None:
    managed.world.arbiter.end(signal_number=signal.SIGKILL)
    assert managed.change(CONFIGURE)
    assert not managed.change(ACTIVATE)
    managed.until("the reason", lambda: "not activated: " in managed.said())
    assert "line arbiter" in managed.said().partition("not activated: ")[2]
    assert (managed.now, managed.edges()) == (INACTIVE, [])


def test_without_its_sensors_it_is_not_activated(managed: Managed) -> None:
    managed.world.choose("silent-after:0")
    assert managed.change(CONFIGURE)
    assert not managed.change(ACTIVATE)
    managed.until(
        "the reason", lambda: "is not ready after 2 s: no frame comes over the sensor link" in managed.said()
    )
    assert (managed.now, managed.edges()) == (INACTIVE, [])
    managed.world.choose("nominal")
    assert managed.change(ACTIVATE)
    managed.connect()
