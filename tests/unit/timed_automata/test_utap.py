"""What UPPAAL's own parser accepts is accepted, and what it refuses is refused, where they were seen to differ."""

from __future__ import annotations

import re

import pytest

from end_effector_hal.errors import ModelError
from timed_automata import Network, make_network, read_document
from timed_automata.explore import Explorer

MODEL = """<nta><declaration>int g; clock x; chan plain, array[2]; broadcast chan all, alls[2]; urgent chan now;
{declarations}</declaration>
<template><name>{template}</name><parameter>{parameter}</parameter>
<declaration>int own[2] = {{3, 4}}; int n = 1; int f() {{ return n + g; }}
int at(int k) {{ return own[k]; }}</declaration>
<location id="a"><name>{location}</name></location><location id="b"><name>B</name></location><init ref="a"/>
<transition><source ref="a"/><target ref="b"/>{labels}<label kind="comments">k</label></transition></template>
<system>{system}</system><queries>{queries}</queries></nta>"""


def network(**parts: str) -> Network:
    given = dict.fromkeys(("declarations", "parameter", "labels", "queries"), "")
    given |= {"template": "Girl", "location": "A", "system": "system Girl;"} | parts
    return make_network(read_document(MODEL.format(**given).encode(), "m.xml"))


def labels(*pairs: tuple[str, str]) -> str:
    return "".join(f'<label kind="{kind}">{text}</label>' for kind, text in pairs)


@pytest.mark.parametrize(
    ("parameter", "argument"),
    [
        ("broadcast chan &amp;c", "plain"),
        ("urgent chan &amp;c", "plain"),
        ("urgent chan &amp;c", "all"),
        ("urgent broadcast chan &amp;c", "now"),
        ("broadcast chan &amp;c", "array[1]"),
        ("broadcast chan &amp;c[2]", "alls"),
    ],
)
def test_a_channel_that_may_do_more_stands_for_one_that_may_do_less(parameter: str, argument: str) -> None:
    made = network(parameter=parameter, system=f"P = Girl({argument}); system P;")
    assert [each.broadcast for each in made.channels if each.name == "plain"] == [
        False
    ]  # it stays what it is


@pytest.mark.parametrize(
    ("parameter", "argument"),
    [
        ("chan &amp;c", "all"),
        ("chan &amp;c", "now"),
        ("broadcast chan &amp;c", "now"),
        ("broadcast chan &amp;c[2]", "array"),
        ("chan &amp;c[2]", "alls"),
    ],
)
def test_and_not_the_other_way_round_nor_in_an_array(parameter: str, argument: str) -> None:
    with pytest.raises(ModelError, match=f"m.xml:.*'{argument}' is "):
        network(parameter=parameter, system=f"P = Girl({argument}); system P;")


def test_in_a_template_a_channel_is_what_its_parameter_says() -> None:
    received = labels(("guard", "x &gt; 1"), ("synchronisation", "c?"))
    with pytest.raises(ModelError, match="a clock guard on an edge with an urgent channel"):
        network(parameter="urgent chan &amp;c", labels=received, system="P = Girl(plain); system P;")
    with pytest.raises(ModelError, match="'c' is broadcast chan"):
        network(parameter="chan &amp;c", system="Q(broadcast chan &amp;c) = Girl(c); P = Q(plain); system P;")


@pytest.mark.parametrize("comment", ["// nothing yet", "/* nothing\nyet */", " // a\n /* b */ "])
def test_a_query_that_is_only_a_comment_is_none(comment: str) -> None:
    asked = f"<query><formula>{comment}</formula></query><query><formula>E&lt;&gt; Girl.B</formula></query>"
    (query,) = network(queries=asked).document.queries
    assert query.formula.content == "E<> Girl.B"


@pytest.mark.parametrize(
    "query", ["// --> why\nE<> Girl.B", "/* E<> */ E<> Girl.B // sup: x", "E<> /* A[] */ Girl.B"]
)
def test_a_comment_in_a_query_is_none_of_it(query: str) -> None:
    assert Explorer(network()).check(query).holds


@pytest.mark.parametrize(
    ("query", "holds"),
    [
        ("A[] Girl(1).f() == 1", True),
        ("E<> Girl(0).f() > 1", False),
        ("A[] forall (i : int[0, 1]) Girl(i).at(i) == 3 + i", True),
        ("A[] Girl(0).at(Girl(1).n) == 4", True),
    ],
)
def test_a_query_calls_a_function_of_a_process(query: str, holds: bool) -> None:
    verdict = Explorer(network(parameter="const int[0,1] i")).check(query)
    assert verdict.holds is holds
    many = Explorer(network(parameter="const int[0,8] i"))  # more than are written out of themselves
    assert many.check("A[] forall (i : int[0, 8]) Girl(i).f() == 1").holds


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("A[] Girl.g()", "query:1:5: 'Girl' has no function 'g'."),
        ("A[] Girl.ff() == 1", "Did you mean 'f'?"),
        ("A[] Boy.f() == 1", "There is no process 'Boy'."),
        ("A[] Girl.f(1) == 1", "'f' takes 0 arguments, not 1."),
    ],
)
def test_a_function_that_a_process_does_not_have(query: str, message: str) -> None:
    with pytest.raises(ModelError, match=re.escape(message)):
        Explorer(network()).check(query)


def test_words_that_only_other_languages_reserve_are_names() -> None:
    words = "switch, case, break, continue, foreach, numOf"
    made = network(declarations=f"int {words}; void h() {{ break = 1; continue += 1; switch = case; }}")
    assert Explorer(made).check("A[] switch + case + break + continue == 0").holds


@pytest.mark.parametrize("name", ["while", "assert", "select", "switch", "query", "a#1$"])
def test_a_location_may_have_a_name_that_only_declarations_reserve(name: str) -> None:
    made = network(location=name)
    if name.isalpha():
        assert Explorer(made).check(f"E<> Girl.{name}").holds


@pytest.mark.parametrize("part", ["location", "template"])
@pytest.mark.parametrize(
    "name", ["int", "not", "state", "init", "deadlock", "sup", "X", "control", "sin", "true"]
)
def test_a_keyword_is_no_name_of_a_location_or_a_template(part: str, name: str) -> None:
    with pytest.raises(ModelError, match=rf"^m.xml:\d+:\d+: '{name}' is a keyword of UPPAAL") as error:
        network(**{part: name})
    assert error.value.code == "EE-300"


@pytest.mark.parametrize("name", ["two words", "1a", "a-b", "Größe", "a.b"])
def test_a_name_is_one_word(name: str) -> None:
    with pytest.raises(ModelError, match=rf"^m.xml:6:24: '{name}' is no name."):
        network(location=name)


SELECT = ("select", "k : int[0, 1]")


@pytest.mark.parametrize(
    "early",
    [
        ("guard", "g == k"),
        ("synchronisation", "array[k]!"),
        ("assignment", "g = k"),
        ("guard", "exists (j : int[0, 1]) j == k"),
    ],
)
def test_a_select_stands_before_the_labels_that_use_it(early: tuple[str, str]) -> None:
    network(labels=labels(SELECT, early))
    with pytest.raises(
        ModelError, match=r"^m.xml:7:\d+: 'k' is used here, but the label that selects it comes"
    ):
        network(labels=labels(early, SELECT))


@pytest.mark.parametrize("early", ["g == 0", "forall (k : int[0, 1]) k &gt;= g"])
def test_a_select_may_stand_behind_labels_that_do_not_use_it(early: str) -> None:
    assert (
        len(network(labels=labels(("guard", early), SELECT, ("assignment", "g = k"))).processes[0].edges) == 2
    )
