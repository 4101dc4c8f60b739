"""Stop and reset: latch faults at the line arbiter, and clear them."""

from __future__ import annotations

from collections.abc import Callable

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.control import Answer
from end_effector_hal.control.goals import reset_answer
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import ArbiterError, WireError
from end_effector_hal.vocabulary import E_STOPPED, STOPPED, ChangerState

from ._goal_runner import CommandedProgram

RESET_S = 5.0
"""Longest wait for a reset of the tool changer, s; longer than the proof of a lock takes, which the reset needs."""
RENEWED_S = 2.0
"""Longest wait until the program learns that faults are cleared, s; several times the interval between lease renewals,
which carry the latched faults.
"""

STOP_LATCHED = (
    "The stop is latched: nothing is activated until a reset, a running grip is cancelled, and what is held stays "
    "held. This is no safety function."
)


def reset(description: Description, acknowledge: Callable[[], object], *others: Answer) -> Answer:
    """Clear the faults that the line arbiter has latched, and the alarms about a held part that are over.

    GRIP_ERROR and RELEASE_ERROR stay: they need a Drop, or after a loss a resume. A fault whose cause persists stays
    as well.

    Args:
        description: the tool.
        acknowledge: tells its program that a person has seen the alarms that are over.
        others: the answers of earlier resets: of the tool changer, because the line arbiter stores its sensor fault
            until that has been reset.
    """
    acknowledge()
    try:
        with ArbiterClient(socket_path(description), "reset", patience_s=0) as arbiter:
            stays = arbiter.reset()
        if all(answer.accepted for answer in others):  # who refused has said why
            others = (*others, *(Answer(False, why) for why in stays.values()))
    except WireError as error:
        others = (*others, Answer(False, str(error), decided=not isinstance(error, ArbiterError)))
    return reset_answer(others)


def reset_tool(description: Description, program: CommandedProgram) -> Answer:
    """Clear the fault of the tool changer, and all that `reset` clears; wait until the program knows it."""
    answers = []
    if program.status.changer_fault:
        changer = program.command("reset")
        program.wait(lambda status: status.changer != ChangerState.LOCKING, RESET_S)
        status = program.status
        fault = Answer(not status.changer_fault, status.changer_reason)
        answers.append(fault if changer.accepted else changer)
    answer = reset(description, program.acknowledge, *answers)
    if answer.accepted:
        # the line arbiter tells the program with its next renewal: until then it would refuse a grip
        program.wait(lambda status: not status.alarm(STOPPED, E_STOPPED), RENEWED_S)
    return answer


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
