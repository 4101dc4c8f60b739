"""Guards the tool against plug-in kinds: none of their exceptions or wrong values ends the program.

Rule 1: A plug-in object that judges frames (a detector, a watch) and fails proves nothing: its evidence is UNKNOWN,
its grip not secure. A new object replaces it and is trusted once it has proven something.

Rule 2: The first failure of each object is reported until the program restarts: a defect does not disappear.

Rule 3: Values on which the tool is built (ranges, names of channels, outputs) are queried once; a failure is one
sentence.

Rule 4: Values that are only displayed are omitted on failure: a margin is NaN, a sentence is the default one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import islice
from math import isfinite
from typing import Any, ClassVar, TypeVar

from end_effector_hal.kinds.stanza import Actuator, EvidenceConditions, Hold, Output, Supply
from end_effector_hal.plugins import LONGEST, PluginError, attempt
from end_effector_hal.signals import NESTED, ChannelReadings, Kind, clone, memory_of
from end_effector_hal.vocabulary import LEAK, WEAK, Alarm, Evidence

from ._kind import DeviceKind
from ._parts import (
    Detector,
    HoldFinding,
    HoldWatch,
    JointRule,
    PressureRange,
    Quote,
    Travel,
)

MOST_SAID = 16
"""Largest number of findings or phrases that one call may return."""
_DECLARED = (
    "name", "stanza", "channels", "states", "orders", "joint_rules", "opposing", "samples", "below_ambient",
    "margin_from", "moves", "empty",
)  # fmt: skip
T = TypeVar("T")


class _Judge:
    """Calls a plug-in object, and replaces it after a failure.

    Attributes:
        fault: a sentence about the first failure; empty: there was none.
    """

    MEMORY: ClassVar[dict[str, Any]] = {"_asked": NESTED, "fault": str}

    def __init__(self, maker: str, make: Callable[[], Any]) -> None:
        self._maker, self._make = maker, make
        self._asked: tuple[Any, ...] = ()
        self.fault = ""
        self._renew()

    def _ask(self, what: str, question: Callable[[Any], T], otherwise: T) -> T:
        if not self._asked:
            self._renew()
        if not self._asked:
            return otherwise
        (asked,) = self._asked
        try:
            answer = attempt(f"{_class(asked)}.{what}", lambda: question(asked))
            # what cannot be recorded cannot be copied either
            attempt(f"{_class(asked)}.MEMORY", lambda: memory_of(asked))
        except PluginError as error:
            self.fault = self.fault or error.what
            self._renew()
            return otherwise
        return answer

    def _renew(self) -> None:
        self._asked = ()
        try:
            new = attempt(self._maker, self._made)
        except PluginError as error:
            self.fault = self.fault or error.what
        else:
            self._asked = () if new is None else (new,)

    def _made(self) -> Any:
        new = self._make()
        if new is not None:
            memory_of(clone(new))
        return new


class GuardedDetector(_Judge):
    """A wrapper of a plug-in detector that always returns an evidence."""

    MEMORY: ClassVar[dict[str, Any]] = {**_Judge.MEMORY, "_believed": bool}

    def __init__(self, maker: str, make: Callable[[], Detector]) -> None:
        self._believed = True
        super().__init__(maker, make)

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """Return the evidence; UNKNOWN if the plug-in fails."""

        def sampled(detector: Detector) -> Evidence:
            level = detector.sample(readings, at)
            return _of_type(level, Evidence)

        level = self._ask("sample()", sampled, Evidence.UNKNOWN)
        # a new one begins to count: what it has not proven yet is no loss
        self._believed = self._believed or level in (Evidence.CONFIRMED, Evidence.GONE)
        return level if self._believed else Evidence.UNKNOWN

    def _renew(self) -> None:
        super()._renew()
        self._believed = not self.fault


class GuardedWatch(_Judge):
    """A wrapper of a plug-in watch over a held part that returns valid findings, or none."""

    MEMORY: ClassVar[dict[str, Any]] = {**_Judge.MEMORY, "secure": bool}

    def __init__(self, maker: str, make: Callable[[], HoldWatch | None]) -> None:
        self.secure = False
        super().__init__(maker, make)

    @property
    def watches(self) -> bool:
        """Whether there is a watch, or there would be one if it had not failed."""
        return bool(self._asked or self.fault)

    def sample(self, readings: ChannelReadings, at: int, *, held: bool) -> None:
        """Pass the newest readings to the watch."""

        def sampled(watch: HoldWatch) -> bool:
            watch.sample(readings, at, held=held)
            return _of_type(watch.secure, bool)

        self.secure = self._ask("sample()", sampled, False)

    def findings(self, since: int, at: int) -> list[HoldFinding]:
        """Return the findings of the watch, as far as they are valid."""

        def found(watch: HoldWatch) -> list[HoldFinding]:
            return [_finding(each) for each in islice(watch.findings(since, at), MOST_SAID)]

        return self._ask("findings()", found, [])

    def dropped(self) -> None:
        """Notify the watch that nothing is held any more."""

        def dropped(watch: HoldWatch) -> bool:
            watch.dropped()
            return True

        self._ask("dropped()", dropped, True)


class GuardedKind(DeviceKind[Any]):
    """A wrapper of a plug-in kind: its declarations are fixed, and its methods raise only PluginError."""

    def __init__(self, kind: DeviceKind[Any]) -> None:
        vars(self).update({key: getattr(kind, key) for key in _DECLARED})
        vars(self)["joint_rules"] = tuple(
            JointRule(tuple(rule.keys), self._rule(rule)) for rule in kind.joint_rules
        )
        self._kind = kind
        self.fault = ""
        """A sentence about the first failure of a margin; empty: there was none."""
        self._known: dict[tuple[str, int], tuple[Actuator, Any]] = {}

    def preset(self, actuator: Any) -> EvidenceConditions | None:
        """Return the checked conditions of the plug-in."""

        def checked(conditions: EvidenceConditions | None) -> EvidenceConditions | None:
            return conditions if conditions is None else _of_type(conditions, EvidenceConditions)

        return self._once("preset()", actuator, lambda: checked(self._kind.preset(actuator)))

    def can_confirm(self, actuator: Any, carried: Mapping[str, Kind]) -> bool:
        """Return whether any of the carried channels could confirm the actuator."""
        return attempt(
            self._name("can_confirm()"), lambda: _of_type(self._kind.can_confirm(actuator, carried), bool)
        )

    def detector(self, actuator: Any, supply: Supply) -> Detector:
        """Return a new detector, with a guard if the plug-in defines its own."""
        if type(self._kind).detector is DeviceKind.detector:
            return super().detector(actuator, supply)
        return GuardedDetector(self._name("detector()"), lambda: self._kind.detector(actuator, supply))

    def hold_watch(self, actuator: Any, hold: Hold, period_us: int) -> GuardedWatch | None:
        """Return a new guarded watch; None: the kind has none."""
        watch = GuardedWatch(
            self._name("hold_watch()"), lambda: self._kind.hold_watch(actuator, hold, period_us)
        )
        return watch if watch.watches else None

    def plausible(self, actuator: Any) -> PressureRange:
        """Return the checked pressure range of the plug-in."""

        def checked(span: object) -> PressureRange:
            found = _of_type(span, PressureRange)
            _line(found.what)
            return PressureRange(_number(found.low), _number(found.high), found.what)

        return self._once("plausible()", actuator, lambda: checked(self._kind.plausible(actuator)))

    def margin_pa(self, actuator: Any, gauge_pa: float, supply_pa: float) -> float:
        """Return the margin, Pa; NaN if the plug-in fails."""
        try:
            return attempt(
                self._name("margin_pa()"), lambda: float(self._kind.margin_pa(actuator, gauge_pa, supply_pa))
            )
        except PluginError as error:
            self.fault = self.fault or error.what
            return float("nan")

    def lost(self, actuator: Any, readings: ChannelReadings, at: int) -> str:
        """Return the plug-in's phrase about the loss; the default phrase if the plug-in fails."""
        try:
            return attempt(self._name("lost()"), lambda: _line(self._kind.lost(actuator, readings, at)))
        except PluginError as error:
            return f"{super().lost(actuator, readings, at)} ({error.what.rstrip('.')})"

    def not_fitted(self, actuator: Any, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield the checked phrases of the plug-in."""
        yield from attempt(
            self._name("not_fitted()"),
            lambda: [_line(each) for each in islice(self._kind.not_fitted(actuator, carried), MOST_SAID)],
        )

    def limits(self, actuator: Any, supply: Supply) -> dict[str, float]:
        """Return the checked thresholds of the plug-in."""
        return attempt(
            self._name("limits()"),
            lambda: {
                _line(name): _number(each) for name, each in self._kind.limits(actuator, supply).items()
            },
        )

    def travel(self, actuator: Any) -> Travel | None:
        """Return the checked joint of the plug-in."""

        def checked(travel: Travel | None) -> Travel | None:
            if travel is None:
                return None
            joint, upper = travel
            if joint not in ("prismatic", "revolute") or not _number(upper) > 0:
                raise ValueError(f"{joint!r} or {upper!r} is no travel")
            return Travel(joint, upper)

        return self._once("travel()", actuator, lambda: checked(self._kind.travel(actuator)))

    def channel_names(self, actuator: Any) -> tuple[str, ...]:
        """Return the checked names of the actuator's channels."""
        return self._once("channel_names()", actuator, lambda: _names(self._kind.channel_names(actuator)))

    def proofs(self, actuator: Any) -> tuple[str, ...]:
        """Return the checked names of the channels that confirm."""
        return self._once("proofs()", actuator, lambda: _names(self._kind.proofs(actuator)))

    def opposing_output(self, actuator: Any) -> Any:
        """Return the checked stanza of the opposing output."""

        def checked(output: Any) -> Any:
            if output is not None:
                if not isinstance(output, Output):
                    raise TypeError(f"{_class(output)} is no Output")
                _line(output.line), _number(getattr(output, "gap_s", None))
            return output

        return self._once(
            "opposing_output()", actuator, lambda: checked(self._kind.opposing_output(actuator))
        )

    def _name(self, what: str) -> str:
        return f"{_class(self._kind)}.{what}"

    def _rule(self, rule: JointRule) -> Callable[[str, Mapping[str, float], Quote], tuple[str, str] | None]:
        def fault(name: str, numbers: Mapping[str, float], quote: Quote) -> tuple[str, str] | None:
            def asked() -> tuple[str, str] | None:
                found = rule.fault(name, numbers, quote)
                return found and (_line(found[0]), _line(found[1]))

            return attempt(self._name("joint_rules"), asked)

        return fault

    def _once(self, what: str, actuator: Actuator, question: Callable[[], T]) -> T:
        """Return the plug-in's answer for a part.

        The plug-in is asked only once, so that a restart gets the same answer as the start.
        """
        key = what, id(actuator)
        if key not in self._known:
            self._known[key] = actuator, attempt(self._name(what), question)
        found: T = self._known[key][1]
        return found


def is_guarded(judge: object) -> bool:
    """Return whether a detector or a watch comes from a plug-in."""
    return isinstance(judge, _Judge)


def fault_of(thing: object) -> str:
    """Return a sentence about the first failure of a plug-in's object or kind; empty: there was none."""
    return thing.fault if isinstance(thing, _Judge | GuardedKind) else ""


def _class(thing: object) -> str:
    return type(thing).__qualname__


def _of_type(value: Any, kind: type[T]) -> T:
    if type(value) is not kind:
        raise TypeError(f"{_class(value)} is no {kind.__name__}")
    found: T = value
    return found


def _line(text: Any) -> str:
    if not text or not _of_type(text, str).isprintable():
        raise ValueError("a text that is not one line")
    return str(text[:LONGEST])


def _names(names: Any) -> tuple[str, ...]:
    return tuple(_of_type(name, str) for name in names)


def _number(value: Any) -> float:
    if type(value) not in (int, float) or not isfinite(value):
        raise ValueError("something that is no number")
    number: float = value
    return number


def _finding(found: Any) -> HoldFinding:
    id_, values, over = found
    if id_ not in (WEAK, LEAK):
        raise ValueError("a finding that is neither WEAK nor LEAK")
    items = [(_of_type(name, str), values[name]) for name in islice(values, MOST_SAID)]
    checked = {name: _line(each) if isinstance(each, str) else _number(each) for name, each in items}
    _line(Alarm(id_, "", checked, over=_of_type(over, bool)).text)
    return HoldFinding(id_, checked, over)
