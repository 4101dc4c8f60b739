"""The claimed output lines: their levels, the time of their last change, and whether they may be active.

`left_behind` finds lines that an earlier arbiter left active and that a new description lacks or gives another role.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from end_effector_hal.arbiter.rules._coils import Coils
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._session import ArbiterState, Write
from end_effector_hal.errors import WireError
from end_effector_hal.wires.lines import LineBackend, RemoteLines


class OutputLines:
    """Claims the lines and adopts their present levels.

    Args:
        backend: the lines; they are not claimed yet.
        policy: names of the lines, and the shortest time between two changes (IL-10).
        at: the time now, µs.
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
        """The back-end, if it has lines that a device writes later; None: it has none."""
        guesses = policy.opposites or self.remote
        self.coils = Coils(backend, policy.opposites, before_change) if guesses else None
        """All outputs, if some have two coils or may be unknown; None: each is one line whose level can be read."""
        self._backend = backend
        self.levels = (
            self.coils.request(policy.lines, believed, at) if self.coils else backend.request(policy.lines)
        )
        self.changed_at = dict.fromkeys(policy.lines, at)
        """Time of the last change of each line, µs."""
        self._changed: set[str] = set()
        """Lines written since the last call of `written`."""
        self._half_done: set[str] = set()
        """Lines that a failed activation may have activated: of several chips, one may have been written."""
        self._unsure = self.remote.unsure() if self.remote else frozenset[str]()
        self._renewed: set[str] = set()
        """Lines of devices that were activated since their last trouble."""
        self._commanded: set[str] = set()
        """Lines that were written since the start."""
        self.unbounded = set[str]()
        """Lines that were active at the start and whose role no record has: their activation has no time limit."""

    def set(self, levels: Mapping[str, bool], at: int, *, again: bool = False) -> None:
        """Write the lines whose level differs; with ``again`` also deactivations of inactive lines. Raises
        WireError.
        """
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
        self._commanded |= changes.keys()
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

    def release_again(self, line: str, given_at: int, at: int) -> None:
        """Deactivate a line that an earlier arbiter has deactivated at ``given_at``, and its device not."""
        if self.remote is not None:
            self.remote.prepare((), {}, {line: given_at})
        self.set({line: False}, at)
        self.changed_at[line] = min(given_at, at)
        self._changed.discard(line)

    def written(self, at: int) -> None:
        """Set the change time of the lines just written to ``at``: a write takes a moment, and IL-10 counts from its
        end.
        """
        if self._changed:
            self.changed_at |= dict.fromkeys(self._changed, at)
            self._changed.clear()

    def read(self) -> dict[str, bool]:
        """Return the levels, read back from the hardware where it can report them; guessed ones are left out.

        A line that was last inactive stays inactive while its level is unknown. Otherwise a program that starts could
        adopt it as active, because the sensors still show a part, and undo a release that its device has obeyed.
        """
        if self.coils is None:
            return self._backend.levels()
        guessed, found = self.coils.guessed, self.coils.read()
        self.levels |= {line: level for line, level in found.items() if line in guessed}
        inactive = (line for line, level in self.levels.items() if not level and line not in self._half_done)
        return dict.fromkeys(inactive, False) | found

    def hear(self, at: int) -> None:
        """Set the change time of lines that a device has confirmed by now to ``at``: pauses are counted from there.

        The longest time of an activation (IL-03) is counted from the command, whatever the device reports meanwhile.
        """
        if self.remote is None:
            return
        before, self._unsure = self._unsure, self.remote.unsure()
        timed = {line for line in self._policy.max_active_us if self.levels[line]}
        self.changed_at |= dict.fromkeys(before - self._unsure - timed, at)

    def may_be_active(self, line: str) -> bool:
        """Return whether a line is active or its state is unknown."""
        if line in self._half_done:
            return True
        return self.levels[line] or (self.remote is not None and line in self.remote.unsure())

    def active(self) -> frozenset[str]:
        """Return all these lines."""
        unsure = self.remote.unsure() if self.remote else frozenset[str]()
        return unsure.union(self._half_done, [line for line, level in self.levels.items() if level])

    def owed(self) -> frozenset[str]:
        """Return the lines whose deactivation was commanded, and which their device has not acknowledged."""
        return self.remote.owed() if self.remote else frozenset()

    def troubles(self) -> dict[str, str]:
        """Return the troubles of outputs that a device writes: sentences by the name of the fault.

        What was not written since the start has the fault `UNREAD`, which ends by itself.
        """
        if self.remote is None:
            return {}
        found = self.remote.troubles()
        self._renewed.difference_update(found)
        return {
            f"{OUTPUT if line in self._commanded else UNREAD} {line}": f"{self._policy.called(line)} {why}."
            for line, why in found.items()
        }

    def recovered(self) -> frozenset[str]:
        """Return the names of faults that are over: the line was activated again, and its device confirms it."""
        if self.remote is None:
            return frozenset()
        sure = self._renewed.difference(self.remote.unsure(), self._half_done)
        return frozenset(f"{OUTPUT} {line}" for line in sure)

    def last_ready_at(self, writes: Iterable[Write]) -> int:
        """Return the time at which the last of these writes can be applied if all are applied as early as possible,
        µs.
        """
        levels, changed_at, time = dict(self.levels), dict(self.changed_at), 0
        paused = {line: self.coils.ready_at(line) for line in levels} if self.coils else {}
        for due, wanted, again, _ in writes:
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

    @property
    def guessed(self) -> frozenset[str]:
        """The lines of unknown level; they count as active."""
        return self.coils.guessed if self.coils else frozenset()

    def longest_ends(self) -> dict[str, int]:
        """Return when each active line reaches its longest time (IL-03), µs; lines without a limit are left out."""
        if not (self._half_done or any(map(self.levels.get, self._policy.max_active_us))):
            return {}
        free = self.unbounded | self.guessed
        return {
            line: self.changed_at[line] + longest
            for line, longest in self._policy.max_active_us.items()
            if (self.levels[line] or line in self._half_done) and line not in free
        }


OUTPUT, UNREAD = "output", "unread"
"""Begin the names of faults of outputs on a bus: of one that was commanded; of one without a command that is not known,
because its bus cannot be read.
"""
DROP_FIRST = (
    "Drop first: restore the former description, start the line arbiter and the programs with it, Drop (or switch the "
    "output off), and end them. Then change the description. Until then no line is touched."
)
UNKNOWN_ROLES = (
    "No record says what the lines drove before the start, because {}: an unlock is refused until a reset. Look at the "
    "outputs before you reset."
)


def left_behind(state: ArbiterState, policy: Policy) -> str:
    """Return a sentence about lines that may be active in a role that the policy lacks; empty: there are none."""
    found = []
    for line, (role, active) in state.driven.items() if policy.roles else ():
        now = policy.roles.get(line)
        if active and (now is None or now.words != role):
            found.append(f"{line} was {role} and is {now.words if now else 'no output'} in this description")
    return (
        f"The description has changed while an output is, or may be, active: {'; '.join(found)}."
        if found
        else ""
    )
