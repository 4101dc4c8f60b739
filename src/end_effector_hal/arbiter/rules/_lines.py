"""The claimed output lines: their levels, since when each of them stands so, and whether one may be activated now."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from end_effector_hal.arbiter.rules._coils import Coils
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._session import Write
from end_effector_hal.errors import WireError
from end_effector_hal.wires.lines import LineBackend, RemoteLines


class OutputLines:
    """Claims the lines, and adopts the levels that they have.

    Args:
        backend: the lines, not claimed yet.
        policy: their names, and how long each stays as it is (IL-10).
        at: now, µs.
        before_change: called before lines are written.
        believed: levels that an earlier arbiter has recorded.
    """

    def __init__(
        self,
        backend: LineBackend,
        policy: Policy,
        at: int,
        before_change: Callable[[], None],
        believed: Mapping[str, bool],
    ) -> None:
        self._policy, self._before_change = policy, before_change
        self.remote = backend if isinstance(backend, RemoteLines) else None
        """Those that a device writes late; None: there are none."""
        guesses = policy.opposites or self.remote
        self.coils = Coils(backend, policy.opposites, before_change) if guesses else None
        """Outputs of two coils, with all others; None: each output is one line, whose level can be read."""
        self._backend = backend
        self.levels = (
            self.coils.request(policy.lines, believed, at) if self.coils else backend.request(policy.lines)
        )
        self.changed_at = dict.fromkeys(policy.lines, at)
        """The time of the last change of each line, µs."""
        self._changed: set[str] = set()
        """What was changed since it was last said when that was done."""
        self._half_done: set[str] = set()
        """What an activation that failed may have activated: of several chips, one may have been written."""
        self._unsure = self.remote.unsure() if self.remote else frozenset[str]()
        self._renewed: set[str] = set()
        """Lines of devices that were activated since they last had a trouble."""
        self.unbounded = set[str]()
        """Lines that were found active and of which no record says what they drive: no longest time ends them."""

    def set(self, levels: Mapping[str, bool], at: int, *, again: bool = False) -> None:
        """Write those that have another level, and ``again`` those that are inactive already; raises WireError."""
        changes = {
            line: level
            for line, level in levels.items()
            if self.levels[line] != level or line in self._half_done or (again and not level)
        }
        if self.coils:
            self.coils.decide(levels)
        if not changes:
            return
        self._before_change()
        try:
            if self.coils:
                # an activation that fails half way counts: in doubt something is held
                self.levels |= {
                    line: True for line, level in changes.items() if level and line in self._policy.opposites
                }
                self.coils.set(changes, at)
            else:
                self._backend.set(changes)
        except (WireError, OSError) as error:
            begun = {line for line, level in changes.items() if level}
            self._half_done |= begun
            self.changed_at |= dict.fromkeys(begun, at)
            if isinstance(error, WireError):
                raise
            raise WireError(f"the lines cannot be written: {error.strerror}.") from error
        self._half_done -= changes.keys()
        self.unbounded -= changes.keys()
        self.levels |= changes
        self.changed_at |= dict.fromkeys(changes, at)
        self._changed |= changes.keys()
        if self.remote is not None:
            self._unsure |= self.remote.unsure()
            self._renewed.difference_update(changes)
            self._renewed |= {line for line, level in changes.items() if level}

    def written(self, at: int) -> None:
        """What was changed just now is changed since ``at``: a write takes a moment, and IL-10 counts from its end."""
        if self._changed:
            self.changed_at |= dict.fromkeys(self._changed, at)
            self._changed.clear()

    def read(self) -> dict[str, bool]:
        """The levels, read back from the hardware where they stand there."""
        if self.coils is None:
            return self._backend.levels()
        guessed, found = self.coils.guessed, self.coils.read()
        self.levels |= {line: level for line, level in found.items() if line in guessed}
        return found

    def hear(self, at: int) -> None:
        """What a device has done by now, changed now: pauses are counted from there."""
        if self.remote is None:
            return
        before, self._unsure = self._unsure, self.remote.unsure()
        self.changed_at |= dict.fromkeys(before - self._unsure, at)

    def may_be_active(self, line: str) -> bool:
        """Whether it is active, or nobody knows how it stands."""
        if line in self._half_done:
            return True
        return self.levels[line] or (self.remote is not None and line in self.remote.unsure())

    def troubles(self) -> dict[str, str]:
        """What is wrong with outputs that are not written here, a sentence by the name of a fault."""
        if self.remote is None:
            return {}
        found = self.remote.troubles()
        self._renewed.difference_update(found)
        return {_fault(line): f"{self._policy.called(line)} {why}." for line, why in found.items()}

    def recovered(self) -> frozenset[str]:
        """Names of the faults that are over: their line was activated again, and its device confirms that."""
        if self.remote is None:
            return frozenset()
        return frozenset(map(_fault, self._renewed.difference(self.remote.unsure(), self._half_done)))

    def ready_at(self, write: Write) -> int:
        """The earliest time at which a write may be applied, µs."""
        return self.last_ready_at([write])

    def last_ready_at(self, writes: Iterable[Write]) -> int:
        """When the last of these writes can be applied, if each is applied as early as it may be, µs."""
        levels, changed_at, time = dict(self.levels), dict(self.changed_at), 0
        paused = {line: self.coils.ready_at(line) for line in levels} if self.coils else {}
        for due, wanted, again in writes:
            time, switched = max(time, due), []
            for line, level in wanted.items():
                if levels[line] != level or (again and not level):
                    settled_at = changed_at[line] + self._policy.min_switch_us
                    time = max(time, settled_at, paused.get(line, 0))
                    switched.append(line)
            for line in switched:
                levels[line], changed_at[line] = wanted[line], time
                if self.coils:
                    paused[line] = time + self._policy.settle_us(line)
        return time

    def longest_end(self, line: str) -> int | None:
        """When an active line has been active for its longest time (IL-03), µs; None: it is not active."""
        active = self.levels[line] or line in self._half_done
        if not active or line in self.unbounded or (self.coils and line in self.coils.guessed):
            return None
        return self.changed_at[line] + self._policy.max_active_us[line]


def _fault(line: str) -> str:
    return f"output {line}"
