"""All faults of a file at once, each where it stands; nothing outside of the subset passes, in queries either."""

from __future__ import annotations

from xml.sax.saxutils import escape

import pytest

from end_effector_hal.description import profile_path
from end_effector_hal.errors import UsageError
from timed_automata import load_document, read_document
from timed_automata.check import find_faults

SHIPPED = profile_path().with_name("end_effector.xml")

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
    "invariant": "x <= K",
    "name": "B",
    "select": "n : int[0, 3]",
    "guard": "v == n",
    "sync": "c!",
    "update": "v = n",
    "system": "system P;",
    "query": "A[] v <= 3",
}


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
        ("simulate [<=10] { v }", "a query of statistical model checking"),
        ("E[<=10; 100] (max: v)", "a query of statistical model checking"),
        ("strategy s = control: A<> P.B", "a query about strategies"),
        ("control: A[] not P.B", "a query about strategies"),
        ("minE(v) [<=10]: <> P.B", "a query about strategies"),
        ("A[ P.A U P.B ]", "until and weak until"),
        ("bounds: v", "'bounds'"),
        ("A[] P.A --> P.B", "'-->' inside another query"),
        ("A[] x - x < 3", "a diagonal constraint"),
        ("A[] v + x < 3", "a clock in an expression"),
        ("A[] deadlock == 1", "'deadlock' in an expression"),
        ("A[] v = 3", "an assignment inside an expression"),
        ("A[] v == 1.5", "'1.5', a floating-point number"),
        ("A[] P.C", "'P' has no location and no variable 'C'"),
        ("A[] v <", "The text ends too early"),
        ("P.B", "is no query"),
        ("sup: q", "'q' is not declared"),
        ("sup{P.B: x", "This brace is not closed"),
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
