"""Everything that is wrong, in one run, with its line and a mark: the cases stand in ``faults/*.txt``.

A case changes lines of SMALL (``9|new text``, several times for several lines; ``9|`` takes the line out); what follows
is what `eehal check` prints. ``EEHAL_UPDATE=1 pytest`` of this file writes what it prints now: read the difference.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli import _check

TABLE = Path(__file__).parent / "faults" / "one_pass.txt"
UPDATE = bool(os.environ.get("EEHAL_UPDATE"))
SMALL = """\
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
""".splitlines()


def cases() -> list[tuple[str, dict[int, list[str]], str]]:
    found = []
    for block in TABLE.read_text(encoding="utf-8").split("== ")[1:]:
        title, _, rest = block.partition("\n")
        changes: dict[int, list[str]] = {}
        lines = rest.splitlines(keepends=True)
        while lines and (number := lines[0].partition("|")[0]).isdigit():
            changes.setdefault(int(number), []).append(lines.pop(0).partition("|")[2].rstrip("\n"))
        found.append((title, changes, "".join(lines).rstrip("\n")))
    return found


def told(changes: dict[int, list[str]], folder: Path) -> str:
    lines = [changes.get(number, [text]) for number, text in enumerate(SMALL, start=1)]
    text = "\n".join(line for each in lines for line in each if line) + "\n"
    (folder / "tool.yaml").write_bytes(text.encode().replace(b"\\t", b"\t"))
    result = CliRunner().invoke(_check.command, ["tool.yaml"], catch_exceptions=False)
    assert result.exit_code == (2 if result.stderr else 0)
    return result.stderr.rstrip("\n")


@pytest.mark.parametrize(
    ("title", "changes", "expected"), [pytest.param(*each, id=each[0]) for each in cases()]
)
def test_all_of_it_is_told_at_once(
    title: str,
    changes: dict[int, list[str]],
    expected: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert told(changes, tmp_path) == expected


@pytest.mark.skipif(not UPDATE, reason="writes the table")
def test_write_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = []
    for title, changes, _ in cases():
        edits = "".join(f"{number}|{text}\n" for number, texts in changes.items() for text in texts)
        blocks.append(f"== {title}\n{edits}{told(changes, tmp_path)}\n")
    TABLE.write_text("\n".join(blocks), encoding="utf-8")


def test_the_table_has_25_cases() -> None:
    assert len(cases()) >= 25
