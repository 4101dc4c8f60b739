"""All faults of a file at once, the ends of its channels, and what is exported: the same network when it is read."""

from __future__ import annotations

import tracemalloc
from xml.sax.saxutils import escape

import pytest

from end_effector_hal.description import SHIPPED_AUTOMATA
from end_effector_hal.errors import UsageError
from tests.support.nightly import first_of
from tests.unit.timed_automata.explore.models import network
from timed_automata import export, load_document, load_network, make_network, read_document
from timed_automata.check import channel_ends, find_faults

SHIPPED = SHIPPED_AUTOMATA

MODEL = """<nta>
<declaration>clock x; int v; const int K = 2; broadcast chan c;</declaration>
<template><name>P</name>
<location id="a"><name>A</name><label kind="invariant">{invariant}</label></location>
<location id="b"><name>{name}</name></location>
<init ref="a"/>
<transition><source ref="a"/><target ref="b"/>
<label kind="select">{select}</label>
<label kind="guard">{guard}</label>
<label kind="synchronisation">{sync}</label>
<label kind="assignment">{update}</label>
</transition>
</template>
<system>{system}</system>
<queries>
<query><formula>{query}</formula><comment>One.</comment></query>
<query><formula>E&lt;&gt; P.B</formula><comment>Two.</comment></query>
</queries>
</nta>"""
VALID = {
    "invariant": "x <= K", "name": "B", "select": "n : int[0, 3]", "guard": "v == n", "sync": "c!",
    "update": "v = n", "system": "system P;", "query": "A[] v <= 3",
}  # fmt: skip


def document(**parts: str):
    text = MODEL.format(**{key: escape(value) for key, value in (VALID | parts).items()})
    return read_document(text.encode(), "m.xml")


def found(**parts: str) -> list[str]:
    return [str(fault) for fault in find_faults(document(**parts))]


def test_a_valid_file_has_none():
    assert found() == []
    assert find_faults(load_document(SHIPPED)) == []


def test_all_are_told_in_the_order_of_the_file():
    faults = found(
        invariant="x <= L",
        name="A",
        guard="v = n",
        sync="d!",
        update="v = w",
        query="A[] Q.B",
        system="system P;",
    )
    assert [fault.partition(": ")[::2] for fault in faults] == [
        ("m.xml:4:64", "'L' is not declared."),
        ("m.xml:5:24", "Two locations of 'P' are called 'A'."),
        (
            "m.xml:9:21",
            "'v = n', an assignment inside an expression: outside of the supported subset. Did you mean '=='?",
        ),
        ("m.xml:10:31", "'d' is not declared."),
        ("m.xml:11:30", "'w' is not declared."),
        ("m.xml:16:21", "There is no process 'Q'. There are P."),
        ("m.xml:17:27", "'P' has no location and no variable 'B'."),
    ]


def test_what_only_follows_from_a_fault_is_not_told():
    # without its select, the other labels of the edge would be wrong
    (fault,) = found(select="n : int[0, L]")
    assert "'L' is not declared" in fault


def test_a_fault_in_declarations_hides_what_hangs_on_them():
    text = MODEL.replace("int v;", "int v = w;").format(
        **{k: escape(v) for k, v in (VALID | {"guard": "q"}).items()}
    )
    (fault,) = find_faults(read_document(text.encode(), "m.xml"))
    assert fault.where == "m.xml:2:31"
    (fault,) = map(str, find_faults(document(system="system Q;")))
    assert "'Q' is no template" in fault


def test_faults_that_given_constants_make():
    assert find_faults(document(), {"K": 5}) == []
    with pytest.raises(UsageError):
        find_faults(document(), {"L": 5})


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("Pr[<=10](<> P.B)", "a query of statistical model checking"),
        ("minE(v) [<=10]: <> P.B", "a query about strategies"),
        ("A[] v == 1.5", "'1.5', a floating-point number"),
        ("sup: q", "'q' is not declared"),
        ("P.A --> Q.B", "There is no process 'Q'"),
    ],
)
def test_queries_outside_of_the_subset_are_refused_by_name(query, message):
    (fault,) = find_faults(document(query=query))
    assert message in str(fault)
    assert fault.where.startswith("m.xml:16:")


@pytest.mark.parametrize("query", ["sup{P.A}: x", "inf: x, v", "P.A --> P.B", "E[] P.A", "A<> P.B || x > 3"])
def test_queries_inside_of_it_are_not(query):
    assert found(query=query) == []


def test_fifty_faults_are_enough():
    edge = MODEL[MODEL.index("<transition>") : MODEL.index("</template>")].replace("{guard}", "q")
    many = MODEL.replace("</template>", edge * 60 + "</template>")
    text = many.format(**{key: escape(value) for key, value in VALID.items()})
    assert len(find_faults(read_document(text.encode(), "m.xml"))) == 50


# Who stands at the ends of a channel.


def test_both_ends_are_told_by_template():
    model = network(
        "broadcast chan b[3]; urgent chan u; chan unused;",
        """P(const int[0,1] id):
            a -> b; select: n : int[0,1]; sync: b[n]!
            b -> a; sync: u!
            a -> a; sync: b[id]?""",
        "Q: a -> b; sync: u? | a -> a; select: n : int[0,2]; sync: b[n]?",
    )
    b, u, unused = channel_ends(model)
    assert (b.name, b.broadcast, b.urgent, b.senders, b.receivers) == (
        "b[3]",
        True,
        False,
        ("P",),
        ("P", "Q"),
    )
    assert (b.unsent, b.unreceived) == (("b[2]",), ())
    assert (u.name, u.broadcast, u.urgent, u.senders, u.receivers) == ("u", False, True, ("P",), ("Q",))
    assert (unused.senders, unused.receivers, unused.unsent) == ((), (), ("unused",))


def test_many_edges_that_may_use_any_of_many_channels_take_little_memory():
    edge = "a -> a; select: i : int[0,63]; sync: call[x][y]"
    model = network("chan call[64][64]; int[0,63] x, y;", f"P: {edge}!", f"Q: {edge}?")
    tracemalloc.start()
    (call,) = channel_ends(model)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (call.senders, call.receivers, call.unsent, call.unreceived) == (("P",), ("Q",), (), ())
    assert peak < 5_000_000


def test_every_channel_of_the_shipped_model_has_both_ends():
    ends = channel_ends(load_network(SHIPPED_AUTOMATA))
    assert [each.name for each in ends if each.unsent or each.unreceived] == []
    names = [each.name for each in ends]
    assert names[:3] == ["confirmed[3]", "partial[3]", "gone[3]"]


# A concrete network that was exported is the network: the same bytes each time, the same meaning when read.


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
