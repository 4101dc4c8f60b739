"""Templates as drawn: everything where the file says, in UPPAAL's colours, the same bytes each time."""

from __future__ import annotations

import re

import pytest
from matplotlib.patches import Circle, PathPatch, Polygon

from end_effector_hal.description import SHIPPED_AUTOMATA
from end_effector_hal.errors import UsageError
from end_effector_lab.figures import draw_template, save
from end_effector_lab.figures._automaton_layout import HEAD, RADIUS, arrow_between, layout_of
from tests.unit.figures.figure_facts import texts
from tests.unit.figures.layout_faults import layout_faults
from timed_automata import load_document, read_document

SHIPPED = load_document(SHIPPED_AUTOMATA)
BY_NAME = {template.name.content: template for template in SHIPPED.templates}

LAMP = """<nta><template><name>Lamp</name><parameter>const int[0,1] id, int &amp;v</parameter>
<declaration>int n = K;</declaration>
<location id="a" x="0" y="0" color="#ffff00"><name x="-10" y="-34">Off</name>
<label kind="comments" x="5" y="20">rests</label></location>
<location id="b" x="300" y="0"><name x="290" y="-34">On</name>
<label kind="invariant" x="290" y="14">y &lt;= DIM[id]</label><committed/></location>
<location id="c" x="300" y="200"><urgent/></location>
<init ref="a"/>
<transition color="#ff0000"><source ref="a"/><target ref="b"/>
<label kind="select" x="100" y="-150">i : int[0,1]</label>
<label kind="guard" x="100" y="-133">v == i &amp;&amp;
y &gt;= 2</label>
<label kind="synchronisation" x="100" y="-99">press?</label>
<label kind="assignment" x="100" y="-82">y = 0, $v = 1$</label>
<nail x="0" y="-100"/><nail x="300" y="-100"/></transition>
<transition><source ref="c"/><target ref="c"/></transition>
</template><system>system Lamp;</system></nta>"""


def lamp(text: str = LAMP):
    return read_document(text.encode(), "lamp.xml").templates[0]


def places(figure):
    return {text.get_text(): (text.get_position(), text.get_color()) for text in figure.axes[0].texts}


# The shipped file --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", list(BY_NAME))
def test_the_shipped_automata_read_well(name):
    assert layout_faults(BY_NAME[name]) == []


def test_every_label_of_the_shipped_automata_is_shown():
    for template in SHIPPED.templates:
        shown = texts(draw_template(template))
        labels = [label for each in template.locations for label in (each.name, *each.labels.values())]
        labels += [label for edge in template.edges for label in edge.labels.values()]
        lines = [line for label in labels for line in label.text.content.split("\n")]
        for line in lines:
            assert shown.count(line) == lines.count(line) + (line in ("guard", "comment")), line


# Where and how -----------------------------------------------------------------------------------------------


def test_labels_stand_where_the_file_says_in_the_colours_of_uppaal():
    found = places(draw_template(lamp()))
    assert found["i : int[0,1]"] == ((100, -150 + 12), "#8f7400")  # ochre
    assert found["v == i &&"] == ((100, -133 + 12), "#16782f")  # green
    assert found["y >= 2"] == ((100, -133 + 15 + 12), "#16782f")
    assert found["press?"] == ((100, -99 + 12), "#008391")  # teal
    assert found["y = 0, $v = 1$"] == ((100, -82 + 12), "#2438c8")  # blue, and no mathematics
    assert found["y <= DIM[id]"] == ((290, 14 + 12), "#96249c")  # purple
    assert found["Off"] == ((-10, -34 + 12), "#7c2415")
    assert found["rests"][0] == (5, 20 + 12)


def test_locations_are_circles_with_their_marks():
    figure = draw_template(lamp())
    circles = [(circle.center, circle.radius) for circle in figure.findobj(Circle)]
    assert circles == [((0, 0), RADIUS), ((0, 0), RADIUS - 3.2), ((300, 0), RADIUS), ((300, 200), RADIUS)]
    found = places(figure)
    assert (found["C"][0], found["U"][0]) == ((300, 0), (300, 200))
    assert figure.findobj(Circle)[0].get_facecolor()[:3] == (1, 1, 0)


def test_edges_run_through_their_nails_with_rounded_corners_to_the_rim():
    figure = draw_template(lamp())
    (line, loop), (head, _) = figure.findobj(PathPatch), figure.findobj(Polygon)
    spots = [tuple(spot) for spot in line.get_path().vertices.tolist()]
    assert spots == [
        (0, -11),
        (0, -78),
        (0, -100),
        (22, -100),
        (278, -100),
        (300, -100),
        (300, -78),
        (300, -21),
    ]
    assert list(line.get_path().codes) == [1, 2, 3, 3, 2, 3, 3, 2]
    assert tuple(head.get_xy()[0]) == (300, -RADIUS)
    assert line.get_edgecolor()[:3] == (1, 0, 0)
    assert len(loop.get_path().vertices) == 8  # a loop without nails gets two


def test_an_arrow_ends_on_both_rims():
    arrow = arrow_between((0, 0), [], (100, 0))
    assert arrow.corners == ((RADIUS, 0), (100 - RADIUS, 0))
    assert arrow.tip[0] == (100 - RADIUS, 0)
    assert {x for x, _ in arrow.tip[1:]} == {100 - RADIUS - HEAD}
    assert arrow.middle == (50, 0)
    # nails on one another, or on the centre, are no corners
    assert arrow_between((0, 0), [(0, 0), (50, 0), (50, 0)], (100, 0)).corners == ((11, 0), (50, 0), (89, 0))
    assert len(arrow_between((5, 5), [(5, 5)], (5, 5)).corners) == 2


def test_corners_close_to_one_another_share_what_lies_between():
    arrow = arrow_between((0, 0), [(0, -60), (20, -60)], (20, 40))
    assert [(begin, end) for begin, _, end in arrow.rounded()] == [
        ((0, -50), (10, -60)),
        ((10, -60), (20, -50)),
    ]


def test_everything_is_on_the_sheet():
    for template in SHIPPED.templates:
        figure = draw_template(template)
        axes = figure.axes[0]
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        box = layout_of(template).box
        assert left < box.x0 < box.x1 < right
        assert top < box.y0 < box.y1 < bottom
        # one pixel of UPPAAL is one of 96 to the inch in both directions
        assert figure.get_figwidth() * 96 == pytest.approx(right - left)
        assert figure.get_figheight() * 96 == pytest.approx(bottom - top)


def test_the_name_and_the_constants_that_are_mentioned_stand_above():
    constants = {"K": 7, "DIM": [30, 40], "LATCH": True, "v": [True] * 6, "unused": 3}
    shown = texts(draw_template(lamp(), constants))
    assert shown[0] == "Lamp(const int[0,1] id, int &v)"
    assert shown[1] == "K = 7, DIM = {30, 40}, v = {true, … 6 times}"
    assert texts(draw_template(lamp()))[1] == "select"


def test_a_file_without_coordinates_is_drawn_all_the_same():
    bare = re.sub(r' [xy]="-?\d+"', "", LAMP).replace("<nail/>", "")
    layout = layout_of(lamp(bare))
    assert len({(disc.x, disc.y) for disc in layout.discs}) == 3
    assert not any(a.box.meets(b.box) for n, a in enumerate(layout.discs) for b in layout.discs[n + 1 :])
    assert {words.lines for words in layout.words} >= {("Off",), ("press?",)}
    assert "press?" in texts(draw_template(lamp(bare)))


@pytest.mark.parametrize("colour", ["red", "#12345", "#gggggg", "rgb(1,2,3)", ""])
def test_a_colour_that_is_none_is_left_out(colour):
    figure = draw_template(lamp(LAMP.replace('"#ffff00"', f'"{colour}"')))
    assert figure.findobj(Circle)[0].get_facecolor()[:3] != (1, 1, 0)


@pytest.mark.parametrize(
    ("old", "new"),
    [('x="300" y="200"', 'x="300" y="9000000"'), ("press?", "press" * 9000), ('y="-150"', 'y="-30000"')],
)
def test_what_is_too_large_to_be_drawn_is_said(old, new):
    with pytest.raises(UsageError, match="too large to be drawn") as error:
        draw_template(lamp(LAMP.replace(old, new)))
    assert error.value.where == "lamp.xml:1:6"


def test_letters_that_the_font_does_not_have(tmp_path):
    figure = draw_template(lamp(LAMP.replace("rests", "休み $x^2 \u200b").replace(">Off<", ">😀<")))
    save(figure, tmp_path / "a.png")  # a warning is an error here
    assert "?? $x^2 ?" in texts(figure)


# Files -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_the_same_bytes_each_time(tmp_path, suffix):
    first, again = (save(draw_template(BY_NAME["Actuator"]), tmp_path / f"{n}.{suffix}") for n in range(2))
    assert first.read_bytes() == again.read_bytes()


def test_words_in_the_svg_are_words(tmp_path):
    svg = save(draw_template(BY_NAME["Actuator"]), tmp_path / "a.svg").read_text()
    for word in ("Confirming", "evidence[id] == CONFIRMED", "deactivate[id]?", "adopted[id] &amp;&amp; "):
        assert word in svg
