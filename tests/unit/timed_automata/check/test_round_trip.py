"""A concrete network that was exported is the network: the same bytes each time, the same meaning when read."""

from __future__ import annotations

import pytest

from end_effector_hal.description import profile_path
from tests.support.nightly import first_of
from timed_automata import export, load_document, load_network, make_network, read_document
from timed_automata.check import channel_ends

SHIPPED = profile_path().with_name("end_effector.xml")
ENDINGS = ("CANCEL", "TIMEOUT", "ABORT", "LOSS", "START", "DEATH", "HELD_DEATH")


def constants(n: int) -> dict[str, object]:
    return {
        "N": n,
        "USES": [[True] * n],
        "ATTEMPTS": [[1 + i % 4 for i in range(n)]],
        "T_CONFIRM": [[1000 * (i + 1) for i in range(n)]],
        "T_RESET": [10 * i for i in range(n)],
        "T_GONE": [2000] * n,
        "RELEASE_ORDER": [(i + 1) % n for i in range(n)],
        **{name: [0] * n for name in ("T_BLOW", "T_GAP", "IL_08_GAP")},
        "UNTIL_GONE": [False] * n,
        "D": 20,
        **{f"{ending}_KEEPS": [i % 2 == 0 for i in range(n)] for ending in ENDINGS},
        "IL_07": False,
    }


@pytest.mark.parametrize("n", first_of([1, 3, 2, 8, 32], 2))
def test_what_was_exported_is_the_same_network(n):
    given = load_network(SHIPPED, constants(n))
    written = export(given)
    assert written == export(load_network(SHIPPED, constants(n)))
    again = make_network(read_document(written, "again.xml"))
    assert again.constants == given.constants
    assert again.initial == given.initial
    assert again.offsets == given.offsets
    assert (again.variables, again.clocks, again.channels) == (given.variables, given.clocks, given.channels)
    assert [p.name for p in again.processes] == [p.name for p in given.processes]
    for one, other in zip(again.processes, given.processes, strict=True):
        assert [
            (e.source, e.target, e.direction, e.channels, e.selected, e.resets, e.guard.never)
            for e in one.edges
        ] == [
            (e.source, e.target, e.direction, e.channels, e.selected, e.resets, e.guard.never)
            for e in other.edges
        ]
        assert [[c.fixed for c in e.guard.clocks] for e in one.edges] == [
            [c.fixed for c in e.guard.clocks] for e in other.edges
        ]
    assert channel_ends(again) == channel_ends(given)
    # and once more: it is a fixed point
    assert export(make_network(read_document(written, "again.xml"), constants(n))) == written


def test_layout_comments_and_queries_are_kept():
    before, after = (
        load_document(SHIPPED),
        read_document(export(load_network(SHIPPED, constants(8))), "again.xml"),
    )
    assert [(q.formula.content, q.comment) for q in after.queries] == [
        (q.formula.content, q.comment) for q in before.queries
    ]
    for old, new in zip(before.templates, after.templates, strict=True):
        assert [(e.nails, e.color) for e in new.edges] == [(e.nails, e.color) for e in old.edges]
        assert [
            (
                each.at,
                each.name.at,
                [(label.kind, label.text.content, label.at) for label in each.labels.values()],
            )
            for each in new.locations
        ] == [
            (
                each.at,
                each.name.at,
                [(label.kind, label.text.content, label.at) for label in each.labels.values()],
            )
            for each in old.locations
        ]
    assert "// failed attempts of one step that abort" in after.declarations.content
    changed = [
        (old, new)
        for old, new in zip(before.source.split(b"\n"), after.source.split(b"\n"), strict=True)
        if old != new
    ]
    assert len(changed) == 20
    assert changed[0][1].startswith(b"const int N = 8;  ")
