"""The automata of the shipped tool, drawn from their file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.description import load, profile_path
from end_effector_hal.verification.lemmas import BUS_FILE, COILS_FILE, DEATHS_FILE
from end_effector_lab.figures import draw_template
from timed_automata import load_document

from ._markdown import ROOT

DRAWN = ROOT / "docs" / "images" / "automata"


def automata() -> str:
    """Each template, in the order of its file, and what executes it."""
    tool = load(profile_path())
    executed = dict.fromkeys(tool.automata.executed, "Executed by the HAL.")
    tools = _templates(tool.automata_path, executed, "Part of the environment, which the proof needs.")
    coils = _templates(COILS_FILE, {}, "Of `two_coils.xml`, which proves outputs with two coils.")
    bus = _templates(BUS_FILE, {}, "Of `bus_output.xml`, which proves outputs on a bus.")
    deaths = _templates(
        DEATHS_FILE, {}, "Of `deaths.xml`, in which program and line arbiter die at any instant."
    )
    return "\n\n".join((*tools, *coils, *bus, *deaths))


def _templates(file: Path, executed: dict[str, str], others: str) -> Iterator[str]:
    DRAWN.mkdir(parents=True, exist_ok=True)
    for template in load_document(file).templates:
        name = template.name.content.strip()
        picture = f"{file.stem}-{name}.svg"
        draw_template(template, "").savefig(DRAWN / picture, metadata={"Date": None})
        yield f"## {name}"
        yield executed.get(name, others)
        yield f"[![The automaton {name}](../images/automata/{picture})](../images/automata/{picture})"
