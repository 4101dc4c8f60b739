"""Whose messages count, and what becomes of the others: by rospy's connections, without a master."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rospy")

from end_effector_hal.errors import RosError
from end_effector_hal.nodes.process import BURST, PER_S, Allowance
from end_effector_hal.nodes.transport._unknown_senders import ALARM_S, UnknownSenders
from end_effector_hal.ros1.connections import KnownPublishers, nodes_of

TRUE, FORGED = "http://127.0.0.1:1/", "http://127.0.0.1:2/"


@dataclass
class Graph:
    """A topic ``/sensor_frame`` of ``/Pressure``, with connections by their address."""

    now_us: int = 1
    told: list[str] = field(default_factory=list)
    connections: list[Any] = field(default_factory=list)
    asked: int = 0
    master: bool = True

    def __post_init__(self) -> None:
        self.strangers = UnknownSenders(self.told.append, lambda: self.now_us)
        known = frozenset({"/Pressure"})
        self.publishers = KnownPublishers(
            "/sensor_frame", known, self.strangers, lambda: self.connections, self._uri_of
        )

    def _uri_of(self, name: str) -> str | None:
        self.asked += 1
        if not self.master:
            raise RosError("no master")
        return {"/Pressure": TRUE}.get(name)

    def connect(self, claimed: str, address: str) -> Any:
        """A message of a new connection."""
        header = {"callerid": claimed}
        self.connections.append(SimpleNamespace(header=header, endpoint_id=address))
        return SimpleNamespace(_connection_header=header)


def test_the_node_that_the_table_names_is_asked_for_once() -> None:
    graph = Graph()
    message = graph.connect("/Pressure", TRUE)
    assert all(graph.publishers.admit(message) for _ in range(100))
    assert (graph.asked, graph.told) == (1, [])


def test_another_name_is_dropped_counted_and_told_once() -> None:
    graph = Graph()
    message = graph.connect("/forger", FORGED)
    assert not any(graph.publishers.admit(message) for _ in range(100))
    alarm = "/sensor_frame: messages of /forger are ignored; only /Pressure may send there."
    assert graph.told == [alarm]
    assert tuple(map(str, graph.strangers.alarms())) == (alarm,)
    assert graph.strangers.counts() == {"/sensor_frame": 100}
    assert graph.asked == 0, "the master has less to do than the forger"


def test_a_claimed_name_is_found_out_by_the_address_that_the_master_knows() -> None:
    graph = Graph()
    forged, true = graph.connect("/Pressure", FORGED), graph.connect("/Pressure", TRUE)
    assert not any(graph.publishers.admit(forged) for _ in range(100))
    assert graph.publishers.admit(true)
    assert not graph.publishers.admit(forged)
    assert graph.asked == 2
    assert "another node under the name /Pressure" in graph.told[0]


def test_a_connection_that_is_not_known_to_rospy_proves_nothing() -> None:
    graph = Graph()
    message = graph.connect("/Pressure", TRUE)
    graph.connections.clear()
    assert not graph.publishers.admit(message)


def test_without_the_master_nothing_is_proven_and_it_is_asked_again() -> None:
    graph = Graph(master=False)
    message = graph.connect("/Pressure", TRUE)
    assert not graph.publishers.admit(message)
    graph.master = True
    assert graph.publishers.admit(message)


def test_ever_new_names_are_one_alarm_and_one_count() -> None:
    graph = Graph()
    for number in range(1000):
        graph.publishers.admit(graph.connect(f"/forger_{number}\n\udc80" + "x" * 10_000, FORGED))
    assert len(graph.told) == 1
    assert graph.told[0].isprintable()
    assert len(graph.told[0]) < 300
    assert graph.strangers.counts() == {"/sensor_frame": 1000}


def test_the_alarm_ends_with_what_it_is_about_and_the_count_stays() -> None:
    graph = Graph()
    message = graph.connect("/forger", FORGED)
    graph.publishers.admit(message)
    graph.now_us += round(ALARM_S * 1e6)
    assert graph.strangers.alarms()
    graph.now_us += 1
    assert graph.strangers.alarms() == ()
    assert graph.strangers.counts() == {"/sensor_frame": 1}
    graph.publishers.admit(message)
    assert len(graph.told) == 2


@pytest.mark.parametrize(
    ("place", "nodes", "known"),
    [
        ("/sensor_frame", {}, "/Pressure"),
        ("/cell/sensor_frame", {}, "/cell/Pressure"),
        ("/elsewhere/frames", {}, "/mine/Pressure"),
        ("/cell/sensor_frame", {"Pressure": "/mine/Other"}, "/mine/Other"),
    ],
    ids=["the root", "another namespace", "another name", "another node"],
)
def test_a_remap_leads_to_the_nodes_there(
    monkeypatch: pytest.MonkeyPatch, place: str, nodes: dict[str, str], known: str
) -> None:
    import rospy

    remapped = {"sensor_frame": place, **nodes}
    monkeypatch.setattr(rospy, "get_namespace", lambda: "/mine/")
    monkeypatch.setattr(rospy, "resolve_name", lambda name: remapped.get(name, f"/mine/{name}"))
    assert nodes_of("sensor_frame", ("Pressure",)) == {known}


def test_lines_have_a_bounded_rate_and_what_is_left_out_is_counted() -> None:
    now = [0.0]
    allowance = Allowance(lambda: now[0])
    assert [allowance.use() for _ in range(BURST)] == [0] * BURST
    assert [allowance.use() for _ in range(7)] == [None] * 7
    now[0] += 1 / PER_S
    assert allowance.use() == 7
    assert allowance.use() is None
    now[0] += 1e6
    assert [allowance.use() for _ in range(BURST + 1)] == [1, *[0] * (BURST - 1), None]
