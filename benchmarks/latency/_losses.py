"""The loss of a held part: the time from the frame that shows it to the state that reports it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from end_effector_hal.description import Description
from end_effector_hal.kinds.vacuum import VacuumActuator
from end_effector_hal.vocabulary import EndEffectorState

from ._blocks import LONGEST_S, Tail, read
from ._driven import Driven
from ._hardware import Hardware
from ._matching import Latencies, MatchError, Note

AFTER_S = 2.5
"""Time from the activation of the first vacuum to the loss; everything is gripped by then."""


def measure_losses(
    hardware: Hardware, client: Driven, tail: Tail, count: int, say: Callable[[str], None]
) -> Latencies:
    """Lose a held part ``count`` times; each time it is dropped afterwards.

    Returns:
        µs: ``loss`` from the first frame beyond the threshold, ``loss_decided`` from the frame that decided.
    """
    name, part = _first_vacuum(hardware.description)
    say(f"losing a held part {count} times")
    tail.new()
    hardware.testbench.tell(f"scenario lost-after:{name}:{AFTER_S:g}")
    client.tell(f"lose {count}")
    failed = client.wait_done(expected_s=count * (AFTER_S + 1.0), timeout_s=count * LONGEST_S)
    hardware.testbench.tell("scenario nominal")
    for text in failed:
        say(f"left out: {text}")
    return loss_latencies(read(hardware.saw), tail.new(), part.channel, -part.lost_kpa * 1000)


def loss_latencies(events: Iterable[Note], notes: Sequence[Note], channel: str, lost_pa: float) -> Latencies:
    """Convert notes to latencies; a pure function.

    Args:
        events: events of the testbench.
        notes: goals and states noted by the client.
        channel: channel of the vacuum that is lost.
        lost_pa: gauge pressure above which a vacuum is lost.
    """
    frames = [event for event in events if "frame" in event and event["sent"]]
    found: Latencies = {"loss": [], "loss_decided": []}
    held_since: int | None = None
    for note in notes:
        if "received" not in note:
            continue
        if note["ee"] == EndEffectorState.GRIPPED:
            held_since = note["at"] if held_since is None else held_since
            continue
        if note["ee"] == EndEffectorState.GRIP_ERROR and held_since is not None:
            before = [frame for frame in frames if held_since < frame["at"] <= note["at"]]
            showing = [frame["at"] for frame in before if _lost(frame["values"].get(channel), lost_pa)]
            if not showing:
                raise MatchError("A grip was lost, and no frame shows it.")
            found["loss"].append(note["received"] - showing[0])
            found["loss_decided"].append(note["received"] - before[-1]["at"])
        held_since = None
    return found


def _lost(value: object, lost_pa: float) -> bool:
    return isinstance(value, int) and value > lost_pa


def _first_vacuum(description: Description) -> tuple[str, VacuumActuator]:
    return next(
        (name, actuator) for name, actuator in description.ordered if isinstance(actuator, VacuumActuator)
    )
