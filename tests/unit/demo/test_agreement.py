"""A recording that is not what happened on the wires, or whose replay differs, is found."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.description import Description
from end_effector_hal.recording import StatesLog
from end_effector_hal.wires.lines import Edge
from end_effector_lab.demo._judge import answered, on_the_wires, read_edges, replayed
from tests.support.recorded_tool import RecordedTool, recorded

LINES = {"bottom_vacuum": "SODIMM_208", "cylinder": "SODIMM_210", "top_vacuum": "SODIMM_212"}


def edges_of(log: StatesLog, offset_us: int = 7_000_000) -> list[Edge]:
    """Those that a recording tells of, on another clock."""
    found = [Edge(offset_us, line, "out", False, 1) for line in (*LINES.values(), "SODIMM_206")]
    states = dict.fromkeys(log.actuators, 0)
    for row in log.rows:
        for name, state in zip(log.actuators, row.actuators, strict=True):
            if bool(state) != bool(states[name]):
                found.append(Edge(offset_us + round(row.time_s * 1e6), LINES[name], "out", bool(state), 1))
            states[name] = state
    return found


@pytest.mark.parametrize("name", ["nominal", "fails-once", "never-confirms", "unlock-lock"])
def test_the_same_on_another_clock(verdin: Description, recordings: dict[str, StatesLog], name: str) -> None:
    log = recordings[name]
    assert on_the_wires(verdin, log, edges_of(log)).ok


def later(edges: list[Edge], at: int, us: int) -> list[Edge]:
    return [edge._replace(at=edge.at + us) if i == at else edge for i, edge in enumerate(edges)]


@pytest.mark.parametrize(
    ("us", "ok"), [(249_000, True), (251_000, False), (-249_000, True), (-251_000, False)]
)
def test_an_edge_away_from_its_row(
    verdin: Description, recordings: dict[str, StatesLog], us: int, ok: bool
) -> None:
    log = recordings["fails-once"]
    finding = on_the_wires(verdin, log, later(edges_of(log), 6, us))
    assert finding.ok is ok
    assert ok or finding.found == "one 251.0 ms off"


WRONG: list[Callable[[list[Edge]], list[Edge]]] = [
    lambda edges: edges[:-1],
    lambda edges: [],
    lambda edges: [*edges, edges[-1]._replace(level=True)],
    lambda edges: [*edges[:4], edges[5], edges[4], *edges[6:]],
    lambda edges: [edge._replace(direction="in") for edge in edges],
]


@pytest.mark.parametrize("edit", WRONG)
def test_other_edges(
    verdin: Description, recordings: dict[str, StatesLog], edit: Callable[[list[Edge]], list[Edge]]
) -> None:
    log = recordings["nominal"]
    assert not on_the_wires(verdin, log, edit(edges_of(log))).ok


def test_the_file_of_a_chip_is_read(tmp_path: Path) -> None:
    entries = [
        {"chip": "virtual", "version": 1, "t": 5, "lines": {"SODIMM_208": "down"}},
        {"t": 9, "line": "SODIMM_208", "direction": "out", "level": 1, "pid": 3},
    ]
    path = tmp_path / "lines.log"
    path.write_text("".join(json.dumps(entry) + "\n" for entry in entries) + '{"t": 10, "li')
    assert read_edges(path)[-1] == Edge(9, "SODIMM_208", "out", True, 3)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return recorded(tmp_path, "nominal", 1.0, "grip", 2.0)


def test_a_run_that_decides_the_same_is_ok(folder: Path) -> None:
    assert replayed(folder).ok


def test_another_decision_is_a_fault_with_its_time(folder: Path) -> None:
    path = folder / "hal.mcap"
    data = path.read_bytes()
    changed = data.replace(b'"name":"grip"', b'"name":"drop"', 1)
    assert changed != data
    path.write_bytes(changed)
    finding = replayed(folder)
    assert not finding.ok
    assert finding.found.startswith("hal.mcap at 1.000 s: ")


@pytest.mark.parametrize("codec", ["ees1-ascii", "legacy-nibble"])
def test_a_command_that_was_refused_is_told_with_its_reason(
    verdin: Description, tmp_path: Path, codec: str
) -> None:
    link = verdin.link.model_copy(update={"codec": codec})
    tool = RecordedTool(tmp_path, description=verdin.model_copy(update={"link": link}))
    tool.run(8.0)
    tool.command("unlock")
    tool.close()
    refused = (
        "unlock was refused: IL-02: no sensor shows where the tool is: arm first, then unlock within 10 s."
    )
    assert answered(tmp_path).found == ("every command taken" if codec == "ees1-ascii" else refused)
    assert answered(tmp_path).ok is (codec == "ees1-ascii")


def test_no_trace_is_a_fault(tmp_path: Path) -> None:
    finding = replayed(tmp_path)
    assert not finding.ok
    assert "no trace here" in finding.found
