"""What is too large or too deep is refused with a sentence and its place, before it costs time or memory."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.errors import ModelError
from timed_automata import Network, load_network, make_network, read_document
from timed_automata._limits import (
    DIGITS,
    ELEMENTS,
    FILE_BYTES,
    NESTING,
    PROCESSES,
    REPEATS,
    TEXT_CHARACTERS,
    XML_DEPTH,
    XML_ELEMENTS,
)
from timed_automata.compiler._expressions import Expressions
from timed_automata.language import _parser
from timed_automata.network import _definitions, _templates

BIG = 2_000_000_000


def xml(
    declarations: str = "", *, guard: str = "", parameter: str = "", select: str = "", system: str = "system T;",
    more: str = "", edges: int = 1,
) -> bytes:  # fmt: skip
    """A model of one template with one location."""

    def text(each: str) -> str:
        return each.replace("&", "&amp;").replace("<", "&lt;")

    edge = (
        '<transition><source ref="a"/><target ref="a"/>'
        f'<label kind="select">{text(select)}</label><label kind="guard">{text(guard)}</label></transition>'
    )
    return (
        f"<nta><declaration>{text(declarations)}</declaration><template><name>T</name>"
        f'<parameter>{text(parameter)}</parameter><location id="a"/>{more}<init ref="a"/>{edge * edges}'
        f"</template><system>{text(system)}</system></nta>"
    ).encode()


def made(source: bytes) -> Network:
    return make_network(read_document(source, "model.xml"))


DEEP = f"This is nested too deeply, more than {NESTING} deep. Break it into parts."
DECLARED: list[tuple[str, str]] = [
    (f"const int N = {'9' * 5000};", f"A number of 5000 digits. Expected at most {DIGITS} digits."),
    (f"int a[{'1' * 11}];", f"A number of 11 digits. Expected at most {DIGITS} digits."),
    (f"const int N = sum (i : int[0, {BIG}]) i;", f"runs through {BIG + 1} values, more than {REPEATS}."),
    (f"int f() {{ for (i : int[0, {BIG}]) {{ }} return 1; }} const int N = f();", f"{BIG + 1} values, more than"),
    ("const int N = sum (i : int[0, 99]) sum (j : int[0, 99]) sum (k : int[0, 1]) k;", "runs through 20000 values"),
    (
        f"int f() {{ return sum (i : int[0, 999]) i; }} const int N = {'sum (j : int[0, 10]) '}f();",
        "'f()' runs through 11000 values",
    ),
    ("int f() { int s = 0; for (i : int[0, 99]) for (j : int[0, 100]) s = 0; return s; }", "runs through 10100 values"),
    (f"const int N = {'*'.join(['9999999999'] * 3)};", "has 67 bits. UPPAAL computes with 32."),
    (f"int a[{BIG}];", f"'a' has {BIG} elements, more than {ELEMENTS}."),
    ("chan c[int[0, 99999]][2];", f"'c' has 200000 elements, more than {ELEMENTS}."),
    ("".join(f"int a{n}[60000]; " for n in range(2)), f"With 'a1' more than {ELEMENTS} elements are declared."),
    (f"void f() {{ int a[{BIG}]; }}", "elements, more than"),
    (f"void f() {{ {'{' * 600} {'}' * 600} }}", DEEP),
    (f"int a[1] = {'{' * 600}1{'}' * 600};", DEEP),
    (f"int a = {'(' * 30_000}1{')' * 30_000};", DEEP),
    (f"int v; {' ' * TEXT_CHARACTERS}", f"more than {TEXT_CHARACTERS}. Break it into parts."),
]  # fmt: skip
GUARDS: list[tuple[str, str]] = [
    (f"1 == {'9' * 5000}", "A number of 5000 digits."),
    (f"forall (i : int[0, {BIG}]) v >= i", f"runs through {BIG + 1} values, more than {REPEATS}. Take a smaller"),
    (f"exists (i : int[0, {BIG}]) v >= i", f"runs through {BIG + 1} values"),
    (f"forall (i : int[{-BIG}, {BIG}]) i == i", f"runs through {2 * BIG + 1} values"),
    ("".join(f"forall (i{n} : int[0, 7]) " for n in range(9)) + "v >= i0", "runs through 32768 values"),
    (f"{'(' * 30_000}1{')' * 30_000}", DEEP),
    (f"{'a[' * 20_000}0{']' * 20_000}", DEEP),
    (f"{'!' * 60_000}v", DEEP),
    (f"{'not ' * 10_000}v", DEEP),
    (f"{'- ' * 30_000}v", DEEP),
    (f"v{'+v' * 3_000}", "nested too deeply"),
    (f"v{'+v' * 30_000}", "nested too deeply"),
    (f"{'v ? ' * 5_000}1{' : 1' * 5_000}", "nested too deeply"),
    (" imply ".join(["true"] * 400), "nested too deeply"),
    (f"{'v == 1 ? 1 : ' * 400}0", "nested too deeply"),
]  # fmt: skip


@pytest.mark.parametrize(("declarations", "said"), DECLARED, ids=[each[0][:30] for each in DECLARED])
def test_a_declaration_beyond_a_limit_is_refused(declarations: str, said: str) -> None:
    with pytest.raises(ModelError) as caught:
        made(xml(declarations))
    assert said in str(caught.value)
    assert str(caught.value).startswith("model.xml:1:")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(("guard", "said"), GUARDS, ids=[each[0][:30] for each in GUARDS])
def test_a_guard_beyond_a_limit_is_refused(guard: str, said: str) -> None:
    with pytest.raises(ModelError) as caught:
        made(xml("int v; int a[2];", guard=guard))
    assert said in str(caught.value)
    assert str(caught.value).startswith("model.xml:1:")
    assert len(str(caught.value)) < 300


def test_what_is_too_deep_for_python_is_refused_as_well() -> None:
    with pytest.raises(ModelError, match="nested too deeply"):
        made(xml("int v;", guard=f"{'-(' * 300}v{')' * 300} == 1"))


def test_what_is_just_within_the_limits_is_read() -> None:
    network = made(
        xml(
            f"const int N = {2**31 - 1}; int a[{ELEMENTS - 3}]; int v;"
            f" int f() {{ return sum (i : int[0, {REPEATS // 10 - 1}]) i; }}",
            guard=f"{'(' * NESTING}v{')' * NESTING} == 0 && {'- ' * 50}v == 0"
            " && (forall (i : int[0, 9]) f() >= i)",
        )
    )
    assert network.constants["N"] == 2**31 - 1


def test_brackets_in_comments_are_no_nesting() -> None:
    assert made(xml(f"/* {'(' * 1000} */ int v; // {'[' * 1000}\n"))


# What would be made of a small file


def counted(monkeypatch: pytest.MonkeyPatch, module: Any, name: str) -> Callable[[], int]:
    calls, original = count(), getattr(module, name)
    made_so_far = [0]

    def counting(*args: Any, **options: Any) -> Any:
        made_so_far[0] = next(calls) + 1
        return original(*args, **options)

    monkeypatch.setattr(module, name, counting)
    return lambda: made_so_far[0]


@pytest.mark.parametrize(
    ("parameter", "wanted"),
    [(f"int[0, {BIG}] i", BIG + 1), (f"int[1, {PROCESSES + 1}] i", PROCESSES + 1),
     (", ".join(f"int[0, 9] i{n}" for n in range(20)), 10**20)],
)  # fmt: skip
def test_too_many_processes_are_refused_before_one_is_made(
    parameter: str, wanted: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = counted(monkeypatch, _definitions, "make_process")
    with pytest.raises(ModelError, match=f"With 'T' there are {wanted} processes, more than {PROCESSES}"):
        made(xml(parameter=parameter))
    assert calls() == 0
    assert len(made(xml(parameter="int[1, 50] i")).processes) == 50


def test_too_many_edges_of_all_processes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_templates, "PARTS", 500)
    with pytest.raises(ModelError, match="More than 500 locations and edges in all processes together"):
        made(xml(select="i : int[0, 99]", edges=6))


def test_a_quantifier_is_refused_before_it_is_written_out(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = counted(monkeypatch, Expressions, "_unrolled")
    guard = "".join(f"forall (i{n} : int[0, 7]) " for n in range(60)) + "v >= i0"
    with pytest.raises(ModelError, match="runs through 32768 values"):
        made(xml("int v;", guard=guard))
    assert calls() <= 5


def test_a_text_that_is_too_deep_never_reaches_the_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = counted(monkeypatch, _parser, "_Parser")
    with pytest.raises(ModelError, match="deep"):
        made(xml("(" * 60_000))
    assert calls() == 0


# The file


@pytest.mark.parametrize("tag", ["a", "nta", "template"])
def test_elements_within_each_other(tag: str) -> None:
    with pytest.raises(ModelError) as caught:
        read_document(f"<{tag}>".encode() * 50_000, "model.xml")
    assert f"Elements are nested more than {XML_DEPTH} deep. UPPAAL does not write such a model." in str(
        caught.value
    )
    assert str(caught.value).startswith("model.xml:1:")


def test_too_many_elements() -> None:
    with pytest.raises(ModelError, match=f"model.xml:1:.*: More than {XML_ELEMENTS} elements."):
        read_document(xml(more='<location id="b"/>' * XML_ELEMENTS), "model.xml")


def test_a_file_that_is_too_large_is_not_read_to_its_end(tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_bytes(b"<" * (FILE_BYTES + 1))
    for path in (tmp_path / "model.xml", Path("/dev/zero")):
        with pytest.raises(ModelError, match=f"The file has more than {FILE_BYTES} bytes. Split it"):
            load_network(path)
