"""Small models, written as in UPPAAL's older text format and turned into its XML."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.sax.saxutils import escape, unescape

import pytest

from end_effector_hal.errors import ReportedError
from timed_automata import Network, State, load_network
from timed_automata.network import Transition

_LABELS = {"select": "select", "guard": "guard", "sync": "synchronisation", "assign": "assignment"}


def _body(text: str, start: int) -> int:
    depth = 1
    while depth:
        depth += {"{": 1, "}": -1}.get(text[start], 0)
        start += 1
    return start


def _clause(body: str, word: str) -> str:
    found = re.search(rf"\b{word}\b(.*?);\s*(?=commit|urgent|init|trans|$)", body, re.DOTALL)
    return found[1].strip() if found else ""


def _template(name: str, parameters: str, body: str) -> str:
    declarations, _, rest = body.partition("state ")
    rest = "state " + rest
    committed, urgent = (re.findall(r"\w+", _clause(rest, word)) for word in ("commit", "urgent"))
    lines = [f"<name>{name}</name>"]
    lines += [f"<parameter>{escape(parameters)}</parameter>"] if parameters.strip() else []
    lines.append(f"<declaration>{escape(declarations)}</declaration>")
    for state, invariant in re.findall(r"(\w+)\s*(?:\{([^}]*)\})?", _clause(rest, "state")):
        label = f'<label kind="invariant">{escape(invariant.strip())}</label>' if invariant.strip() else ""
        kind = "<committed/>" if state in committed else "<urgent/>" if state in urgent else ""
        lines.append(f'<location id="{name}.{state}"><name>{state}</name>{label}{kind}</location>')
    lines.append(f'<init ref="{name}.{_clause(rest, "init")}"/>')
    for source, target, labels in re.findall(r"(\w+)\s*->\s*(\w+)\s*\{([^}]*)\}", _clause(rest, "trans")):
        lines.append(f'<transition><source ref="{name}.{source}"/><target ref="{name}.{target}"/>')
        for label in filter(str.strip, labels.split(";")):
            word, _, content = label.strip().partition(" ")
            lines.append(f'<label kind="{_LABELS[word]}">{escape(content.strip())}</label>')
        lines.append("</transition>")
    return "<template>" + "\n".join(lines) + "</template>"


def to_xml(text: str) -> str:
    """``declarations process P(parameters) { declarations state …; init …; trans …; } … system …;`` as XML."""
    header = re.compile(r"process\s+(\w+)\s*\((.*?)\)\s*\{", re.DOTALL)
    position, declarations, templates = 0, None, []
    while found := header.search(text, position):
        declarations = text[position : found.start()] if declarations is None else declarations
        end = _body(text, found.end())
        templates.append(_template(found[1], found[2], text[found.end() : end - 1]))
        position = end
    parts = [f"<declaration>{escape(declarations or '')}</declaration>", *templates]
    return f"<nta>{''.join(parts)}<system>{escape(text[position:])}</system></nta>"


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    """Write a model in the text format to a UPPAAL file."""

    def write(text: str) -> Path:
        path = tmp_path / "model.xml"
        path.write_text(to_xml(text), encoding="utf-8")
        return path

    return write


@pytest.fixture
def load(write: Callable[[str], Path]) -> Callable[..., Network]:
    """Load a model in the text format, with constants by keyword."""
    return lambda text, **constants: load_network(write(text), constants)


@pytest.fixture
def names() -> Callable[[Network, Iterator[Transition]], list[str]]:
    """Transitions as ``P.A>B + Q.C>D``."""

    def names(network: Network, transitions: Iterator[Transition]) -> list[str]:
        told = []
        for transition in transitions:
            parts = []
            for edge in transition.edges:
                process = network.processes[edge.process]
                source, target = process.locations[edge.source].name, process.locations[edge.target].name
                parts.append(f"{process.name}.{source}>{target}")
            told.append(" + ".join(parts))
        return told

    return names


@pytest.fixture
def value() -> Callable[[Network, State, str], int]:
    """The value of a variable in a state."""
    return lambda network, state, name: state.values[network.offset(name)]


@pytest.fixture
def pointed() -> Callable[[ReportedError], str]:
    """What stands in the file at the place that an error names, to the end of the line, without escapes."""

    def pointed(error: ReportedError) -> str:
        file, line, column = error.where.rsplit(":", 2)
        return unescape(Path(file).read_text(encoding="utf-8").split("\n")[int(line) - 1][int(column) - 1 :])

    return pointed
