"""A whole tool in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from random import Random
from typing import TYPE_CHECKING, Any

from end_effector_hal.arbiter import HAL, PredicatePublisher, client_lines
from end_effector_hal.control import Answer, Controller, Status, unknown_now
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, UsageError, WireError
from end_effector_hal.runtime import InlineWorker, Program, longest_release_s, release_is_decided
from end_effector_hal.runtime.boundary import NULL_RECORDER, Recorder
from end_effector_hal.sensing import stays
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Evidence
from end_effector_lab.testbench import Bench, Models, SensorBoard, chosen_models
from timed_automata import Network
from timed_automata.execute import Observation

from ._arbiter import Edge, VirtualOutputs
from ._arbiter_lives import ArbiterLives
from ._connection import VirtualConnection
from ._sources import Leap, Source, StreamedLink, arbiter_source, sources_of_bench

if TYPE_CHECKING:
    from ._bus import VirtualBus

ARBITER = "arbiter"
PROCESSES = (ARBITER, HAL)
Watch = Callable[[], Callable[[Observation], None]]
"""Called for each new controller; returns a receiver of its observations."""
_TRIES_US = 200_000
STARTED_US = 5_000_000
LONGEST_LOOK_US = 250_000
"""Longest time between two looks at the tool, µs, even without frames."""


class Watching(Recorder):
    """A recorder that stores nothing, and passes the observations of every controller to a `Watch`."""

    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self._watch = watch

    def controller(self, description: Description, network: Network) -> Controller:
        """Return a controller that is observed from its start."""
        return Controller(description, network, observe=self._watch())


class VirtualTool:
    """The program, the line arbiter with its records, the sensors and the testbench, in one thread, without
    a real clock.

    The product itself runs: its program, controller and detectors, the rules and records of the arbiter, its codecs.
    Only sockets, threads and their delays are left out: messages arrive at the same instant. The same seed, scenario
    and commands give the same run, to the microsecond.

    Events at one instant are processed in this order: frames, the program, its lease, the arbiter.

    Args:
        description: the description of the tool.
        scenario: the fault, in the words of the testbench.
        seed: seed of the valves, the noise, and the random faults.
        levels: lines that are active at the start; their parts have settled.
        watch: follows the automata, for example with a `Monitor`.
        on_frame: called with each frame before the program receives it; default: frames that would change nothing are
            left out.
        models: units that have a model; the others are played from the description; default: those of `chosen_models`.

    Attributes:
        at: time since the start, µs.
        bench: the real state of the simulated devices.
        memories: the stores that outlive the arbiter; its disk can be made to fail.
        statuses: the published statuses, in order.
        edges: edges of the output lines, in order.

    Raises:
        UsageError: the tool cannot be played in virtual time, or the scenario cannot be used.
    """

    def __init__(
        self,
        description: Description,
        scenario: str = "nominal",
        *,
        seed: int = 0,
        levels: Mapping[str, bool] | None = None,
        watch: Watch | None = None,
        on_frame: Callable[[Frame], None] | None = None,
        models: Models | None = None,
    ) -> None:
        self.description, self.at = description, 0
        self.statuses: list[Status] = []
        self.edges: list[Edge] = []
        self._recorder = Watching(watch) if watch else NULL_RECORDER
        self._on_frame = on_frame
        self._random = Random(seed)
        self.bench = Bench(description, scenario, seed, levels=levels)
        self._outputs = VirtualOutputs(description.wired_lines, levels or {}, self._now, self._edge)
        self._on_bus = {name: (levels or {}).get(name, False) for name in description.register_outputs}
        chosen = chosen_models(None, description) if models is None else models
        self._boards = {
            name: SensorBoard(description, self.bench, 0, name, self._obey, chosen)
            for name in description.buses
        }
        for board in self._boards.values():
            board.begin(self._on_bus, 0)
        self._sources = list(sources_of_bench(description, self.bench, 0))
        self._own = arbiter_source(description, self.bench, 0)
        reads = self._own is not None
        self._arbiters = ArbiterLives(
            description, self._outputs, self._boards, self._obey, self._now, reads=reads
        )
        self.memories = self._arbiters.memories
        self._leap = self._leap_of(self._sources) if on_frame is None else None
        self._program: Program | None = None
        self._connection: VirtualConnection | None = None
        self._starts_at: int | None = None
        self._newest: Frame | None = None
        for name in PROCESSES:
            self.start(name)
        self.run_until(STARTED_US, lambda: len(self.living) == len(PROCESSES))  # at once without a bus

    @property
    def status(self) -> Status:
        """The status that the program has published last; of a dead program, what is still known."""
        status = replace(self.statuses[-1], at=self.at)
        return status if self._program is not None else unknown_now(status)

    @property
    def levels(self) -> dict[str, bool]:
        """The levels of all output lines."""
        return self._outputs.levels() | self._on_bus

    @property
    def living(self) -> frozenset[str]:
        """The running processes of ``arbiter`` and ``hal``."""
        there = self._arbiters.now, self._program
        return frozenset(name for name, each in zip(PROCESSES, there, strict=True) if each is not None)

    @property
    def arbiters(self) -> int:
        """Number of line arbiters started so far."""
        return self._arbiters.begun

    @property
    def ending(self) -> bool:
        """Whether the arbiter was asked to end and still waits."""
        return self._arbiters.now is not None and self._arbiters.now.ends

    @property
    def latched(self) -> dict[str, str]:
        """The latched faults of the arbiter: sentences by name."""
        return dict(self._arbiters.now.rules.predicates.faults) if self._arbiters.now else {}

    def command(self, name: str, look: Callable[[], object] = lambda: None, part: str = "") -> Answer:
        """Give ``grip``, ``drop``, ``cancel``, ``resume``, ``lock``, ``unlock``, ``arm`` or ``reset`` (of the changer).

        An unlock waits for the proof that nothing is gripped, as in the product; meanwhile time advances, and ``look``
        is called at each instant. ``part`` is the part that is to be gripped; empty: the default one.
        """
        if (program := self._program) is None:
            return Answer(False, "The program is not running.", decided=False)
        if name == "unlock" and self.description.tool_changer:
            limit = self.at + round(longest_release_s(self.description.tool_changer) * 1e6)

            def decided() -> bool:
                look()
                return release_is_decided(program.status)

            self.run_until(limit, decided)
        return program.command(name, part)

    def reset(self) -> Answer:
        """Clear the latched faults of the arbiter, and ended alarms about a held part."""
        if self._program is not None:
            self._program.acknowledge()
        try:
            if self._arbiters.now is None:
                return Answer(False, "There is no line arbiter.", decided=False)
            stays = self._arbiters.now.reset()
        except ReportedError as error:
            return Answer(False, str(error))
        return Answer(not stays, " ".join(stays.values()))

    def choose(self, scenario: str) -> None:
        """Select another scenario from now on; raises UsageError if it cannot be used."""
        self.bench.choose(scenario, self.at)
        if self._leap:
            self._leap.forget()

    def run(self, seconds: float) -> None:
        """Advance time."""
        self.run_until(self.at + round(seconds * 1e6))

    def run_until(self, at: int, over: Callable[[], bool] = lambda: False) -> bool:
        """Advance time to ``at`` (µs), or until ``over`` returns True; return whether it did."""
        while not over():
            if self.at >= at:
                return False
            waits = self._waiting()
            if self._leap:
                self._leave_out(self._leap, min([at, *(due for due, _ in waits)]), at)
            waits = self._bringing() + waits
            self.at = max(self.at, min([at, *(due for due, _ in waits)]))
            for due, happens in waits:
                if due <= self.at:
                    happens()
            self._arbiters.look()
        return True

    # Births and deaths

    def kill(self, name: str) -> None:
        """Kill ``arbiter`` or ``hal`` (the program with the sensor reader) now."""
        if self._is_arbiter(name):
            self._arbiters.kill()
        else:
            self._starts_at = None
            self._abandon()

    def end(self, name: str) -> None:
        """End the same processes properly, as after SIGTERM; a held part is treated as declared.

        The arbiter ends when it waits for no last will and no pulse; a second call ends it at once.
        """
        if self._is_arbiter(name):
            self._arbiters.end()
            return
        if self._program is not None:
            with suppress(WireError):  # then the arbiter executes its last will
                self._program.leave()
        self._abandon()

    def start(self, name: str) -> None:
        """Start a process that does not run; a program without an arbiter or its lines tries again every 0.2 s."""
        if self._is_arbiter(name):
            self._arbiters.start()
        elif self._program is None:
            self._start_program()

    def lose_power(self) -> None:
        """Cut the power: all processes die, and every line becomes inactive; `start` starts the machine again."""
        self._program = self._connection = self._starts_at = None
        self._arbiters.lose_power()

    def _is_arbiter(self, name: str) -> bool:
        if name not in PROCESSES:
            raise UsageError(f"there is no process {name!r}.", todo=f"There are: {', '.join(PROCESSES)}.")
        return name == ARBITER

    def _abandon(self) -> None:
        """Close the socket of the program, which has ended."""
        if self._connection is not None:
            self._connection.die()
        self._program = self._connection = None

    def _start_program(self) -> None:
        token, lines = f"{self._random.getrandbits(128):032x}", client_lines(self.description, HAL)
        try:
            connection = VirtualConnection(lambda: self._arbiters.now, HAL, token, lines, self._now)
        except ReportedError:
            self._starts_at = self.at + _TRIES_US
            return
        self._starts_at = None
        program = Program(
            self.description,
            connection,
            self._told,
            self._recorder,
            clock=self._now,
            publisher=PredicatePublisher(
                self.description, clock=self._now, sender=self._arbiters.sender(own=False), own=False
            ),
            worker=InlineWorker,
        )
        self._connection, self._program = connection, program
        self._told(program.status)
        program.begin()

    # What happens

    def _now(self) -> int:
        return self.at

    def _bringing(self) -> list[tuple[int, Callable[[], object]]]:
        """Return the next readings, which come first at one instant."""
        own = [] if self._own is None else [(self._own.due, self._read_own)]
        return [*own, *((source.due, partial(self._read, source)) for source in self._sources)]

    def _waiting(self) -> list[tuple[int, Callable[[], object]]]:
        """Return the events other than readings with their times (µs), in their order at one instant."""
        waits: list[tuple[int, Callable[[], object]]] = [
            (silent, partial(devices.advance, silent))
            for devices in self._boards.values()
            if (silent := devices.due) is not None
        ]
        waits += [(master.due, partial(self._hear, master)) for master in self._arbiters.masters]
        if self._program is not None and (due := self._program.due) is not None:
            waits.append((due, self._program.work))
        if self._connection is not None:
            waits.append((self._connection.renews_at, partial(self._renew, self._connection)))
        if self._starts_at is not None:
            waits.append((self._starts_at, self._start_program))
        if self._arbiters.now is not None and (due := self._arbiters.now.due) is not None:
            waits.append((due, self._arbiters.now.step))
        return waits

    def _read(self, source: Source) -> None:
        for frame in source.frames(self.at):
            self._pass_on(frame)

    def _hear(self, master: VirtualBus) -> None:
        """Pass on the readings of a bus master, and let the arbiter process the devices' changes."""
        for frame in master.frames(self.at):
            self._pass_on(frame)
        self._arbiters.heard()

    def _leap_of(self, sources: Sequence[Source]) -> Leap | None:
        """Return the leap; None if there are several sources of readings, or a polled one."""
        if len(sources) != 1 or self._own or self._boards or not isinstance(sources[0], StreamedLink):
            return None
        return Leap(self.description, sources[0], self._stays)

    def _stays(self, *frames: Any) -> bool:
        """Return whether these frames change nothing; see `sensing.stays`."""
        if self._program is None or self._newest is None:
            return False
        return stays(self._program.senses.now, self._newest, *frames)

    def _leave_out(self, leap: Leap, limit: int, end: int) -> None:
        """Leave out the frames until ``limit`` that change nothing; the watches of a held part still receive them.

        The last frame before ``end``, where time stops, is played.
        """
        link = leap.link
        link.pass_by(min(limit, self.at + LONGEST_LOOK_US), unheard=self._program is None)
        if (program := self._program) is None or program.waits:
            return
        marks = self._marks
        while marks == self._marks:
            first, to = link.due, leap.next(self.at, limit)
            if to <= limit and leap.covers(to) and to + link.period_us <= end:
                to += link.period_us
            if to == first:
                return
            if all(level is Evidence.GONE for level in program.senses.now.evidence):
                link.due = to
            while link.due < to and marks == self._marks:
                self.at = link.due
                frame = Frame(self.at, None, None, link.passing(self.at))
                program.pass_over(frame)
            self.at = link.due - link.period_us
            program.passed_over((link.due - first) // link.period_us, self.at)

    @property
    def _marks(self) -> tuple[int, ...]:
        return len(self.statuses), len(self.edges)

    def _read_own(self) -> None:
        """Read the arbiter's own inputs and pass them on, if an arbiter lives."""
        for frame in self._own.frames(self.at) if self._own is not None else ():
            if self._arbiters.publisher is not None:
                self._arbiters.publisher.frame(frame, self._pass_on)

    def _pass_on(self, frame: Frame) -> None:
        if self._program is None:
            return
        if self._on_frame:
            self._on_frame(frame)
        self._newest = frame
        self._program.frame(frame)

    def _renew(self, connection: VirtualConnection) -> None:
        lost, faults = connection.renew()
        if (program := self._program) is None:
            return
        if lost is not None:
            program.arbiter_lost(lost)
        if faults is not None:
            program.faults_changed(faults)

    def _told(self, status: Status) -> None:
        self.statuses.append(status)
        if self._leap:
            self._leap.forget()

    def _obey(self, name: str, level: bool) -> None:
        """Process an output that was commanded over its bus."""
        if self._on_bus[name] != level:
            self._on_bus[name] = level
            self._edge(Edge(self.at, name, level))

    def _edge(self, edge: Edge) -> None:
        if self._leap:
            self._leap.forget()
        self.edges.append(edge)
        self.bench.line(edge.line, edge.level, edge.at)
