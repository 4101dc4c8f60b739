"""Colours, fonts and wording of the figures, and how they are saved."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib import style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import (
    ACTIVE,
    INACTIVE,
    PENDING,
    ChangerState,
    Command,
    EndEffectorState,
    TableState,
)

INK, MUTED, RULE = "#1d2733", "#5b6775", "#b9c0ca"

FILLS = {
    "inactive": "#d9dde5",
    "waiting for sensor": "#f4cd63",
    "confirmed": "#4db390",
    "releasing": "#a3cbed",
    "error": "#b8232f",
    "command": "#5d6fb0",
}
"""Colours of the kinds of state, in the order of the legend; distinguishable with colour blindness."""

NOTHING = "#f1f3f6"
WRONG = FILLS["error"]
WATCHED = "#e4e3f2"
"""Colour of a value in a requirement, or of a switch that proves neither; not a state of Table II."""
BAND, BAND_INK = "#e6f3ed", "#1f7a55"
THRESHOLDS = {"secure": (BAND_INK, (0, (1, 2))), "lost": ("#b8232f", (0, (5, 2, 1, 2)))}
"""Colour and dashes of each threshold line."""
PROOFS = {
    "confirmed": (BAND_INK, (0, (5, 2))),
    "lost": THRESHOLDS["lost"],
    "gone": (MUTED, (0, (1, 2))),
    "empty": (MUTED, (0, (5, 2))),
}
"""The same for a quantity other than pressure, by the evidence that its condition gives."""
CURVES = ("#0072b2", "#d55e00", "#cc79a7", "#009e73", "#b08800", "#56b4e9")
"""Okabe and Ito's colours, with the yellow darkened for lines on white."""

SUPPLY = "#7d8794"
MARKERS = {
    "command": ("o", "#2d4f72"),
    "timeout": ("v", "#8f5d00"),
    "abort": ("X", "#b8232f"),
    "lost": ("X", "#b8232f"),
    "alarm": ("^", "#a85400"),
    "missed": ("D", "#7a2f8f"),
    "disturbed": ("s", "#b0104f"),
    "gripped": ("*", "#1f7a55"),
}
"""Mark and colour of each kind of moment."""

_SHORT = {
    "PENDING EXTEND": ("PENDING EXT", "PENDING", "PEND."),
    "PENDING ON": ("PENDING", "PEND."),
    "RETRACTED": ("RETR.",),
    "EXTENDED": ("EXT.",),
    "GRIPPING": ("GRIPP.",),
    "RELEASING": ("REL.",),
    "RELEASE": ("REL.",),
    "RELEASE_ERROR": ("REL. ERROR",),
}

_OF_END_EFFECTOR = {
    EndEffectorState.OFF: "inactive",
    EndEffectorState.GRIPPING: "waiting for sensor",
    EndEffectorState.GRIP_ERROR: "error",
    EndEffectorState.GRIPPED: "confirmed",
    EndEffectorState.RELEASING: "releasing",
    EndEffectorState.RELEASE_ERROR: "error",
    EndEffectorState.STAND_BY: "inactive",
}
_OF_CHANGER = {
    ChangerState.LOCKED: "inactive",
    ChangerState.UNLOCKED: "confirmed",
    ChangerState.UNLOCKING: "waiting for sensor",
    ChangerState.LOCKING: "waiting for sensor",
    ChangerState.FAULT: "error",
}
OPEN = "open"
"""State of an e-stop that refuses every activation."""
_OF_SWITCH = {"confirmed": "confirmed", "gone": "inactive", OPEN: "error"}
_OF_ACTUATOR = {INACTIVE: "inactive", PENDING: "waiting for sensor", ACTIVE: "confirmed"}


@dataclass(frozen=True)
class ShownValue:
    """A value in a requirement, in words; ``wrong``: the value that violates it."""

    label: str
    wrong: bool = False


@dataclass(frozen=True)
class ShownLevel:
    """Level of a switch or an e-stop, in words; None: unknown. ``proven``: the evidence it gives alone, or ""."""

    label: str
    level: bool | None
    proven: str


Shown = TableState | ShownValue | ShownLevel
"""The types of value that a segment of a lane can show."""


def kind_of(state: Shown) -> str:
    """Return the kind of a state, a key of `FILLS` or "watched"; empty for NONE and unknown states."""
    if isinstance(state, ShownValue):
        return "error" if state.wrong else "watched"
    if isinstance(state, ShownLevel):
        return "" if state.level is None else _OF_SWITCH.get(state.proven, "watched")
    if isinstance(state, EndEffectorState):
        return _OF_END_EFFECTOR[state]
    if isinstance(state, Command):
        return "" if state is Command.NONE else "command"
    if isinstance(state, ChangerState):
        return _OF_CHANGER.get(state, "")
    return _OF_ACTUATOR[int(state)]


def fill_of(kind: str) -> str:
    return WATCHED if kind == "watched" else FILLS.get(kind, NOTHING)


def ink_of(kind: str) -> str:
    """Return the colour of text on a kind's fill."""
    return "white" if kind in ("error", "command") else INK


def wordings(state: Shown) -> tuple[str, ...]:
    """Return the texts for a state, the longest first."""
    return (state.label, *_SHORT.get(state.label, ()))


def plain(text: str, longest: int = 60) -> str:
    """Return a text from elsewhere on one line, cut to its longest length, with ``?`` for every character that the
    font may lack.
    """
    shown = "".join(char if char.isprintable() and ord(char) < 0x530 else "?" for char in text)
    return shown if len(shown) <= longest else shown[: longest - 1] + "…"


@contextmanager
def drawing() -> Iterator[None]:
    """Draw with fixed settings, independent of the user's matplotlibrc."""
    own = {
        "font.family": "DejaVu Sans",
        "text.color": INK,
        "text.parse_math": False,
        "axes.edgecolor": INK,
        "axes.labelcolor": INK,
        "xtick.color": INK,
        "ytick.color": INK,
        "svg.fonttype": "none",
        "svg.hashsalt": "end-effector-hal",
    }
    with style.context("default"), matplotlib.rc_context(own):  # type: ignore[arg-type]
        yield


DPI = 120


def save(figure: Figure, path: str | Path) -> Path:
    """Save as PNG or SVG, by the suffix, completely or not at all; the same figure gives the same bytes.

    Raises UsageError.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in (".png", ".svg"):
        raise UsageError(
            f"{path.name!r} is neither .png nor .svg.", where=str(path), todo="Choose one of these."
        )
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with drawing(), beside.open("wb") as file:
            if suffix == ".png":
                FigureCanvasAgg(figure)
                figure.savefig(file, format="png", metadata={"Software": "end-effector-hal"})
            else:
                FigureCanvasSVG(figure)
                figure.savefig(file, format="svg", metadata={"Date": None, "Creator": "end-effector-hal"})
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise UsageError(f"The figure cannot be written: {error.strerror}.", where=str(path)) from None
    return path
