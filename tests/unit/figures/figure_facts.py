"""What a drawn figure shows, measured on the figure itself."""

from itertools import combinations

from hypothesis import strategies as st
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from end_effector_hal.recording import StatesLog, StatesRow
from end_effector_hal.vocabulary import Command, EndEffectorState
from tests.support.trace_recordings import NAMES


def texts(figure, label=None):
    """Every word shown, in the order of drawing; of those with a label only."""
    found = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    return [text.get_text() for text in found if label is None or text.get_label() == label]


def bars(figure, lane):
    """(state, start_s, end_s, colour) of a lane."""
    found = [bar for bar in figure.findobj(Rectangle) if str(bar.get_label()).startswith(f"{lane}: ")]
    return [
        (bar.get_label().split(": ")[1], bar.get_x(), bar.get_x() + bar.get_width(), bar.get_facecolor())
        for bar in found
    ]


class _Listener(RendererAgg):
    """Draws, and remembers the lines of text that were really drawn: ticks beyond the limits are not."""

    def __init__(self, figure):
        super().__init__(figure.bbox.width, figure.bbox.height, figure.dpi)
        self.boxes = []

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):
        super().draw_text(gc, x, y, s, prop, angle, ismath, mtext)
        width, height, descent = self.get_text_width_height_descent(s, prop, ismath)
        if angle == 90:
            self.boxes.append((s, x - height + descent, y - width, x + descent, y))
        else:
            self.boxes.append((s, x, y - height + descent, x + width, y + descent))


def overlaps(figure):
    """Pairs of words that stand on each other, and words that pass the edge, as rendered; pixels."""
    renderer = _Listener(figure)
    figure.draw(renderer)
    boxes = renderer.boxes
    assert len(boxes) > 10
    found = [
        (a[0], b[0])
        for a, b in combinations(boxes, 2)
        if a[1] < b[3] and b[1] < a[3] and a[2] < b[4] and b[2] < a[4]
    ]
    width, height = figure.bbox.width, figure.bbox.height
    beyond = [box[0] for box in boxes if box[1] < 0 or box[2] < 0 or box[3] > width or box[4] > height]
    return found + [(text, "edge") for text in beyond]


@st.composite
def recordings(draw):
    """Any recording, also one that no tool makes."""
    times = sorted(draw(st.lists(st.floats(0, 600), min_size=1, max_size=25)))
    states, commands = st.sampled_from(EndEffectorState), st.sampled_from(Command)
    units = st.tuples(*[st.integers(0, 2)] * 3)
    return StatesLog(NAMES, tuple(StatesRow(t, draw(states), draw(commands), draw(units)) for t in times))
