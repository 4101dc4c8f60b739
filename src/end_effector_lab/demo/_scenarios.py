"""The scenarios of the paper (Figs. 7 to 9) and those of ``make demo-all``, for any description."""

from __future__ import annotations

from end_effector_hal.codecs import codec_of
from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, ToolChanger
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import Command, EndEffectorState

from ._scenario import DemoScenario, Expected, Order

UNLOCK_LOCK = "unlock-lock"
HOLD_S = 2.0
REST_S = 0.5
"""What a recording shows of the state that it ends in."""
UNLOCKED_S = 1.0
TRAVEL_S = 0.4
"""A tool changer, with its valve, takes less."""

State = EndEffectorState
_LOCK = Order(Command.LOCK, REST_S)
_GRIP = Order(Command.GRIP, HOLD_S)
_DROP = Order(Command.RELEASE, REST_S)
_HELD = (State.STAND_BY, State.GRIPPING, State.GRIPPED, State.RELEASING)


def culprit_of(description: Description) -> str:
    """The actuator that fails in the demo: the first that moves after the first step, else the second step."""
    later = description.ordered[1:] or description.ordered
    return next((name for name, actuator in later if kind_of(actuator).moves), later[0][0])


def scenarios(description: Description, *, everything: bool = False) -> tuple[DemoScenario, ...]:
    """The three of the paper; with ``everything`` also a cancel, a failing release, and unlock and lock."""
    paper = (_nominal(description), _fails_once(description), _never_confirms(description))
    if not everything:
        return paper
    more = (_cancelled(description), _stuck_release(description))
    changer = description.tool_changer
    if changer is None or UNLOCK_LOCK in unplayable(description):
        return (*paper, *more)
    return (*paper, *more, _unlock_and_lock(description, changer))


def unplayable(description: Description) -> dict[str, str]:
    """Scenarios that the tool would have, but for its codec: name, and why in a sentence."""
    changer, carried = description.tool_changer, codec_of(description).channels
    bits = {"locked_bit": changer.locked_bit, "unlocked_bit": changer.unlocked_bit} if changer else {}
    if missing := [key for key, bit in bits.items() if bit not in carried]:
        codec = description.link.codec
        return {UNLOCK_LOCK: f"{codec} carries no {' and no '.join(missing)}, so that no unlock is accepted."}
    return {}


def _nominal(description: Description) -> DemoScenario:
    return DemoScenario(
        name="nominal",
        title="grip, hold, drop",
        bench="nominal",
        orders=(*_first(description), _GRIP, _DROP),
        expected=Expected(
            (*_HELD, State.STAND_BY),
            _commands(description, Command.GRIP, Command.RELEASE),
            dict.fromkeys(description.sequence, 1),
        ),
        figure="Fig. 7",
    )


def _fails_once(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    # what stays active between its attempts is not activated a second time, which is what the testbench waits for
    recovers = description.actuators[culprit].attempts > 1 and not _stays_on(description, culprit)
    recovered = Expected(
        (*_HELD, State.STAND_BY),
        _commands(description, Command.GRIP, Command.RELEASE),
        dict.fromkeys(description.sequence, 1) | {culprit: 2},
        {culprit: 1},
    )
    return DemoScenario(
        name="fails-once",
        title=f"{culprit} fails once and recovers",
        bench=f"fails-once:{culprit}",
        orders=(*_first(description), _GRIP, *((_DROP,) if recovers else ())),
        expected=recovered if recovers else _aborted(description, culprit),
        figure="Fig. 8",
    )


def _never_confirms(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    return DemoScenario(
        name="never-confirms",
        title=f"{culprit} never confirms",
        bench=f"never-confirms:{culprit}",
        orders=(*_first(description), Order(Command.GRIP, REST_S)),
        expected=_aborted(description, culprit),
        figure="Fig. 9",
    )


def _stays_on(description: Description, culprit: str) -> bool:
    return description.endings_of(culprit).gripping.timeout != "release"


def _unwound(description: Description, culprit: str, ending: str) -> tuple[State, ...]:
    """What a cancel or an abort comes to, while one actuator is pending: what is declared to hold stays active."""
    engaged = [*_before(description, culprit), culprit]
    holds = [getattr(description.endings_of(name).gripping, ending) == "hold" for name in engaged]
    if all(holds):
        return (State.GRIP_ERROR,)
    return (State.RELEASING, State.GRIP_ERROR if any(holds) else State.STAND_BY)


def _aborted(description: Description, culprit: str) -> Expected:
    # a recording shows the attempts of what is switched; what stays active has one
    attempts = 1 if _stays_on(description, culprit) else description.actuators[culprit].attempts
    after = _unwound(description, culprit, "abort")
    return Expected(
        (
            State.STAND_BY,
            State.GRIPPING,
            *(() if after[0] is State.GRIP_ERROR else (State.GRIP_ERROR,)),
            *after,
        ),
        _commands(description, Command.GRIP, Command.RELEASE),
        _before(description, culprit) | {culprit: attempts},
        {culprit: attempts},
    )


def _cancelled(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    shown, after = (Command.GRIP, Command.CANCEL), _unwound(description, culprit, "cancel")
    middle_s = min(3.0, 0.6 * description.actuators[culprit].timeout_s)
    grip = Order(Command.GRIP, middle_s, background=True)
    return DemoScenario(
        name="cancel",
        title=f"cancelled while {culprit} is pending",
        bench=f"never-confirms:{culprit}",
        orders=(*_first(description), grip, Order(Command.CANCEL, REST_S)),
        expected=Expected(
            (State.STAND_BY, State.GRIPPING, *after),
            _commands(description, *shown),
            _before(description, culprit) | {culprit: 1},
        ),
    )


def _stuck_release(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    return DemoScenario(
        name="stuck-release",
        title=f"{culprit} does not release",
        bench=f"stuck-release:{culprit}",
        orders=(*_first(description), Order(Command.GRIP, REST_S), _DROP),
        expected=Expected(
            (*_HELD, State.RELEASE_ERROR),
            _commands(description, Command.GRIP, Command.RELEASE),
            dict.fromkeys(description.sequence, 1),
            slow_release=culprit,
        ),
    )


def _unlock_and_lock(description: Description, changer: ToolChanger) -> DemoScenario:
    constants = model_constants(description)
    arm = bool(constants["IL_02"]) and not constants["STAND"]
    return DemoScenario(
        name=UNLOCK_LOCK,
        title="armed, unlock and lock" if arm else "unlock and lock",
        bench="nominal",
        orders=(Order(Command.UNLOCK, _unlocked_s(description, changer), arm=arm), _LOCK),
        rest_s=2 * REST_S,  # the cups have to be seen vented for half a second first (IL-01)
        expected=Expected((State.STAND_BY,), (Command.UNLOCK, Command.LOCK)),
    )


def _unlocked_s(description: Description, changer: ToolChanger) -> float:
    """How long it stays unlocked: less than IL-03 leaves once a slow link has proven it."""
    shown_s = TRAVEL_S + changer.proven_s + 2 * codec_of(description).period_us / 1e6
    left_s = 2 * UNLOCKED_S if changer.latching else changer.unlock_max_s - shown_s
    return min(UNLOCKED_S, max(0.0, left_s / 2))


def _first(description: Description) -> tuple[Order, ...]:
    return (_LOCK,) if description.tool_changer else ()


def _commands(description: Description, *commands: Command) -> tuple[Command, ...]:
    return (Command.LOCK, *commands) if description.tool_changer else commands


def _before(description: Description, culprit: str) -> dict[str, int]:
    """One attempt of everything before the culprit."""
    return dict.fromkeys(description.sequence[: description.sequence.index(culprit)], 1)
