"""A lamp and its button on GPIO lines do what lamp.xml says: python lamp.py CHIP BUTTON LAMP, with offsets of lines."""

import sys
import time
from pathlib import Path

import gpiod
from gpiod.line import Bias, Direction, Edge, Value

from timed_automata import Event, Execution, live, load_network

CHIP, BUTTON, LAMP = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
MODEL = Path(__file__).with_name("lamp.xml")

lines = gpiod.request_lines(
    CHIP,
    consumer="lamp",
    config={
        BUTTON: gpiod.LineSettings(edge_detection=Edge.FALLING, bias=Bias.PULL_UP),
        LAMP: gpiod.LineSettings(direction=Direction.OUTPUT, output_value=Value.INACTIVE),
    },
)


def clock_us() -> int:
    """Return the present time, µs."""
    return time.monotonic_ns() // 1000


def wait(seconds: float | None) -> Event | None:
    """Wait for the button; return None if the time is over."""
    if not lines.wait_edge_events(seconds):
        return None
    lines.read_edge_events()
    return Event("press")


lamp = Execution(load_network(MODEL), ["Lamp"])
for _ in live(lamp, clock_us, wait):
    lines.set_value(LAMP, Value(lamp.value("level")))
