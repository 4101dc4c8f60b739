"""Each class of fault with its exact sentence and place: the cases stand in ``faults/*.txt``.

A case changes lines of SMALL (``9|new text``, several times for several lines, ``9|`` takes the line out) and
lists the faults that it then has (``> line:column: message [code]``); none: it is valid.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.description import CODES

FOLDER = Path(__file__).parent / "faults"


def cases() -> list[object]:
    found = []
    for path in sorted(FOLDER.glob("*.txt")):
        for block in path.read_text(encoding="utf-8").split("== ")[1:]:
            title, *lines = block.splitlines()
            expected = [f"tool.yaml:{line[2:]}" for line in lines if line.startswith("> ")]
            edits: dict[str, list[str]] = {}
            for line in lines:
                number, bar, text = line.partition("|")
                if bar and number.strip().isdigit():
                    edits.setdefault(f"L{number.strip()}", []).append(text)
            changes = {key: "\n".join(texts) for key, texts in edits.items()}
            found.append(pytest.param(changes, expected, id=f"{path.stem}: {title}"))
    return found


@pytest.mark.parametrize(("changes", "expected"), cases())
def test_the_faults_of_a_change_are_exactly_these(
    faults: Callable[..., list[str]], changes: dict[str, str], expected: list[str]
) -> None:
    assert faults(**changes) == expected


def test_every_code_of_a_fault_within_a_file_has_a_case() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in FOLDER.glob("*.txt"))
    elsewhere = {"EE-201", "EE-202", "EE-203", "EE-224", "EE-225", "EE-226"}
    assert {code for code in CODES if f"[{code}]" in text} == set(CODES) - elsewhere


def test_ten_different_faults_in_one_file_are_all_reported_in_the_order_of_the_file(
    faults: Callable[..., list[str]],
) -> None:
    text = """\
name: My Tool
link:
  prt: /dev/ttyS0
  baudrate: fast
sequence: [cup, rot, cup]
actuators:
  cup:
    kind: vacuumm
    line: A
    line: B
    channel: bottom
    timeout_ms: 5000
    reset_s: 1000
  rod:
    kind: cylinder
    line: A
    channel: cylinder
endings:
  held: {sigterm: release}
automata: {file: gone.xml}
"""
    found = faults(text)
    assert [line.split(": ", 1)[0] + " " + line[-7:-1] for line in found] == [
        "tool.yaml:1:7 EE-211", "tool.yaml:3:3 EE-205", "tool.yaml:4:13 EE-207", "tool.yaml:5:17 EE-220",
        "tool.yaml:5:22 EE-220", "tool.yaml:8:11 EE-209", "tool.yaml:10:5 EE-204", "tool.yaml:12:5 EE-210",
        "tool.yaml:13:14 EE-208", "tool.yaml:16:11 EE-221", "tool.yaml:19:19 EE-223",
        "tool.yaml:20:18 EE-224",
    ]  # fmt: skip


def test_an_automata_file_that_is_named_must_be_there(
    faults: Callable[..., list[str]], tmp_path: Path
) -> None:
    named = "name: tool\nautomata: {file: own.xml}"
    assert faults(L1=named) == [
        "tool.yaml:2:18: there is no such file (own.xml), "
        f"expected a UPPAAL file, relative to {tmp_path} [EE-224]"
    ]
    (tmp_path / "own.xml").touch()
    assert faults(L1=named) == []
    (tmp_path / "own.xml").unlink()
    (tmp_path / "own.xml").mkdir()
    assert len(faults(L1=named)) == 1
