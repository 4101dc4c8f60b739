"""Stop and reset: latch faults at the line arbiter, and clear them (section 6 of the contract)."""

from __future__ import annotations

from typing import Protocol

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.control import Answer
from end_effector_hal.control.goals import reset_answer
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import ArbiterError, WireError

STOP_LATCHED = (
    "The stop is latched: nothing is activated until a reset, a running grip is cancelled, and what is held stays "
    "held. This is no safety function."
)


class AcknowledgingProgram(Protocol):
    """The method of the gripping program that a reset calls."""

    def acknowledge(self) -> None:
        """Report that the alarms that are over were seen."""


def reset(description: Description, grip: AcknowledgingProgram, *others: Answer) -> Answer:
    """Clear the faults that the line arbiter has latched, and the alarms about a held part that are over.

    GRIP_ERROR and RELEASE_ERROR stay: they need a Drop. A fault whose cause persists also stays.

    Args:
        description: the tool.
        grip: its gripping program.
        others: the answers of earlier resets: of the tool changer, because the line arbiter stores its sensor fault
            until its program has been reset.
    """
    grip.acknowledge()
    try:
        with ArbiterClient(socket_path(description), "reset", patience_s=0) as arbiter:
            stays = arbiter.reset()
        if all(answer.accepted for answer in others):  # who refused has said why
            others = (*others, *(Answer(False, why) for why in stays.values()))
    except WireError as error:
        others = (*others, Answer(False, str(error), decided=not isinstance(error, ArbiterError)))
    return reset_answer(others)


def stop(description: Description) -> Answer:
    """Latch a stop at the line arbiter: until a reset nothing is activated (IL-13), and a running grip is cancelled.

    What is held stays held. This is no safety function: it needs a working line arbiter and a working program.
    """
    try:
        with ArbiterClient(socket_path(description), "stop", patience_s=0) as arbiter:
            return Answer(True, latch_stop(arbiter))
    except WireError as error:
        return Answer(False, f"The stop is not latched: {error}", decided=not isinstance(error, ArbiterError))


def latch_stop(arbiter: ArbiterClient) -> str:
    """Latch a stop; return sentences about its effect, and whether it would be lost when the line arbiter ends.

    Raises:
        WireError: the line arbiter cannot be reached, or does not answer.
    """
    arbiter.stop()
    faults = arbiter.status()["faults"]
    lost = [str(faults[name]) for name in ("session record", "journal") if name in faults]
    return " ".join([STOP_LATCHED, *(["It may be lost when the line arbiter ends:", *lost] if lost else [])])
