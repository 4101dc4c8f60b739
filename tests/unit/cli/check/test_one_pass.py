"""Everything that is wrong, in one run, with its line and a mark: the cases stand in ``faults/*.txt``.

A case changes lines of the description of its table (``9|new text``, several times for several lines; ``9|`` takes
the line out); what follows is what `eehal check` prints. ``EEHAL_UPDATE=1 pytest`` of this file writes what it prints
now: read the difference.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli import _check

FOLDER = Path(__file__).parent / "faults"
UPDATE = bool(os.environ.get("EEHAL_UPDATE"))
ONE_PASS = """\
name: tool
link: {port: /dev/ttyS0, codec: ees1-ascii}
sequence: [cup, rod]
actuators:
  cup:
    kind: vacuum
    line: A
    channel: bottom
  rod:
    kind: cylinder
    line: B
    channel: cylinder
tool_changer: {line: C}
supply: {channel: supply}
"""
DEVICES = """\
schema: 2
name: tool
inputs: {period_ms: 10}
channels:
  open: {digital: {line: IN1, bias: pull_up, debounce_ms: 2}, invert: true}
  closed: {digital: {line: IN2}}
  part: {digital: {line: IN3}}
  cup: {analog: {device: ads1015, channel: voltage0}, unit: kPa, scale: 0.025, offset: -112.5}
  shut: {digital: {line: IN4}}
  apart: {digital: {line: IN5}}
sequence: [jaw, magnet, cup]
actuators:
  jaw: {kind: gripper, line: A, opposite: {line: B}, open_bit: open, closed_bit: closed}
  magnet: {kind: magnet, line: C, opposite: {line: D, pulse_s: 0.2}, part_bit: part}
  cup: {kind: vacuum, line: E, channel: cup, blow_off: {line: F}}
tool_changer: {line: G, opposite: {line: H}, locked_bit: shut, unlocked_bit: apart, stand_bit: none, present_bit: none}
supply: {channel: none}
"""
BUS = """\
schema: 2
name: tool
link: {port: /dev/ttyUSB0, frame: {modbus: {}}}
channels:
  cup: {modbus: {unit: 9, address: 2002}, unit: kPa}
  told: {modbus: {unit: 9, address: 2001}}
  open: {digital: {line: C}}
  shut: {digital: {line: D}}
sequence: [cup, jaw]
actuators:
  cup: {kind: vacuum, line: A, channel: cup}
  jaw:
    kind: gripper
    modbus: {unit: 9, address: 1000, command_on: [1], command_off: [0], verify: told}
    evidence: {confirmed: {on: shut}, gone: {on: open}}
supply: {channel: none}
"""
TABLES = {"one_pass": ONE_PASS, "devices": DEVICES, "bus": BUS}


Changes = dict[int, list[str]]


def cases(table: str) -> list[tuple[str, Changes, str]]:
    found = []
    for block in (FOLDER / f"{table}.txt").read_text(encoding="utf-8").split("== ")[1:]:
        title, _, rest = block.partition("\n")
        changes: Changes = {}
        lines = rest.splitlines(keepends=True)
        while lines and (number := lines[0].partition("|")[0]).isdigit():
            changes.setdefault(int(number), []).append(lines.pop(0).partition("|")[2].rstrip("\n"))
        found.append((title, changes, "".join(lines).rstrip("\n")))
    return found


def told(table: str, changes: Changes, folder: Path) -> str:
    lines = [changes.get(number, [old]) for number, old in enumerate(TABLES[table].splitlines(), start=1)]
    text = "\n".join(line for each in lines for line in each if line) + "\n"
    (folder / "tool.yaml").write_bytes(text.encode().replace(b"\\t", b"\t"))
    result = CliRunner().invoke(_check.command, ["tool.yaml"], catch_exceptions=False)
    assert result.exit_code == (2 if result.stderr else 0)
    return result.stderr.rstrip("\n")


@pytest.mark.parametrize(
    ("table", "title", "changes", "expected"),
    [pytest.param(table, *each, id=f"{table}: {each[0]}") for table in TABLES for each in cases(table)],
)
def test_all_of_it_is_told_at_once(
    table: str, title: str, changes: Changes, expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert told(table, changes, tmp_path) == expected


@pytest.mark.parametrize("table", TABLES)
def test_what_they_change_is_right(table: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert told(table, {}, tmp_path) == ""


@pytest.mark.skipif(not UPDATE, reason="writes the tables")
@pytest.mark.parametrize("table", TABLES)
def test_write_the_table(table: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = []
    for title, changes, _ in cases(table):
        edits = "".join(f"{number}|{text}\n" for number, texts in changes.items() for text in texts)
        blocks.append(f"== {title}\n{edits}{told(table, changes, tmp_path)}\n")
    (FOLDER / f"{table}.txt").write_text("\n".join(blocks), encoding="utf-8")


@pytest.mark.parametrize(("table", "least"), [("one_pass", 25), ("devices", 60), ("bus", 10)])
def test_the_tables_have_cases_for_each_key(table: str, least: int) -> None:
    assert len(cases(table)) >= least
