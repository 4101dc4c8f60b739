"""UPPAAL files in a few lines of Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from xml.sax.saxutils import escape

from timed_automata import Network, make_network, read_document


@dataclass
class Template:
    name: str
    edges: list[str]  # "source -> target; guard: …; sync: …; do: …; select: …"
    parameters: str = ""
    declarations: str = ""
    invariants: dict[str, str] = field(default_factory=dict)
    urgent: str = ""
    committed: str = ""
    initial: str = ""
    locations: str = ""  # fixes their order; those of the edges are added

    def xml(self) -> str:
        ends = [edge.split(";")[0].split("->") for edge in self.edges]
        first = self.initial or (ends[0][0].strip() if ends else self.locations.split()[0])
        ends_of_edges = (name.strip() for end in ends for name in end)
        names = list(dict.fromkeys([first, *self.locations.split(), *ends_of_edges]))
        text = [f"<template><name>{self.name}</name>"]
        if self.parameters:
            text.append(f"<parameter>{escape(self.parameters)}</parameter>")
        text.append(f"<declaration>{escape(self.declarations)}</declaration>")
        for name in names:
            invariant = self.invariants.get(name)
            label = f'<label kind="invariant">{escape(invariant)}</label>' if invariant else ""
            mark = "<urgent/>" if name in self.urgent.split() else ""
            mark = "<committed/>" if name in self.committed.split() else mark
            text.append(f'<location id="{self.name}.{name}"><name>{name}</name>{label}{mark}</location>')
        text.append(f'<init ref="{self.name}.{first}"/>')
        text += map(self._edge, self.edges)
        return "".join([*text, "</template>"])

    def _edge(self, edge: str) -> str:
        end, *parts = edge.split(";")
        source, target = (f"{self.name}.{name.strip()}" for name in end.split("->"))
        kinds = {"guard": "guard", "sync": "synchronisation", "do": "assignment", "select": "select"}
        labels = ""
        for part in parts:
            kind, _, value = part.partition(":")
            labels += f'<label kind="{kinds[kind.strip()]}">{escape(value.strip())}</label>'
        return f'<transition><source ref="{source}"/><target ref="{target}"/>{labels}</transition>'


def document(
    declarations: str, *templates: Template, system: str = "", queries: Sequence[tuple[str, str]] = ()
) -> bytes:
    """A file; ``queries`` with their comments."""
    system = system or "system " + ", ".join(template.name for template in templates) + ";"
    body = "".join(template.xml() for template in templates)
    asked = "".join(
        f"<query><formula>{escape(formula)}</formula><comment>{escape(comment)}</comment></query>"
        for formula, comment in queries
    )
    declared = f"<declaration>{escape(declarations)}</declaration>"
    system = f"<system>{escape(system)}</system>"
    return f"<nta>{declared}{body}{system}<queries>{asked}</queries></nta>".encode()


def network(
    declarations: str, *templates: Template, system: str = "", queries: Sequence[tuple[str, str]] = ()
) -> Network:
    """The network of such a file."""
    return make_network(
        read_document(document(declarations, *templates, system=system, queries=queries), "model.xml")
    )
