"""The pages of docs/reference say what happens: the refusals in timed_automata.md, the commands in model.md."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from xml.sax.saxutils import escape

import pytest
from click.testing import CliRunner

from end_effector_hal.cli.model._model import command
from end_effector_hal.errors import ModelError
from tests.support.nightly import first_of
from tests.support.places import DOCS
from timed_automata import read_document
from timed_automata.check import find_faults

LIBRARY = (DOCS / "reference/timed_automata.md").read_text(encoding="utf-8")
PAGE = (DOCS / "reference/model.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| ([^|]+) \| (\w+) \| `(.+?)` \| (.+) \|$", LIBRARY, re.MULTILINE)
COMMANDS = re.findall(r"^\$ eehal model (.*)$", PAGE, re.MULTILINE)

TOOLS = Path("examples/tools").absolute()

LONG = ("show my_tool.yaml --registers", " -o drawings")
"""The commands that take longest, in this order."""


def _length(line: str) -> int:
    return max(number * (words in line) for number, words in enumerate(LONG, 1))


MODEL = """<nta><declaration>clock x, y; int a; broadcast chan c; urgent chan u;
{declaration}</declaration><template><name>P</name>{template}
<location id="A"><name>A</name><label kind="invariant">{invariant}</label>{location}</location><init ref="A"/>
<transition><source ref="A"/><target ref="A"/><label kind="guard">{guard}</label>
<label kind="synchronisation">{synchronisation}</label><label kind="assignment">{update}</label>{edge}</transition>
</template><system>{system}</system>{element}
<queries><query><formula>{query}</formula><comment/></query></queries></nta>"""
TEXTS = ("declaration", "invariant", "guard", "synchronisation", "update", "system", "query")
ELEMENTS = ("template", "location", "edge", "element")


def faults(where: str, written: str) -> list[ModelError]:
    parts = dict.fromkeys((*TEXTS, *ELEMENTS), "") | {"system": "system P;"}
    if where in ("receiver", "urgent"):
        parts |= {"guard": written, "synchronisation": "c?" if where == "receiver" else "u!"}
    else:
        assert where in parts
        parts[where] = written
    text = MODEL.format(**{key: escape(value) if key in TEXTS else value for key, value in parts.items()})
    try:
        return find_faults(read_document(text.encode(), "m.xml"))
    except ModelError as error:
        return [error]


def test_the_pages_have_their_rows_and_commands() -> None:
    assert (len(ROWS), len(COMMANDS)) == (20, 9)
    assert faults("guard", "x > 3") == []


@pytest.mark.parametrize(("construct", "where", "written", "remedy"), ROWS, ids=[row[0] for row in ROWS])
def test_a_refusal_names_what_to_do_as_documented(
    construct: str, where: str, written: str, remedy: str
) -> None:
    (fault,) = faults(where, written)
    assert re.fullmatch(r"m\.xml:\d+:\d+: .*", str(fault))
    assert str(fault).endswith(f": outside of the supported subset. {remedy}")


@pytest.mark.parametrize("line", first_of(sorted(COMMANDS, key=_length), len(COMMANDS) - 4, 3))
def test_a_command_works_as_documented(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tool = "gripper_2f85" if "--registers" in line else "bistable_and_magnet"
    Path("my_tool.yaml").write_bytes((TOOLS / tool / "end_effector.yaml").read_bytes())
    result = CliRunner().invoke(command, shlex.split(line, comments=True), catch_exceptions=False)
    assert result.exit_code == 0, result.output
