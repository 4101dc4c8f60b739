"""What a proof says of small models: verdicts, runs, and what no query says."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import escape

import pytest

from end_effector_hal.automata import load_network, make_network, read_document
from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ModelError
from end_effector_hal.tool.proof import Proof, prove, requirements_of

LAMP = (
    "clock x; broadcast chan press; int[0, 3] presses;",
    {
        "Lamp": "off -> on; press? ; x = 0 | on -> off; press? | on -> off; x >= 5",
        "Person": "idle -> idle; press!",
    },
)


def model(declarations: str, templates: dict[str, str], *queries: tuple[str, str], invariants=None) -> bytes:
    """A file; an edge is ``a -> b; guard or sync; update``, the first location is the initial one."""
    parts = []
    for name, edges in templates.items():
        drawn, seen = [], []
        for edge in edges.split("|"):
            way, *labels = [text.strip() for text in edge.split(";")]
            ends = way.split(" -> ")
            seen += [end for end in ends if end not in seen]
            kinds = ["synchronisation" if text[-1:] in "!?" else "guard" for text in labels[:-1] or labels[:1]]
            texts = list(zip(kinds, labels, strict=False))
            texts += [("assignment", labels[-1])] if len(labels) > 1 else []
            body = "".join(f'<label kind="{k}">{escape(t)}</label>' for k, t in texts if t)
            drawn.append(f'<transition><source ref="{name}{ends[0]}"/><target ref="{name}{ends[1]}"/>{body}</transition>')
        places = "".join(
            f'<location id="{name}{place}"><name>{place}</name>'
            + (f'<label kind="invariant">{escape(text)}</label>' if (text := (invariants or {}).get(place)) else "")
            + "</location>"
            for place in seen
        )
        parts.append(f'<template><name>{name}</name>{places}<init ref="{name}{seen[0]}"/>{"".join(drawn)}</template>')
    asked = "".join(
        f"<query><formula>{escape(formula)}</formula><comment>{escape(comment)}</comment></query>"
        for formula, comment in queries
    )
    return (
        f"<nta><declaration>{escape(declarations)}</declaration>{''.join(parts)}"
        f"<system>system {', '.join(templates)};</system><queries>{asked}</queries></nta>"
    ).encode()


def proof_of(*parts, **options) -> Proof:
    return prove(make_network(read_document(model(*parts, **options), "model.xml")))


def finding(proof: Proof, id_: str):
    return next(each for each in proof.findings if each.id == id_)
