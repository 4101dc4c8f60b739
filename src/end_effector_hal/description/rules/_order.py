"""Rules of order: thresholds and times that only make sense if one is below the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from end_effector_hal.description._fault import Fault, Keys
from end_effector_hal.description._numbers import number
from end_effector_hal.description._shape import Facts
from end_effector_hal.kinds import JointRule, Pair, get_kind

SUPPLY: tuple[Pair, ...] = (("refuse_kpa", "<", "warn_kpa"), ("warn_kpa", "<", "nominal_kpa"))
LINK: tuple[Pair, ...] = (("stale_s", "<", "down_s"), ("stale_periods", "<", "down_periods"))
CHANGER: tuple[Pair, ...] = (("proven_s", "<", "prove_s"),)


def order_faults(facts: Facts) -> Iterator[Fault]:
    """Yield a fault for every pair of numbers in the wrong order."""
    yield from _pairs(facts, ("supply",), SUPPLY)
    yield from _pairs(facts, ("link",), LINK)
    if isinstance(facts.get("tool_changer"), dict):
        yield from _pairs(facts, ("tool_changer",), CHANGER)
    for name, kind in facts.actuators():
        yield from _pairs(facts, ("actuators", name), get_kind(kind).orders)
        for rule in get_kind(kind).joint_rules:
            yield from _joint(facts, name, rule)
    yield from _supply_returns(facts)


def _pairs(facts: Facts, stanza: Keys, pairs: tuple[Pair, ...]) -> Iterator[Fault]:
    for low, relation, high in pairs:
        less, more = facts.get(*stanza, low), facts.get(*stanza, high)
        if less is None or more is None or less < more or (relation == "<=" and less == more):
            continue
        # The one that is written is at fault; of two, the one that ought to be the higher.
        if facts.written(*stanza, high):
            key, size, words, other = high, "small", "more than" if relation == "<" else "at least", low
        else:
            key, size, words, other = low, "large", "less than" if relation == "<" else "at most", high
        expected = f"{words} {_quote(facts, *stanza, other)}"
        yield facts.fault((*stanza, key), "EE-222", f"{key!r} is too {size}", expected)


def _joint(facts: Facts, name: str, rule: JointRule) -> Iterator[Fault]:
    paths: dict[str, Keys] = {
        key: ("supply", key.removeprefix("supply."))
        if key.startswith("supply.")
        else ("actuators", name, key)
        for key in rule.keys
    }
    numbers = {key: facts.get(*path) for key, path in paths.items()}
    if None in numbers.values():
        return
    if found := rule.fault(name, numbers, lambda key: _quote(facts, *paths[key])):
        yield _of_several(facts, list(paths.values()), *found)


def _supply_returns(facts: Facts) -> Iterator[Fault]:
    """Check that after a refusal the nominal pressure is enough to grip again."""
    keys = ("hysteresis_kpa", "refuse_kpa", "nominal_kpa", "warn_kpa")
    paths = [("supply", key) for key in keys]
    hysteresis, refuse, nominal, warn = (facts.get(*path) for path in paths)
    # If the three are not in order anyhow, that is the fault.
    if None in (hysteresis, refuse, nominal, warn) or not refuse < warn < nominal:
        return
    if nominal <= refuse + hysteresis:
        expected = (
            f"refuse_kpa + hysteresis_kpa = {number(refuse + hysteresis)} below {_quote(facts, *paths[2])}"
        )
        yield _of_several(facts, paths, "a grip, once refused, would never be granted again", expected)


def _of_several(facts: Facts, paths: Sequence[Keys], what: str, expected: str) -> Fault:
    """Return a fault of several numbers together, at the place of the first one that is written."""
    path = next((each for each in paths if facts.written(*each)), paths[0])
    place = facts.places.value(*path)
    return Fault.at(place, "EE-222", what, found=f"{path[-1]}: {place.text}", expected=expected)


def _quote(facts: Facts, *path: str | int) -> str:
    default = "" if facts.written(*path) else " (default)"
    return f"{path[-1]} = {number(facts.get(*path))}{default}"
