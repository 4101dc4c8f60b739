"""The rules of the line arbiter, without sockets; time is an argument, in µs.

Writes of a client are applied in the order of their arrival. If a write would change a line within ``min_switch_us``
of the line's last change, the whole write waits, and later writes of that client wait behind it. The steps of a last
will wait in the same way, and so do changes within the pause after a pulse. A waiting activation is discarded when its
line is to be deactivated.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import attrgetter, itemgetter
from typing import NoReturn

from end_effector_hal.arbiter.protocol import LastWillRunsError
from end_effector_hal.arbiter.rules._interlocks import LineInterlocks
from end_effector_hal.arbiter.rules._lines import DROP_FIRST, UNREAD, OutputLines, left_behind
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._predicates import STOP, SensorPredicates
from end_effector_hal.arbiter.rules._session import ArbiterState, DrivenLine, Session, SessionRecord, Write
from end_effector_hal.errors import LineBusyError, LineRefusedError, UsageError, WireError
from end_effector_hal.vocabulary import NO_PART, LastWill, WrittenPart, hint
from end_effector_hal.wires.lines import LineBackend, RemoteLines

_log = logging.getLogger("end_effector_hal.arbiter")
MOST_WAITING = 64
"""Most waiting writes of one client."""
LONGEST_PULSE_US = 2_000_000
"""Longest time for which an arbiter that ends waits for a pulse after the lease of its clients is over, µs."""
RETRY_US = 100_000
"""Time between two tries of a deactivation that the hardware refuses, µs."""
DOUBT = "last wills"
"""Name of the fault that is latched when the last wills of an earlier arbiter are not executed."""
LET_GO = "let go"
"""Name of the fault that is latched when a line went inactive while no arbiter ran."""


class LineArbiter:
    """Claims the lines and applies the writes of its clients as far as the policy allows them.

    ``at`` must not decrease. After each call, `deadline` is the time at which `expire` and `advance` are due.

    Args:
        backend: the lines; they are not claimed yet.
        policy: the names of the lines, and their interlocks.
        at: the time now.
        state: the state of the previous arbiter.
        before_change: called before lines are written, so that the session record counts as outdated meanwhile.

    Raises:
        UsageError: a line that may be active is missing in the policy, or has another role there; no line was claimed.
        WireError: the lines cannot be claimed.
    """

    def __init__(
        self,
        backend: LineBackend,
        policy: Policy,
        at: int,
        state: ArbiterState | None = None,
        before_change: Callable[[], None] = lambda: None,
    ) -> None:
        state = state or ArbiterState()
        needs = [need for needs in policy.needs.values() for need in needs]
        if forgotten := left_behind(state, policy):
            raise UsageError(forgotten, todo=DROP_FIRST)
        self.policy = policy
        self.predicates = SensorPredicates(needs, policy.fresh_us, state.faults, policy.faults, policy.proven)
        self.sessions: list[Session] = []
        self.trips: deque[tuple[int, str]] = deque(maxlen=100)
        self.part = state.part
        """Name of the part that was gripped last; empty: none, or it has no name."""
        self._stays: dict[str, str] = {}  # faults of lines that the hardware does not deactivate
        self._dead: deque[tuple[str, str]] = deque(state.dead, maxlen=100)
        self._lines = OutputLines(backend, policy, at, before_change, state.pulsed)
        self._interlocks = LineInterlocks(policy, self._lines, self.predicates)
        for line in self._interlocks.broken():
            _log.error("%s was found active together with a line that excludes it", policy.called(line))
        self._resume(state, at)
        self._bound(state, at)

    @property
    def levels(self) -> dict[str, bool]:
        """Levels of all lines as last written; True is active."""
        return self._lines.levels

    def read_levels(self) -> dict[str, bool]:
        """Return the levels of all lines, read back from the hardware where it can report them."""
        return self._lines.read()

    @property
    def may_be_active(self) -> list[str]:
        """The lines that are active or whose state is unknown."""
        active = self._lines.active()
        return [line for line in self.policy.lines if line in active]

    @property
    def pulses(self) -> bool:
        """Whether a pulse is active."""
        return self._lines.coils is not None and self._lines.coils.due is not None

    def end_pulses(self, at: int | None = None) -> None:
        """End the pulses that are over at ``at``; None: end all, because no coil may stay active without an arbiter."""
        if self._lines.coils is None:
            return
        try:
            if at is None:
                self._lines.coils.cut()
            else:
                self._lines.coils.advance(at)
        except (WireError, OSError) as error:
            _log.error("a pulse does not end: %s", error)

    @property
    def state(self) -> ArbiterState:
        """The state that the next arbiter needs."""
        lines = self._lines
        owed, active, levels = lines.owed(), lines.active(), lines.levels
        return ArbiterState(
            faults=self.predicates.faults.copy(),
            clients=tuple([each.record for each in self.sessions]),
            clean=False,
            levels={line: level for line, level in levels.items() if line not in owed},
            dead=tuple(self._dead),
            pulsed=lines.coils.pulsed if lines.coils else {},
            driven={line: DrivenLine(role.words, line in active) for line, role in self.policy.roles.items()},
            since={line: lines.changed_at[line] for line in self.policy.max_active_us if levels[line]},
            owed=dict(sorted(((line, lines.changed_at[line]) for line in owed), key=itemgetter(1, 0))),
            part=self.part,
        )

    # Requests of clients

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
        faults: Mapping[str, str] | None = None,
    ) -> Session:
        """Open a session for a client that writes these lines; the same name and token continue its earlier session.

        ``pid`` and ``program`` (the command line of its process) appear only in messages. ``faults`` are the faults
        that the client has latched and not cleared, sentences by name; None: those of its previous session.

        Raises:
            UsageError: a line does not exist, or the last will names a line that the client does not write.
            LastWillRunsError: the last will of the previous client is being executed; try again after ``retry_us``.
            LineBusyError: another client writes one of the lines or has the same name (the message names it), or its
                last will cannot be executed.
        """
        self.advance(at)
        for line in lines:
            if line not in self.levels:
                known = ", ".join(self.levels)
                raise UsageError(f"this arbiter has no line {line}{hint(line, self.levels)}; it has {known}.")
        latched = set[str]()
        for other in [each for each in self.sessions if each.absent and not each.ended]:
            if (other.client, other.token) == (client, token):
                self.sessions.remove(other)
                latched = other.faults
            elif other.client == client or other.lines.intersection(lines):
                self.declare_dead(other, "it did not connect again, but another program did", at)
        for other in self.sessions:
            shared = other.lines.intersection(lines)
            if not shared and other.client != client:
                continue
            if other.ended and other.stuck:
                raise LineBusyError(
                    f"the last will of {other.client} cannot be executed: {other.stuck}",
                    todo="Look at the outputs, their supply and their chip.",
                )
            if other.ended:
                left = max(0, self._lines.last_ready_at(other.queue) - at)
                raise LastWillRunsError(f"the last will of {other.client} is being executed.", left)
            raise LineBusyError(
                f"{', '.join(sorted(shared)) or 'the name'} belongs to {other.client} ({other.process}).",
                todo="Stop that process: only one program writes a line.",
            )
        session = Session(client, token, frozenset(lines), (), at + self.policy.lease_us, pid, program)
        self._set_last_will(session, will)
        session.declared_dead = (client, token) in self._dead
        self._dead = deque((each for each in self._dead if each != (client, token)), maxlen=100)
        self.sessions.append(session)
        self._take_over(session, latched, faults)
        _log.info("%s (%s) writes %s", client, session.process, ", ".join(lines))
        return session

    def write(
        self,
        session: Session,
        levels: Mapping[str, bool],
        will: LastWill | None,
        at: int,
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> int:
        """Write some lines at once, and leave a last will (None: keep the previous one). Without levels only the last
        will changes.

        ``drop`` means that a person asked for the deactivations. They are written even to lines that are inactive, and
        the device of a remote line may be acknowledged and activated first, unless an interlock refuses an activation.
        ``part`` is the part that is gripped; without a name: as before.

        Returns:
            µs until this write and all before it are applied; 0: they are applied.

        Raises:
            LineRefusedError: an interlock refuses; nothing has changed.
            UsageError: a line does not belong to this client.
            WireError: the hardware cannot be written.
        """
        self.advance(at)
        session.lease_until = at + self.policy.lease_us
        if not session.lines.issuperset(levels):
            _refuse_foreign(session, levels)
        if part.values:
            self._check_values(levels, part)
        if session.stuck and any(levels.values()):
            raise LineRefusedError(f"IL-11: nothing is activated while a deactivation fails: {session.stuck}")
        for line, level in levels.items():
            now = self._lines.levels[line]
            if level and not (session.queued_level(line, now=now) if session.queue else now):
                self._interlocks.check(line, levels, self.sessions, at)
        if levels and len(session.queue) >= MOST_WAITING:
            raise LineRefusedError(
                f"IL-10: too many pending writes (at most {MOST_WAITING} of a client): they wait for their lines to "
                "settle. Send fewer, or wait."
            )
        self.part = part.name or self.part
        if will is not None:
            self._set_last_will(session, will)
        if session.queue:
            session.forget_activations([line for line, level in levels.items() if not level])
        if levels:
            session.queue.append(Write(at, dict(levels), drop, part.values))
            self._apply_due(session, at)
        return max(0, self._lines.last_ready_at(session.queue) - at) if session.queue else 0

    def renew(self, session: Session, at: int) -> None:
        """Restart the client's lease."""
        session.lease_until = at + self.policy.lease_us

    def bye(self, session: Session, will: LastWill, at: int) -> None:
        """End the session in order: execute ``will`` now; the client's earlier last will is void."""
        self._set_last_will(session, will)
        _log.info("%s leaves%s", session.client, "" if will else ", its lines stay as they are")
        self._end_session(session, will, "its program has left", at)

    def stop(self, who: str) -> None:
        """Latch a stop, as an open e-stop does (IL-13): nothing is activated until a reset, and no line changes.

        Args:
            who: the process that requested it, for the message.
        """
        self.predicates.latch(
            STOP, f"IL-13: the tool was stopped ({who}): nothing is activated until a reset."
        )

    def latch(self, session: Session, name: str, why: str) -> None:
        """Keep a fault that a client has found until the client clears it; after the client's end a reset clears it.

        Raises:
            UsageError: the policy lists no fault of this name.
        """
        self.predicates.check_client_fault(name)
        self.predicates.latch(name, why)
        session.faults.add(name)

    def clear(self, session: Session, name: str) -> None:
        """End a fault after the client's reset, if the client has latched it or the policy assigns it to the client."""
        if name not in session.faults and self.policy.faults.get(name) != session.client:
            return
        session.faults.discard(name)
        if not any(name in each.faults for each in self.sessions if not each.ended):
            self.predicates.faults.pop(name, None)

    def reset(self, at: int, still: Mapping[str, str] | None = None) -> dict[str, str]:
        """Clear the latched faults and the list of ended activations; ``still``: faults that persist now.

        A fault of a live client that has not cleared it stays. Such faults are returned, a sentence by name.

        Raises:
            LineRefusedError: the cause of some faults persists, and they stay; the others are cleared.
        """
        self.trips.clear()
        self._lines.unbounded.clear()
        if self._lines.remote is not None:
            self._lines.remote.acknowledge()
        of_clients = self._latched_by()
        stay = self.predicates.reset(at, of_clients)
        for name, why in {**(still or {}), **self._lines.troubles(), **self._stays}.items():
            self.predicates.latch(name, why)
            stay.append(why.rstrip("."))
        if stay:
            raise LineRefusedError(f"{'; '.join(stay)}: this fault stays.")
        return {
            name: f"{client} has latched {name}, and has not been reset."
            for name, client in of_clients.items()
        }

    # Events

    def declare_dead(self, session: Session, why: str, at: int) -> None:
        """Discard the waiting activations of a client that has died, and execute its last will."""
        will = session.will
        self._dead.append((session.client, session.token))
        self._end_session(session, will, "its program has died", at)
        _log.warning("%s died (%s); its last will: %s", session.client, why, _in_words(will))  # not before it

    def expire(self, at: int) -> list[Session]:
        """End the sessions with an expired lease, and return them. Call this after all messages were handled."""
        over = [session for session in self.sessions if not session.ended and session.lease_until <= at]
        for session in over:
            self.declare_dead(session, f"it did not renew its lease for {self.policy.lease_us} µs", at)
        return over

    def written(self, at: int) -> None:
        """Record ``at`` µs as the completion time of all writes since the last call."""
        self._lines.written(at)

    def advance(self, at: int) -> None:
        """Execute the actions that are due: waiting writes, last wills, and the ends of activations."""
        if self._lines.remote is not None:
            self._hear_devices(self._lines.remote, at)
        if self._lines.coils is not None:
            self.end_pulses(at)  # first: a pause begins there
        for session in self.sessions.copy():
            try:
                if session.queue:
                    self._apply_due(session, at)
            except WireError as error:
                _log.error("a write of %s failed: %s", session.client, error)
            if session.ended and not session.queue:
                self.sessions.remove(session)
        if self._lines.remote is not None:
            self._note_troubles()
        if self._lines.unbounded:
            self._say_unbounded()
        if self.policy.max_active_us:
            for line, end in self._lines.longest_ends().items():
                if end <= at:
                    self._end_activation(line, at)

    def _note_troubles(self) -> None:
        """Latch the troubles of the outputs that a device writes, and end those that are over."""
        faults, found = self.predicates.faults, self._lines.troubles()
        for name, why in found.items():
            if name not in faults:
                _log.error("%s", why)
            self.predicates.latch(name, why)
        read = {name for name in faults if name.startswith(f"{UNREAD} ")} - found.keys()
        for name in read | (self._lines.recovered() & faults.keys()):
            _log.info("fault over, the output was activated or read again: %s", faults.pop(name))

    def may_end(self, asked_at: int, at: int) -> bool:
        """Return whether an arbiter that was asked to end at ``asked_at`` has nothing left to wait for.

        A system shutdown ends the clients shortly after the arbiter's signal. So the arbiter waits, for the time of a
        lease, for clients that have left a last will. Last wills are executed to their end, except one that cannot be
        executed: that is left to the next arbiter. A pulse is completed.
        """
        patient_until = asked_at + self.policy.lease_us
        if self.pulses and at < patient_until + LONGEST_PULSE_US:
            return False
        dying = at < patient_until
        return not any(
            (session.ended and not session.stuck) or (dying and (session.ended or session.will))
            for session in self.sessions
        )

    @property
    def deadline(self) -> int | None:
        """The time of the next action, µs; None: nothing is due."""
        times = [session.lease_until for session in self.sessions if not session.ended]
        times += [self._lines.last_ready_at([session.queue[0]]) for session in self.sessions if session.queue]
        times += self._lines.longest_ends().values()
        if self._lines.coils and (due := self._lines.coils.due) is not None:
            times.append(due)
        return min(times, default=None)

    def _hear_devices(self, devices: RemoteLines, at: int) -> None:
        """Process the news of the devices; cancel a pending activation if an interlock refuses it now."""
        self._lines.hear(at)
        for line in devices.activating():
            for interlock, why in self._interlocks.objections(line, at):
                devices.withdraw((line,), f"{interlock}: {why}")

    def _take_over(self, session: Session, before: set[str], faults: Mapping[str, str] | None) -> None:
        """Match the latched faults to those that a reconnecting client reports; it has cleared the others."""
        session.faults = before
        if faults is None:
            return
        for name in before - faults.keys():
            self.clear(session, name)
        for name in self.predicates.client_faults & faults.keys():
            self.latch(session, name, faults[name])

    def _latched_by(self) -> dict[str, str]:
        """Return the live clients, by the latched faults that they have latched or that the policy assigns to them.

        The policy counts because a journal may be read late, after the client has connected.
        """
        living = [each for each in self.sessions if not each.ended]
        names = {each.client for each in living}
        theirs = {name: client for name, client in self.policy.faults.items() if client in names}
        theirs |= {name: each.client for each in living for name in each.faults}
        return {name: client for name, client in theirs.items() if name in self.predicates.faults}

    def _resume(self, state: ArbiterState, at: int) -> None:
        """Continue the sessions of the previous arbiter; in doubt no last will is executed."""
        doubt = state.doubt or self._changed_meanwhile(state.levels)
        guessed = self._lines.guessed
        active = {line for line, level in self.levels.items() if level}
        off = self.levels.keys() - active - guessed
        if doubt and (active - guessed or (active and state.clients)):
            _log.error("no last will of the arbiter before this one is executed: %s", doubt)
            self.predicates.latch(
                DOUBT, f"No last will was executed, because {doubt}: what was active stays active."
            )
        if gone := [
            self.policy.called(line) for line, level in state.levels.items() if level and line in off
        ]:
            let_go = (
                f"{', '.join(gone)} went inactive while no line arbiter ran: what it held has been let go."
            )
            _log.error("%s", let_go)
            self.predicates.latch(LET_GO, let_go)
        if not doubt:
            self._release_again(state.owed, at)
        for record in state.clients:
            self._restore(record._replace(will=()) if doubt else record, at)

    def _release_again(self, owed: Mapping[str, int], at: int) -> None:
        """Command the deactivations that no device had acknowledged when the previous arbiter ended, in that order."""
        if lines := [line for line in owed if self.levels.get(line)]:  # the others are released by now
            called = ", ".join(map(self.policy.called, lines))
            _log.warning("deactivated again, because no device had acknowledged it: %s", called)
            for line in lines:
                self._lines.release_again(line, owed[line], at)

    def _bound(self, state: ArbiterState, at: int) -> None:
        """Continue the longest times (IL-03) from the record; if the record lacks the start time, the longest time is
        over.

        If no record has the role of an active line, its activation is not ended before a reset: the line may hold a
        part.
        """
        for line, longest in self.policy.max_active_us.items() if self.policy.roles else ():
            if not self.levels[line]:
                continue
            if line in state.driven:
                since = state.since.get(line, at + 1)
                self._lines.changed_at[line] = since if since <= at else at - longest
                continue
            self._lines.unbounded.add(line)
            self._lines.changed_at[line] = at - longest
        self._say_unbounded()

    def _say_unbounded(self) -> None:
        """Latch a fault for each active line without a time limit; a guessed line counts once its level is
        confirmed.
        """
        for line in self._lines.unbounded - self._lines.guessed:
            interlock, called = self.policy.bounded_by(line), self.policy.called(line)
            self.predicates.latch(
                f"{interlock} {line}",
                f"{interlock}: {called} was active at the start, and no record says what it drove: it stays active "
                "until a reset, which deactivates it.",
            )

    def _changed_meanwhile(self, levels: Mapping[str, bool]) -> str:
        others = [
            self.policy.called(line)
            for line, level in levels.items()
            if self.levels.get(line, level) != level and line not in self._lines.guessed
        ]
        return f"{', '.join(others)} was changed while no line arbiter ran" if others else ""

    def _restore(self, record: SessionRecord, at: int) -> None:
        """Restore a recorded session, without lines that this arbiter does not have."""
        lines = frozenset(record.lines).intersection(self.levels)
        will = tuple(step for step in record.will if step.line in lines)
        session = Session(
            record.client, record.token, lines, will, at + self.policy.lease_us, record.pid, absent=True,
            faults=set(record.faults) & self.predicates.faults.keys(),
        )  # fmt: skip
        self.sessions.append(session)
        if record.ended:
            _log.warning("the last will of %s is executed again: %s", session.client, _in_words(will))
            self._end_session(session, will, "its program has ended", at)

    def _end_session(self, session: Session, will: LastWill, why: str, at: int) -> None:
        session.forget_activations(session.lines)
        if self._lines.remote is not None:
            self._lines.remote.withdraw(session.lines, why)
        if self.policy.release_us:
            will = self._after_releases(session, will)
        session.ended, session.will = True, will
        session.queue.extend([Write(at + step.after_us, {step.line: step.level}) for step in will])
        self.advance(at)

    def _after_releases(self, session: Session, will: LastWill) -> LastWill:
        """Return a last will whose steps wait for the releases that no device has acknowledged yet.

        Where such a release is a step of the will itself, the next steps wait for it already. Lines with a longest
        time, a blow-off or the unlock, hold nothing: they wait for nothing.
        """
        owed, begins = self._lines.owed() & session.lines, {step.line: step.after_us for step in will}
        at_once = owed | self.policy.max_active_us.keys()
        first_us = next((step.after_us for step in will if step.line not in at_once), 0)
        waits = (
            self.policy.release_us.get(line, 0) - max(0, first_us - begins.get(line, 0)) for line in owed
        )
        wait_us = max([0, *waits])
        steps = [
            step if step.line in at_once else step._replace(after_us=step.after_us + wait_us) for step in will
        ]
        return tuple(sorted(steps, key=attrgetter("after_us")))

    def _end_activation(self, line: str, at: int) -> None:
        interlock = self.policy.bounded_by(line)
        fault, ended = (
            f"{interlock} {line}",
            f"{interlock}: {self.policy.called(line)} was active for its longest time",
        )
        again = fault in self._stays
        try:
            self._lines.set({line: False}, at)
        except WireError as error:
            why = self._stays[fault] = f"{ended} and cannot be deactivated: {error} It is tried again."
            self._lines.changed_at[line] = at - self.policy.max_active_us[line] + RETRY_US
        else:
            self._stays.pop(fault, None)
            told = "is being deactivated, until its device acknowledges it"
            why = f"{ended} and {told if line in self._lines.owed() else 'was deactivated'}."
        if not again:
            self.trips.append((at, line))
            self.predicates.latch(fault, why)
        if again is not (fault in self._stays) or not again:
            _log.warning("%s", why)

    def _apply_due(self, session: Session, at: int) -> None:
        """Apply the due writes of a session. A failed deactivation is tried again; a failed activation is not.

        Raises:
            WireError: an activation failed; deactivations of the same write are tried again later.
        """
        while session.queue and self._lines.last_ready_at([session.queue[0]]) <= at:
            write = session.queue.popleft()
            try:
                if (write.drop or write.values) and self._lines.remote is not None:
                    lines = [line for line, level in write.levels.items() if write.drop and not level]
                    drops = [each for each in lines if not any(self._interlocks.objections(each, at))]
                    self._lines.remote.prepare(drops, write.values, {})
                self._lines.set(write.levels, at, again=write.drop)
                session.stuck = ""
            except WireError as error:
                if off := {line: level for line, level in write.levels.items() if not level}:
                    self._try_again(session, Write(at + RETRY_US, off, write.drop), error)
                if len(off) < len(write.levels):
                    raise

    def _check_values(self, levels: Mapping[str, bool], part: WrittenPart) -> None:
        """Raise UsageError if registers are given for a line that is not activated, or has another number of them."""
        for line, values in part.values.items():
            number = self.policy.registers.get(line, 0)
            if not levels.get(line):
                raise UsageError(f"The write gives values for {line} and does not activate it.")
            if len(values) != number:
                raise UsageError(f"{line} takes {number} values, and the write gives {len(values)}.")

    def _try_again(self, session: Session, write: Write, error: WireError) -> None:
        """Queue a failed deactivation again, before all later writes, and discard the waiting activations.

        The order of an unwinding is that of the description, so nothing may happen before it. Activations are
        discarded because their interlocks were checked when they were written, not when the hardware works again.
        """
        session.forget_activations(session.lines)
        session.queue.appendleft(write)
        off = write.levels
        lines = ", ".join(self.policy.called(line) for line in off)
        behind = sorted({line for write in list(session.queue)[1:] for line in write.levels} - off.keys())
        waits = f" {', '.join(map(self.policy.called, behind))} waits for it." if behind else ""
        name, why = f"output {lines}", f"{lines} cannot be deactivated: {error} It is tried again.{waits}"
        session.stuck = why
        if name not in self.predicates.faults:
            _log.error("%s", why)
        self.predicates.latch(name, why)

    def _set_last_will(self, session: Session, will: LastWill) -> None:
        longest_us = self.policy.longest_last_will_us
        for line, _, after_us in will:
            if line not in session.lines:
                _refuse_foreign(session, [step.line for step in will])
            if after_us > longest_us:
                raise UsageError(
                    f"the last will deactivates {line} {after_us} µs after the death; "
                    f"the longest last will of this tool takes {longest_us} µs."
                )
        session.will = will


def _refuse_foreign(session: Session, lines: Iterable[str]) -> NoReturn:
    foreign = ", ".join(line for line in lines if line not in session.lines)
    raise UsageError(f"{session.client} does not write {foreign}: its hello did not name this line.")


def _in_words(will: LastWill) -> str:
    return ", ".join(f"{step.line} off after {step.after_us} µs" for step in will) or "hold"
