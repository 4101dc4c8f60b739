"""The rules of the line owner, without sockets: time is an argument, in µs.

A client's writes are applied in the order in which they came. One that would change a line within
``min_switch_us`` of its last change waits, as a whole, and what the client writes after it waits behind it;
so do the steps of a will. An activation that waits is forgotten when its line is to be deactivated.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches

from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._predicates import SensorPredicates
from end_effector_hal.arbiter.rules._session import LastWillRunsError, Session, Write
from end_effector_hal.arbiter.rules._state import ArbiterState, SessionRecord
from end_effector_hal.errors import LineBusyError, LineRefusedError, UsageError, WireError
from end_effector_hal.vocabulary import LastWill, LastWillStep
from end_effector_hal.wires.lines import LineBackend

_log = logging.getLogger("end_effector_hal.arbiter")
MOST_WAITING = 64
DOUBT = "last wills"
"""The fault that is latched when the wills of an earlier owner are not executed."""


class LineArbiter:
    """Claims the lines, and applies what its clients may write.

    ``at`` must not decrease. After each call, `deadline` says when `expire` and `advance` are due.

    Args:
        backend: the lines, not claimed yet.
        policy: the lines by name, and their interlocks.
        at: now.
        memory: what an owner before this one has left.
        before_change: called before lines are written, so that its memory counts as outdated meanwhile.
    """

    def __init__(
        self,
        backend: LineBackend,
        policy: Policy,
        at: int,
        memory: ArbiterState | None = None,
        before_change: Callable[[], None] = lambda: None,
    ) -> None:
        memory = memory or ArbiterState()
        needs = [need for needs in policy.needs.values() for need in needs]
        self.policy = policy
        self.sensed = SensorPredicates(needs, policy.fresh_us, memory.faults, policy.faults)
        self.sessions: list[Session] = []
        self.trips: deque[tuple[int, str]] = deque(maxlen=100)
        self._dead: deque[tuple[str, str]] = deque(memory.dead, maxlen=100)
        self._backend, self._before_change = backend, before_change
        self.levels = backend.request(list(policy.lines))
        self._changed = dict.fromkeys(policy.lines, at)
        for line in policy.lines:
            if self.levels[line] and any(self.levels[partner.line] for partner in policy.partners(line)):
                _log.error("%s was found active together with a line that excludes it", policy.called(line))

        self._resume(memory, at)

    @property
    def memory(self) -> ArbiterState:
        """What the owner after this one must know."""
        clients = (
            SessionRecord(
                each.client, each.token, tuple(sorted(each.lines)), self._left(each), each.ended, each.pid
            )
            for each in self.sessions
        )
        faults, dead = dict(self.sensed.faults), tuple(self._dead)
        return ArbiterState(faults, tuple(clients), clean=False, levels=dict(self.levels), dead=dead)

    # What clients ask for

    def hello(
        self,
        client: str,
        token: str,
        lines: Sequence[str],
        will: LastWill,
        at: int,
        *,
        pid: int = 0,
        program: str = "",
    ) -> Session:
        """A client comes, to write these lines; one with the same name and token has come back.

        ``pid`` and ``program``, how its process was called, are for the sentences only.

        Raises:
            UsageError: there is no such line, or the will names another one.
            LastWillRunsError: the will of the one before is not over; say hello again after ``retry_us``.
            LineBusyError: another client writes one of them, or has the same name; says who.
        """
        self.advance(at)
        for line in lines:
            if line not in self.levels:
                close = get_close_matches(line, self.levels, n=1)
                hint = f" (did you mean {close[0]}?)" if close else ""
                raise UsageError(f"this owner has no line {line}{hint}; it has {', '.join(self.levels)}.")
        for other in [each for each in self.sessions if each.absent and not each.ended]:
            if (other.client, other.token) == (client, token):
                self.sessions.remove(other)
            elif other.client == client or other.lines.intersection(lines):
                self.dead(other, "it did not come back, another program did", at)
        for other in self.sessions:
            shared = other.lines.intersection(lines)
            if not shared and other.client != client:
                continue
            if other.ended:
                left = max(0, self._end(other) - at)
                raise LastWillRunsError(f"the will of {other.client} is being executed.", left)
            raise LineBusyError(
                f"{', '.join(sorted(shared)) or 'the name'} belongs to {other.client} ({other.process}).",
                todo="Stop that process: one program writes a line.",
            )
        session = Session(client, token, frozenset(lines), (), at + self.policy.lease_us, pid, program)
        self._bequeath(session, will)
        session.declared_dead = (client, token) in self._dead
        self._dead = deque((each for each in self._dead if each != (client, token)), maxlen=100)
        self.sessions.append(session)
        _log.info("%s (%s) writes %s", client, session.process, ", ".join(lines))
        return session

    def write(self, session: Session, levels: Mapping[str, bool], will: LastWill | None, at: int) -> int:
        """Set some lines at once, and leave a will (None: as before).

        Returns:
            µs until it is applied; 0: it is.

        Raises:
            LineRefusedError: an interlock refuses; nothing has changed.
            UsageError: not a line of this client.
            WireError: the hardware cannot be written.
        """
        self.advance(at)
        self.renew(session, at)
        self._own(session, levels)
        for line, level in levels.items():
            if level and not self._expected(session, line):
                self._check_activation(line, levels, at)
        if len(session.queue) >= MOST_WAITING:
            raise LineRefusedError(f"IL-10: {MOST_WAITING} writes wait already for their lines to settle.")
        if will is not None:
            self._bequeath(session, will)
        session.forget_activations(line for line, level in levels.items() if not level)
        session.queue.append(Write(at, dict(levels)))
        self._apply_due(session, at)
        return max(0, self._end(session) - at) if session.queue else 0

    def renew(self, session: Session, at: int) -> None:
        """The client lives."""
        session.lease_until = at + self.policy.lease_us

    def bye(self, session: Session, will: LastWill, at: int) -> None:
        """The client leaves in order; ``will`` is executed now, the one left before is void."""
        self._bequeath(session, will)
        _log.info("%s leaves%s", session.client, "" if will else ", its lines stay as they are")
        session.forget_activations(session.lines)
        self._end_session(session, will, at)

    def reset(self, at: int, still: Mapping[str, str] | None = None) -> None:
        """Clear latched faults and what was told of ended activations; ``still``: those that are the case now.

        Raises:
            LineRefusedError: some stay, for they still are the case; the others are cleared.
        """
        self.trips.clear()
        stay = self.sensed.reset(at)
        for name, why in (still or {}).items():
            self.sensed.latch(name, why)
            stay.append(why.rstrip("."))
        if stay:
            raise LineRefusedError(f"{'; '.join(stay)}: this fault stays.")

    # What happens

    def dead(self, session: Session, why: str, at: int) -> None:
        """The client died: nothing that waits is activated any more, its will is executed."""
        will = session.will
        _log.warning("%s died (%s); its will: %s", session.client, why, _told(will))
        session.forget_activations(session.lines)
        self._dead.append((session.client, session.token))
        self._end_session(session, will, at)

    def expire(self, at: int) -> list[Session]:
        """Ends the sessions whose lease is over, and returns them. Call it when every message was read."""
        over = [session for session in self.sessions if not session.ended and session.lease_until <= at]
        for session in over:
            self.dead(session, f"not heard of for {self.policy.lease_us} µs", at)
        return over

    def advance(self, at: int) -> None:
        """Does what is due: waiting writes, wills, and the ends of activations."""
        for session in list(self.sessions):
            try:
                self._apply_due(session, at)
            except WireError as error:
                _log.error("a write of %s failed: %s", session.client, error)
        self.sessions = [session for session in self.sessions if session.queue or not session.ended]
        for line in self.policy.max_active_us:
            if (end := self._trip_at(line)) is not None and end <= at:
                why = f"IL-03: {self.policy.called(line)} was active for its longest time and was ended."
                _log.warning("%s", why)
                self.trips.append((at, line))
                self.sensed.latch(f"IL-03 {line}", why)
                try:
                    self._set({line: False}, at)
                except WireError as error:
                    # Tried again one longest time later; a loop would starve the clients.
                    self._changed[line] = at
                    _log.error("%s stays active: %s", line, error)

    @property
    def deadline(self) -> int | None:
        """When the next thing is due, or None."""
        times = [session.lease_until for session in self.sessions if not session.ended]
        times += [self._ready(session.queue[0]) for session in self.sessions if session.queue]
        times += [end for line in self.policy.max_active_us if (end := self._trip_at(line)) is not None]
        return min(times, default=None)

    def _resume(self, memory: ArbiterState, at: int) -> None:
        """What an owner before this one knew; in doubt every client holds."""
        doubt = memory.doubt or self._differing(memory.levels)
        if doubt and any(self.levels.values()):
            _log.error("no last will of the owner before this one is executed: %s", doubt)
            self.sensed.latch(
                DOUBT, f"No last will was executed, because {doubt}: what was active stays active."
            )
        for bequest in memory.clients:
            self._come_back(bequest._replace(will=()) if doubt else bequest, at)

    def _differing(self, levels: Mapping[str, bool]) -> str:
        others = [
            self.policy.called(line)
            for line, level in levels.items()
            if self.levels.get(line, level) != level
        ]
        return f"{', '.join(others)} was changed while there was no line owner" if others else ""

    def _come_back(self, bequest: SessionRecord, at: int) -> None:
        """Lines that this owner has not are forgotten."""
        lines = frozenset(bequest.lines).intersection(self.levels)
        will = tuple(step for step in bequest.will if step.line in lines)
        session = Session(
            bequest.client, bequest.token, lines, will, at + self.policy.lease_us, bequest.pid, absent=True
        )
        self.sessions.append(session)
        if bequest.ended:
            _log.warning("the will of %s is executed anew: %s", session.client, _told(will))
            self._end_session(session, will, at)

    def _end_session(self, session: Session, will: LastWill, at: int) -> None:
        session.ended, session.will = True, will
        session.queue.extend(Write(at + step.after_us, {step.line: step.level}) for step in will)
        self.advance(at)

    def _left(self, session: Session) -> LastWill:
        """Its will; before that what it has asked to be deactivated and still waits for its line to settle."""
        if session.ended:
            return session.will
        waits = {line for write in session.queue for line in write.levels}
        return (
            tuple(LastWillStep(line) for line in sorted(waits) if not self._expected(session, line))
            + session.will
        )

    def _own(self, session: Session, levels: Mapping[str, object]) -> None:
        foreign = [line for line in levels if line not in session.lines]
        if foreign:
            raise UsageError(
                f"{session.client} does not write {', '.join(foreign)}: it was not in its hello."
            )

    def _bequeath(self, session: Session, will: LastWill) -> None:
        self._own(session, {step.line: False for step in will})
        self.policy.check_will(will)
        session.will = will

    def _check_activation(self, line: str, levels: Mapping[str, bool], at: int) -> None:
        called = self.policy.called
        for other, interlock, gap_us in self.policy.partners(line):
            if levels.get(other, self._may_be_active(other)):
                raise LineRefusedError(
                    f"{interlock}: {called(line)} is not activated while {called(other)} is active."
                )
            if at - self._changed[other] < gap_us:
                raise LineRefusedError(
                    f"{interlock}: {called(line)} is not activated within {gap_us // 1000} ms after "
                    f"{called(other)}."
                )
        for need in self.policy.needs.get(line, ()):
            if why := self.sensed.objection(need, at):
                raise LineRefusedError(f"{need.interlock}: {called(line)} is not activated: {why}.")

    def _expected(self, session: Session, line: str) -> bool:
        """The level once everything that waits is applied."""
        waiting = [write.levels[line] for write in session.queue if line in write.levels]
        return waiting[-1] if waiting else self.levels[line]

    def _may_be_active(self, line: str) -> bool:
        """Now, or at any time before everything that waits is applied."""
        return self.levels[line] or any(
            write.levels.get(line) for session in self.sessions for write in session.queue
        )

    def _trip_at(self, line: str) -> int | None:
        return self._changed[line] + self.policy.max_active_us[line] if self.levels[line] else None

    def _ready(self, write: Write) -> int:
        settle = self.policy.min_switch_us
        switched = [line for line, level in write.levels.items() if self.levels[line] != level]
        return max([write.due, *(self._changed[line] + settle for line in switched)])

    def _end(self, session: Session) -> int:
        """When the last of what waits is applied, if each is in time."""
        levels, changed, time = dict(self.levels), dict(self._changed), 0
        for due, wanted in session.queue:
            switched = {line: level for line, level in wanted.items() if levels[line] != level}
            time = max([time, due, *(changed[line] + self.policy.min_switch_us for line in switched)])
            levels |= switched
            changed |= dict.fromkeys(switched, time)
        return time

    def _apply_due(self, session: Session, at: int) -> None:
        while session.queue and self._ready(session.queue[0]) <= at:
            self._set(session.queue.popleft().levels, at)

    def _set(self, levels: Mapping[str, bool], at: int) -> None:
        changes = {line: level for line, level in levels.items() if self.levels[line] != level}
        if not changes:
            return
        self._before_change()
        try:
            self._backend.set(changes)
        except WireError:
            raise
        except OSError as error:
            raise WireError(f"the lines cannot be written: {error.strerror}.") from error
        self.levels |= changes
        self._changed |= dict.fromkeys(changes, at)


def _told(will: LastWill) -> str:
    return ", ".join(f"{step.line} off after {step.after_us} µs" for step in will) or "hold"
