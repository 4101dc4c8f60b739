"""A file is read with everything that UPPAAL wrote, and written back byte for byte."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ModelError, UsageError
from tests.support.nightly import examples
from timed_automata import export, load_document, load_network, make_network, read_document, write_document

LAMP = Path(__file__).parents[1] / "models" / "lamp.xml"


def test_writing_back_changes_no_byte():
    assert write_document(load_document(LAMP)) == LAMP.read_bytes()
    assert export(load_network(LAMP)) == LAMP.read_bytes()


def test_layout_comments_and_queries_are_read():
    document = load_document(LAMP)
    (template,) = document.templates
    off, on, unnamed = template.locations
    assert (off.at.x, off.at.y, off.color, off.name.text.content) == (-136, 0, "#ffff00", "Off")
    assert off.labels["comments"].text.content == "Ends « here »."
    assert on.labels["invariant"].text.content == "y <= DIM[id] &&\nlevel >= 0"
    assert (on.labels["invariant"].at.x, on.labels["invariant"].at.y) == (126, 17)
    assert (unnamed.name, unnamed.committed, unnamed.urgent, template.initial) == (None, True, False, "id0")
    assert [(nail.x, nail.y) for nail in template.edges[0].nails] == [(0, -68), (34, -68)]
    assert [(query.formula.content, query.comment) for query in document.queries] == [
        ("A[] not deadlock", "It never stops."),
        ("E<> A.On && y > 3", ""),
    ]


@pytest.mark.parametrize(
    ("find", "where"),
    [
        ("level == 0", "35:40"),  # in the text of a label
        ("level = 1", "38:1"),  # on the second line of one
        ("1 < 2", "12:13"),  # before entities
        ("true", "12:33"),  # behind them
        ("3 < 4", "17:33"),  # in CDATA
        ("BRIGHT < 3", "18:13"),
        ("level >= 0", "26:1"),
    ],
)
def test_places_are_those_of_the_file(find, where):
    document = load_document(LAMP)
    (template,) = document.templates
    texts = [document.declarations, template.declarations]
    for part in (*template.locations, *template.edges):
        texts += [label.text for label in part.labels.values()]
    (text,) = [text for text in texts if find in text.content]
    assert text.where(text.content.index(find)) == f"{LAMP}:{where}"


def test_constants_are_put_in_where_they_stand():
    network = load_network(LAMP, {"BRIGHT": 7, "DIM": [30, 40], "LATCH": True, "LAMPS": 1, "TABLE": [[3, 3]]})
    source, written = LAMP.read_text().split("\n"), export(network).decode().split("\n")
    changed = {
        number + 1: new for number, (old, new) in enumerate(zip(source, written, strict=True)) if old != new
    }
    assert changed == {
        5: "const int BRIGHT = 7,   // second press within: bright",
        6: "          DIM[2] = {30, 40};",
        7: "const bool LATCH = true;",
        8: "const int[0, 3] LAMPS = 1, TABLE[LAMPS][2] = {{3, 3}};",
    }
    again = make_network(read_document(export(network), "again.xml"))
    assert again.constants == network.constants
    assert again.initial == network.initial


def test_a_text_with_entities_can_be_replaced():
    document = load_document(LAMP)
    text = document.declarations
    start = text.content.index("1 < 2")
    span = text.whole.__class__(text, start, start + len("1 < 2 && true"))
    written = write_document(document, [(span, "2 < 3 && « 4 »")]).decode()
    assert "bool both = 2 &lt; 3 &amp;&amp; « 4 »;\n" in written
    assert len(written.split("\n")) == len(LAMP.read_text().split("\n"))


def test_other_encodings_and_line_ends():
    source = LAMP.read_text()
    for encoding, ends in (("iso-8859-1", "\n"), ("utf-16", "\n"), ("utf-8", "\r\n")):
        raw = source.replace('"utf-8"', f'"{encoding}"').replace("\n", ends).encode(encoding)
        network = make_network(read_document(raw, "lamp.xml"), {"LAMPS": 1, "TABLE": [[3, 3]], "LATCH": True})
        written = export(network).decode(encoding)
        assert "TABLE[LAMPS][2] = {{3, 3}};" in written
        assert "const bool LATCH = true;" in written
        where = network.document.templates[0].edges[0].labels["guard"].text.where(0)
        assert where == "lamp.xml:35:40"


@pytest.mark.parametrize(
    ("constants", "message"),
    [
        ({"BRIGT": 1}, "declares no global constant 'BRIGT'. Did you mean 'BRIGHT'?"),
        ({"level": 1}, "'level' is not a constant"),
        ({"DIM": [1]}, "The constant 'DIM' needs a list of 2 values, not [1]"),
        ({"DIM": 1}, "The constant 'DIM' needs a list of 2 values, not 1"),
        ({"DIM": "ab"}, "The constant 'DIM' needs a list of 2 values, not 'ab'"),
        ({"BRIGHT": [1]}, "The constant 'BRIGHT' needs int values, not [1]"),
        ({"BRIGHT": 1.5}, "The constant 'BRIGHT' needs int values, not 1.5"),
        ({"BRIGHT": True}, "The constant 'BRIGHT' needs int values, not True"),
        ({"LATCH": 2}, "The constant 'LATCH' = 2 is outside of 0 to 1"),
        ({"LAMPS": 4}, "The constant 'LAMPS' = 4 is outside of 0 to 3"),
    ],
)
def test_constants_that_do_not_fit(constants, message):
    with pytest.raises(UsageError, match=re.escape(message)):
        load_network(LAMP, constants)


def test_a_constant_that_leaves_another_without_its_shape():
    with pytest.raises(ModelError, match="'TABLE' needs 3 values, not 2") as error:
        load_network(LAMP, {"LAMPS": 3})
    assert error.value.where == f"{LAMP}:8:46"


# Bad files ---------------------------------------------------------------------------------------------------


def test_a_file_cut_off_anywhere_is_a_model_error():
    source = LAMP.read_bytes()
    for length in range(0, len(source) - len("</nta>\n"), 7):
        with pytest.raises(ModelError) as error:
            make_network(read_document(source[:length], "cut.xml"))
        assert error.value.where.startswith("cut.xml:")


@settings(max_examples=examples(50, 3000), deadline=None)
@given(data=st.data())
def test_a_file_with_noise_is_read_or_refused(data):
    """Never a traceback, whatever happens to the bytes."""
    source = bytearray(LAMP.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        position = data.draw(st.integers(0, len(source) - 1))
        length = data.draw(st.integers(0, 20))
        source[position : position + length] = data.draw(st.binary(max_size=10))
    try:
        network = make_network(read_document(bytes(source), "noise.xml"))
    except ModelError as error:
        assert error.where.startswith("noise.xml")  # noqa: PT017 - either outcome is fine
    else:
        assert network.processes is not None


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (b"", "well-formed XML: no element found"),
        (b"%PDF-1.4 xml", "well-formed XML: not well-formed"),
        (b"name: verdin_gripper\nlines: 3\n", "well-formed XML"),
        (b"<html><body/></html>", "The file is <html>, not a UPPAAL model. Expected <nta>"),
        (b"<nta/>", "The model has no <system>"),
        (b'<?xml version="1.0" encoding="klingon"?><nta/>', "well-formed XML: unknown encoding"),
        (b'<!DOCTYPE nta [<!ENTITY a "aaaa">]><nta>&a;</nta>', "The entity 'a' is declared"),
        (b'<!DOCTYPE nta [<!ATTLIST location a CDATA "xx">]><nta/>', "The attribute 'a' is declared with a default"),
        (
            b'<!DOCTYPE nta [<!ATTLIST location a CDATA #FIXED "xx">]><nta/>',
            "The attribute 'a' is declared with a default",
        ),
        (b"<nta><template/><system/></nta>", "A template has no name"),
        (b"<nta><template><name>P</name></template><system/></nta>", "<template> has no <init>"),
        (b"<nta><template><name>P</name><location/></template><system/></nta>", "<location> has no attribute 'id'"),
        (
            b'<nta><template><name>P</name><location id="a"/><init ref="b"/></template><system/></nta>',
            "<init> refers to the location 'b', which does not exist",
        ),
        (
            b'<nta><template><name>P</name><location id="a" x="1" y="?"/><init ref="a"/></template><system/></nta>',
            "The coordinates are no integers",
        ),
        (b"<nta><system></system></nta>", "The text ends too early"),
        (b"<nta><declaration>int a</declaration><system>system P;</system></nta>", "The text ends too early"),
    ],
)  # fmt: skip
def test_what_is_no_uppaal_file(source, message):
    with pytest.raises(ModelError) as error:
        make_network(read_document(source, "bad.xml"))
    assert message in str(error.value)
    assert error.value.where.startswith("bad.xml:1:")


def test_declarations_that_add_nothing_are_read():
    kind = b"""<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System 1.6//EN'
        'http://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd' [<!ATTLIST location a CDATA #IMPLIED>]>"""
    source = LAMP.read_bytes()
    assert b"<!DOCTYPE" in source
    start, end = source.index(b"<!DOCTYPE"), source.index(b"<nta>")
    assert read_document(source[:start] + kind + source[end:], "lamp.xml").templates


def test_the_shipped_automata_are_read_and_written_back():
    path = load(profile_path()).automata_path
    assert export(load_network(path)) == path.read_bytes()
