"""The scenarios of the demo: the fault at the testbench, the commands, and the expected result.

The scenarios of the paper (Figs. 7 to 9) and those of ``make demo-all`` are made for any description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, ToolChanger
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import Command, EndEffectorState


@dataclass(frozen=True)
class Order:
    """One command to the end-effector, then a wait.

    ``wait_s``: seconds before the next order; ``background``: counted from the command, not from its outcome; ``arm``:
    the unlock is armed first (IL-02).
    """

    command: Command
    wait_s: float = 0.0
    background: bool = False
    arm: bool = False


@dataclass(frozen=True)
class Expected:
    """The expected story, in the terms of a recording.

    Args:
        states: states of the end-effector, from STAND_BY on, without repetitions.
        commands: values of the command column, without NONE and repetitions.
        attempts: number of attempts of each actuator; a missing one is never activated.
        timeouts: number of its attempts that time out.
        slow_release: the actuator whose feedback stays for its whole release time.
    """

    states: tuple[EndEffectorState, ...]
    commands: tuple[Command, ...]
    attempts: Mapping[str, int] = field(default_factory=dict)
    timeouts: Mapping[str, int] = field(default_factory=dict)
    slow_release: str | None = None


@dataclass(frozen=True)
class DemoScenario:
    """A scenario; ``bench`` is the scenario of ``eehal testbench``, ``figure`` that of the paper, if any."""

    name: str
    title: str
    bench: str
    orders: tuple[Order, ...]
    expected: Expected
    figure: str = ""
    rest_s: float = 0.5
    """Time recorded before the first order, s."""

    @property
    def script(self) -> str:
        """The orders as a script for the Supervisor."""
        steps = [f"wait {self.rest_s:g}"]
        for order in self.orders:
            steps += ["arm"] if order.arm else []
            steps.append(order.command.name.lower() + (" &" if order.background else ""))
            steps += [f"wait {order.wait_s:g}"] if order.wait_s else []
        return "; ".join([*steps, "quit"])

    def longest_s(self, description: Description) -> float:
        """Return the longest duration, s: the waits, and the bounds that the description requires."""
        longest = description.durations
        waits = self.rest_s + sum(order.wait_s for order in self.orders)
        return waits + (longest.grip_ms + longest.release_ms + longest.cancel_ms) / 1000


UNLOCK_LOCK = "unlock-lock"
HOLD_S = 2.0
REST_S = 0.5
"""Time for which the final state is recorded, s."""
UNLOCKED_S = 1.0
TRAVEL_S = 0.4
"""Upper limit for the travel time of a tool changer with its valve, s."""

State = EndEffectorState
_LOCK = Order(Command.LOCK, REST_S)
_GRIP = Order(Command.GRIP, HOLD_S)
_DROP = Order(Command.RELEASE, REST_S)
_GRIP_AND_DROP = (Command.GRIP, Command.RELEASE)
_HELD = (State.STAND_BY, State.GRIPPING, State.GRIPPED, State.RELEASING)


def culprit_of(description: Description) -> str:
    """Return the actuator that fails in the demo: the first moving one after the first step, else the second step."""
    later = description.ordered[1:] or description.ordered
    return next((name for name, actuator in later if kind_of(actuator).moves), later[0][0])


def scenarios(description: Description, *, everything: bool = False) -> tuple[DemoScenario, ...]:
    """Return the three scenarios of the paper; with ``everything`` also a cancel, a failing release, and unlock and
    lock.
    """
    paper = (_nominal(description), _fails_once(description), _never_confirms(description))
    if not everything:
        return paper
    more = (_cancelled(description), _stuck_release(description))
    changer = description.tool_changer
    if changer is None or UNLOCK_LOCK in unplayable(description):
        return (*paper, *more)
    return (*paper, *more, _unlock_and_lock(description, changer))


def unplayable(description: Description) -> dict[str, str]:
    """Return the scenarios that the codec makes impossible, with the reason as a sentence."""
    changer, carrier = description.tool_changer, carrier_of(description)
    bits = {"locked_bit": changer.locked_bit, "unlocked_bit": changer.unlocked_bit} if changer else {}
    if missing := [key for key, bit in bits.items() if bit not in carrier.channels]:
        return {
            UNLOCK_LOCK: f"{carrier.name} carries no {' and no '.join(missing)}, so that no unlock is accepted."
        }
    return {}


def _gripping(
    description: Description,
    name: str,
    title: str,
    bench: str,
    orders: tuple[Order, ...],
    expected: Expected,
    figure: str = "",
) -> DemoScenario:
    """Return a scenario that begins with a lock if there is a tool changer."""
    if description.tool_changer:
        orders = (_LOCK, *orders)
        expected = replace(expected, commands=(Command.LOCK, *expected.commands))
    return DemoScenario(name, title, bench, orders, expected, figure)


def _nominal(description: Description) -> DemoScenario:
    told = Expected((*_HELD, State.STAND_BY), _GRIP_AND_DROP, dict.fromkeys(description.sequence, 1))
    return _gripping(description, "nominal", "grip, hold, drop", "nominal", (_GRIP, _DROP), told, "Fig. 7")


def _fails_once(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    # what stays active between its attempts is not activated a second time, which is what the testbench waits for
    recovers = description.actuators[culprit].attempts > 1 and not _stays_on(description, culprit)
    attempts = dict.fromkeys(description.sequence, 1) | {culprit: 2}
    recovered = Expected((*_HELD, State.STAND_BY), _GRIP_AND_DROP, attempts, {culprit: 1})
    return _gripping(
        description,
        "fails-once",
        f"{culprit} fails once and recovers",
        f"fails-once:{culprit}",
        (_GRIP, _DROP) if recovers else (_GRIP,),
        recovered if recovers else _aborted(description, culprit),
        "Fig. 8",
    )


def _never_confirms(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    grip, told = Order(Command.GRIP, REST_S), _aborted(description, culprit)
    bench = f"never-confirms:{culprit}"
    return _gripping(
        description, "never-confirms", f"{culprit} never confirms", bench, (grip,), told, "Fig. 9"
    )


def _stays_on(description: Description, culprit: str) -> bool:
    return description.endings_of(culprit).gripping.timeout != "release"


def _unwound(description: Description, culprit: str, ending: str) -> tuple[State, ...]:
    """Return the states after a cancel or an abort while one actuator is pending: actuators declared to hold stay
    active.
    """
    engaged = [*_before(description, culprit), culprit]
    holds = [getattr(description.endings_of(name).gripping, ending) == "hold" for name in engaged]
    if all(holds):
        return (State.GRIP_ERROR,)
    return (State.RELEASING, State.GRIP_ERROR if any(holds) else State.STAND_BY)


def _aborted(description: Description, culprit: str) -> Expected:
    # a recording shows the attempts of what is switched; what stays active has one
    attempts = 1 if _stays_on(description, culprit) else description.actuators[culprit].attempts
    after = _unwound(description, culprit, "abort")
    failed = () if after[0] is State.GRIP_ERROR else (State.GRIP_ERROR,)
    return Expected(
        (State.STAND_BY, State.GRIPPING, *failed, *after),
        _GRIP_AND_DROP,
        _before(description, culprit) | {culprit: attempts},
        {culprit: attempts},
    )


def _cancelled(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    title, bench = f"cancelled while {culprit} is pending", f"never-confirms:{culprit}"
    middle_s = min(3.0, 0.6 * description.actuators[culprit].timeout_s)
    orders = (Order(Command.GRIP, middle_s, background=True), Order(Command.CANCEL, REST_S))
    states = (State.STAND_BY, State.GRIPPING, *_unwound(description, culprit, "cancel"))
    attempts = _before(description, culprit) | {culprit: 1}
    told = Expected(states, (Command.GRIP, Command.CANCEL), attempts)
    return _gripping(description, "cancel", title, bench, orders, told)


def _stuck_release(description: Description) -> DemoScenario:
    culprit = culprit_of(description)
    title, bench = f"{culprit} does not release", f"stuck-release:{culprit}"
    attempts = dict.fromkeys(description.sequence, 1)
    told = Expected((*_HELD, State.RELEASE_ERROR), _GRIP_AND_DROP, attempts, slow_release=culprit)
    orders = (Order(Command.GRIP, REST_S), _DROP)
    return _gripping(description, "stuck-release", title, bench, orders, told)


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
    """Return how long the tool stays unlocked, s: less than IL-03 leaves after a slow link has confirmed it."""
    shown_s = TRAVEL_S + changer.proven_s + 2 * carrier_of(description).period_us / 1e6
    left_s = 2 * UNLOCKED_S if changer.latching else changer.unlock_max_s - shown_s
    return min(UNLOCKED_S, max(0.0, left_s / 2))


def _before(description: Description, culprit: str) -> dict[str, int]:
    """Return one attempt for every actuator before the culprit."""
    return dict.fromkeys(description.sequence[: description.sequence.index(culprit)], 1)
