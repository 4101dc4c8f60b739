"""UPPAAL files in a few lines of text."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from xml.sax.saxutils import escape, unescape

from timed_automata import Network, make_network, read_document
from timed_automata.errors import ReportedError
from timed_automata.network import Edge, Transition

_loaded = ""
"""The source that was loaded last."""


def _made(source: str, constants: Mapping[str, object] | None = None) -> Network:
    global _loaded
    _loaded = source
    return make_network(read_document(source.encode(), "model.xml"), constants)  # type: ignore[arg-type]


_KINDS = {"guard": "guard", "sync": "synchronisation", "do": "assignment", "select": "select"}
_WORDS = ("own", "urgent", "committed", "initial", "locations")


def _xml(text: str) -> tuple[str, str]:
    """The name of a template, and its element."""
    head, _, body = text.partition(":")
    name, _, parameters = head.partition("(")
    edges, invariants, words = [], {}, dict.fromkeys(_WORDS, "")
    for part in filter(None, map(str.strip, re.split(r"\n| \| ", body))):
        word, _, rest = part.partition(":")
        if "->" in word:
            edges.append(part)
        else:
            (words if word in words else invariants)[word] = rest.strip()
    ends = [end.strip() for edge in edges for end in edge.split(";")[0].split("->")]
    first = words["initial"] or (ends or words["locations"].split())[0]
    xml = [f"<template><name>{name}</name>"]
    xml += [f"<parameter>{escape(parameters[:-1])}</parameter>"] * bool(parameters)
    xml.append(f"<declaration>{escape(words['own'])}</declaration>")
    for place in dict.fromkeys([first, *words["locations"].split(), *ends]):
        invariant = (
            f'<label kind="invariant">{escape(invariants[place])}</label>' if place in invariants else ""
        )
        mark = next((f"<{kind}/>" for kind in ("committed", "urgent") if place in words[kind].split()), "")
        xml.append(f'<location id="{name}.{place}"><name>{place}</name>{invariant}{mark}</location>')
    xml.append(f'<init ref="{name}.{first}"/>')
    for edge in edges:
        (source, target), labels = edge.split(";")[0].split("->"), edge.split(";")[1:]
        xml.append(
            f'<transition><source ref="{name}.{source.strip()}"/><target ref="{name}.{target.strip()}"/>'
        )
        for kind, _, value in (label.partition(":") for label in labels):
            xml.append(f'<label kind="{_KINDS[kind.strip()]}">{escape(value.strip())}</label>')
        xml.append("</transition>")
    return name, "".join([*xml, "</template>"])


def document(
    declarations: str, *templates: str, system: str = "", queries: Sequence[tuple[str, str]] = ()
) -> bytes:
    """A file; ``queries`` with their comments.

    A template is ``Name(parameters): part | part``, or has each part in a line of its own: an edge ``a -> b; guard: …;
    sync: …; do: …; select: …``, an invariant ``a: x <= 2``, ``own: declarations``, or ``urgent: a b``, ``committed:``,
    ``initial:`` (else that of the first edge) and ``locations:``, which fixes their order.
    """
    names, bodies = zip(*map(_xml, templates), strict=True)
    asked = "".join(
        f"<query><formula>{escape(formula)}</formula><comment>{escape(comment)}</comment></query>"
        for formula, comment in queries
    )
    declared = f"<declaration>{escape(declarations)}</declaration>"
    system = f"<system>{escape(system or 'system ' + ', '.join(names) + ';')}</system>"
    return f"<nta>{declared}{''.join(bodies)}{system}<queries>{asked}</queries></nta>".encode()


def network(
    declarations: str, *templates: str, system: str = "", queries: Sequence[tuple[str, str]] = ()
) -> Network:
    """The network of such a file."""
    return _made(document(declarations, *templates, system=system, queries=queries).decode())


# In UPPAAL's older text format

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


def load(text: str, **constants: object) -> Network:
    """A model in the text format, with constants by keyword."""
    return _made(to_xml(text), constants)


def pointed(error: ReportedError) -> str:
    """What stands at the place that an error names in the model loaded last, to the end of the line."""
    _, line, column = error.where.rsplit(":", 2)
    return unescape(_loaded.split("\n")[int(line) - 1][int(column) - 1 :])


def names(network: Network, transitions: Iterable[Transition]) -> list[str]:
    """Transitions as ``P.A>B + Q.C>D``."""

    def part(edge: Edge) -> str:
        process = network.processes[edge.process]
        return f"{process.name}.{process.locations[edge.source].name}>{process.locations[edge.target].name}"

    return [" + ".join(map(part, transition.edges)) for transition in transitions]
