"""The paper's figure (Figs. 7 to 9): asserted from the figure, not from pixels."""

from itertools import pairwise

import pytest
from hypothesis import given, settings

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import StatesLog
from end_effector_lab.figures import paper, save
from tests.support.nightly import examples, first_of
from tests.support.trace_recordings import CANCELLED, FAILS_ONCE, INFO, NAMES, NEVER, NOMINAL, log
from tests.unit.figures.figure_facts import overlaps, recordings, texts

SCENARIOS = {"nominal": NOMINAL, "fails-once": FAILS_ONCE, "never": NEVER, "cancelled": CANCELLED}


def curves(figure):
    return {line.get_label(): line for line in figure.axes[0].lines if not line.get_label().startswith("_")}


def test_one_step_curve_for_each_element():
    figure = paper(NEVER)
    assert list(curves(figure)) == [
        "HAL command",
        "End-effector",
        "Bottom vacuum",
        "Cylinder",
        "Top vacuum",
    ]
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert legend == list(curves(figure))
    assert {line.get_drawstyle() for line in curves(figure).values()} == {"steps-post"}


def test_curves_are_the_integers_of_table_ii_with_an_offset():
    lines = curves(paper(NEVER))
    values = list(lines["Cylinder"].get_ydata())
    offset = values[0]
    assert [value - offset for value in values[:-1]] == [0, 1, 0, 1, 0, 1, 0]
    assert list(lines["Cylinder"].get_xdata())[:-1] == [0.0, 1.5, 6.5, 7.5, 12.5, 13.5, 18.5]
    command = list(lines["HAL command"].get_ydata())
    assert [value - command[0] for value in command[:-1]] == [0, 3, 4, 0]


def test_curves_do_not_meet():
    ranges = [(min(line.get_ydata()), max(line.get_ydata())) for line in curves(paper(NEVER)).values()]
    assert all(lower[1] + 1 < upper[0] for upper, lower in pairwise(ranges))


@pytest.mark.parametrize(
    ("recording", "names"),
    [
        (
            NOMINAL,
            [
                "NONE",
                "GRIP",
                "NONE",
                "RELEASE",
                "NONE",
                "STAND_BY",
                "GRIPPING",
                "GRIPPED",
                "RELEASING",
                "STAND_BY",
            ],
        ),
        (
            NEVER,
            [
                "NONE",
                "GRIP",
                "RELEASE",
                "NONE",
                "GRIP_ERROR",
                "STAND_BY",
                "GRIPPING",
                "RELEASING",
                "STAND_BY",
            ],
        ),
    ],
)
def test_every_transition_has_its_name(recording, names):
    shown = texts(paper(recording), "name")
    assert shown[: len(names)] == names
    assert shown.count("RETRACTED") == (4 if recording is NEVER else 2)


@pytest.mark.parametrize("factor", first_of([0.05, 30, 1], 2, 0))
@pytest.mark.parametrize("name", SCENARIOS)
def test_no_words_stand_on_each_other(name, factor):
    rows = [(r.time_s * factor, *r.states) for r in SCENARIOS[name].rows]
    assert overlaps(paper(log(*rows), INFO)) == []


def test_many_actuators_have_a_legend_in_rows():
    names = [f"actuator_{n}_with_a_rather_long_name" for n in range(9)]
    figure = paper(log((0, 6, -1, *[0] * 9), (1, 1, 2, 1, *[0] * 8), (2, 3, -1, *[2] * 9), names=names))
    assert overlaps(figure) == []


def test_the_words_of_an_actuator_come_from_the_run(tmp_path):
    recording = log((0, 6, -1, 0), (1, 1, 2, 1), names=["grabber"])
    kind = type(INFO)(actuators={"grabber": "cylinder"})
    assert texts(paper(recording, kind), "name")[-2:] == ["RETRACTED", "PENDING EXTEND"]
    assert texts(paper(recording), "name")[-2:] == ["OFF", "PENDING ON"]
    assert save(paper(recording), tmp_path / "paper.svg").read_text().count(">PENDING ON</text>") == 1


def test_a_recording_without_rows_is_refused():
    with pytest.raises(UsageError, match="holds no row"):
        paper(StatesLog(NAMES, ()))


@settings(max_examples=examples(6, 200), deadline=None)
@given(recordings())
def test_any_recording_is_drawn_without_words_on_words(recording):
    assert overlaps(paper(recording)) == []
