"""Imports a bag: writes the recording that DataLogger would have written from the same messages."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, UsageError, os_errors
from end_effector_hal.nodes.data_logger import CommandsLog, write_state
from end_effector_hal.nodes.interface import END_EFFECTOR_STATE, SUPERVISOR_COMMANDS, Topic, pressure_topics
from end_effector_hal.nodes.transport import StateMessage
from end_effector_hal.recording import Recording, RecordingLimits, RunInfo
from end_effector_hal.vocabulary import printable

from ._bag import Bag, BagMessage, LineOfTime, command_of, lacking, plain_type, pressure_of, state_of

NO_TRACE = "A bag holds no traces: `eehal replay` cannot judge this run."
MOST_FRAMES = 100_000
"""Largest number of frames that are kept until the recording begins; half an hour at 50 Hz."""
MOST_GAPS = 90
"""Largest number of gaps that are reported; the last ones are kept."""
WHOLE = RecordingLimits(total_bytes=10**15)
"""Limits for the recording of a bag, which is finite: no segment is removed."""


@dataclass(frozen=True, slots=True)
class ImportedBag:
    """The result of an import.

    Attributes:
        folder: folder of the recording.
        tool: name of the tool.
        namespace: namespace of its topics; empty if there is none.
        states: number of state messages, most of which repeat the previous one.
        pressures: number of pressure messages.
        seconds: time from the beginning of the bag to the newest stamp.
        notes: sentences for a reader of the recording.
        faults: one sentence per topic about the messages that are left out.
    """

    folder: Path
    tool: str
    namespace: str
    states: int
    pressures: int
    seconds: float
    notes: tuple[str, ...]
    faults: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the result for ``--json``."""
        return {**asdict(self), "folder": str(self.folder)}


def import_bag(
    bag: Bag, folder: Path, *, description: Description | None = None, namespace: str | None = None
) -> ImportedBag:
    """Write a recording into a new folder.

    Args:
        bag: an open bag.
        folder: must not exist, or be empty.
        description: description of the tool; without it there are neither pressures nor thresholds.
        namespace: namespace of the tool; None: the bag contains only one.

    Raises:
        UsageError: the bag has no such tool, or none of its states can be read, and nothing is written; or the rest of
            the bag is damaged, and the part written so far remains.
        ReportedError: the recording can no longer be written; the part written so far remains.
    """
    with os_errors("Cannot be used", folder):
        taken = folder.exists() and (not folder.is_dir() or any(folder.iterdir()))
    if taken:
        raise UsageError("This exists already.", where=str(folder), todo="Choose another folder with -o.")
    topics = bag.topics()
    with ExitStack() as stack:
        return _Import(bag, folder, description, _space(bag, topics, namespace), stack).run(topics)


def _space(bag: Bag, topics: Mapping[str, str], namespace: str | None) -> str:
    """Return the namespace of the tool with a leading slash; "" if it has none."""
    ending = f"/{END_EFFECTOR_STATE.name}"
    named = [each for each in topics if each.endswith(ending)]
    right = [each for each in named if plain_type(topics[each]) == END_EFFECTOR_STATE.type]
    spaces = sorted(each.removesuffix(ending) for each in right)
    if not spaces:
        other = [f"{each} is of the type {topics[each]}" for each in named]
        what = other or [f"its topics are {', '.join(sorted(topics))}" if topics else "it has no topics"]
        raise UsageError(
            f"The bag has no states of an end-effector: {printable('; '.join(what))}.",
            todo=f"Record {END_EFFECTOR_STATE.name}, and the topics of the pressures.",
        )
    shown = printable(", ".join(each or "/" for each in spaces))
    if namespace is None:
        if len(spaces) > 1:
            todo = f"Choose one, such as --namespace {printable(spaces[-1])}."
            raise UsageError(f"The bag has several tools, in {shown}.", todo=todo)
        return spaces[0]
    wanted = f"/{namespace.strip('/')}".rstrip("/")
    if wanted not in spaces:
        raise UsageError(f"The bag has no tool in {wanted or '/'}.", todo=f"There are tools in: {shown}.")
    return wanted


def record_bag(path: Path, folder: Path, description: Description | None) -> ImportedBag:
    """Open a bag and write a recording into a new folder; the page uses it to show a bag.

    Raises:
        UsageError: it is not a bag, or contains no tool.
    """
    with closing(Bag(path)) as bag:
        return import_bag(bag, folder, description=description)


class _Import:
    def __init__(
        self, bag: Bag, folder: Path, description: Description | None, space: str, stack: ExitStack
    ) -> None:
        self._bag, self._folder, self._description, self._space = bag, folder, description, space
        self._stack = stack
        self._time = LineOfTime()
        self._newest = self._log_offset = 0
        self._pressures = pressure_topics(description) if description is not None else ()
        self._frame: dict[str, int | None] = {}
        """Pressures of one frame, which is not complete yet."""
        self._frame_us = 0
        """When the first of them was recorded."""
        self._frames: deque[tuple[int, dict[str, int | None]]] = deque(maxlen=MOST_FRAMES)
        """Frames from before the second state: only then it is known when the bag began."""
        self._first_log: int | None = None
        self._generation, self._has_events = 0, False
        self._tool = ""
        self._actuators: list[str] = []
        self._first: StateMessage | None = None
        """The first state, kept until the beginning of the recording is known."""
        self._recording: Recording | None = None
        self._commands: CommandsLog | None = None
        self._last: StateMessage | None = None
        self._read: Counter[str] = Counter()
        self._unusable: Counter[str] = Counter()
        self._why: dict[str, str] = {}
        self._notes: dict[str, None] = {}
        self._gaps: deque[str] = deque(maxlen=MOST_GAPS)
        self._restarts, self._restarted = 0, ""

    def run(self, topics: Mapping[str, str]) -> ImportedBag:
        handlers: dict[str, Callable[[BagMessage], None]] = {
            self._name(topic): handler
            for topic, handler in (
                (END_EFFECTOR_STATE, self._on_state),
                (SUPERVISOR_COMMANDS, self._on_command),
                *((topic, self._pressure_handler(channel)) for channel, topic in self._pressures),
            )
            if plain_type(topics.get(self._name(topic), "")) == topic.type
        }
        for message in self._bag.messages(frozenset(handlers)):
            if self._first_log is None:
                self._first_log, self._generation = message.log_us, message.generation
            try:
                handlers[message.topic](message)
            except UsageError:
                raise
            except ReportedError:
                what = "The import has ended early, for the recording cannot be written any more."
                todo = "Make room, remove the folder, and import the bag again."
                raise ReportedError(what, where=str(self._folder), todo=todo) from None
            except ValueError as error:
                self._unusable[message.topic] += 1
                self._why.setdefault(message.topic, str(error))
        if self._first is not None:
            self._begin(self._first, self._first.at_us)
        self._write_frames()
        faults = tuple(printable(each) for each in self._left_out())
        recording = self._recording
        if recording is None:
            what = f"Nothing is imported: no message of {self._name(END_EFFECTOR_STATE)} can be used."
            raise UsageError(what, todo=" ".join(faults))
        self._tell(topics)
        for each in (*self._gaps, *faults):
            recording.note(each)
        return ImportedBag(
            self._folder,
            self._tool,
            self._space,
            self._read[self._name(END_EFFECTOR_STATE)],
            self._count_pressures(),
            recording.seconds(self._newest),
            tuple(self._notes),
            faults,
        )

    def _count_pressures(self) -> int:
        return sum(self._read[self._name(topic)] for _, topic in self._pressures)

    def _name(self, topic: Topic) -> str:
        return f"{self._space}/{topic.name}"

    def _left_out(self) -> list[str]:
        return [
            f"{name}: {count} of {count + self._read[name]} messages are left out; the first: {self._why[name]}."
            for name, count in self._unusable.items()
        ]

    def _tell(self, topics: Mapping[str, str]) -> None:
        if self._description is None:
            self._note("Without --description or --profile there are neither pressures nor thresholds.")
        elif not self._count_pressures():
            names = ", ".join(self._name(topic) for _, topic in self._pressures)
            self._note(printable(f"There are no pressures: the bag has no messages of {names}."))
        if self._restarts:
            self._note(
                f"HALMain was started again {self._restarts} times, the last before {self._restarted}."
            )
        if self._time.jumps:
            self._note(
                f"The monotonic clock jumped {self._time.jumps} times, as when the machine is restarted; how long "
                "that took is told by the bag's own times."
            )
        self._note(NO_TRACE)

    def _note(self, text: str) -> None:
        self._notes[text] = None

    def _on_state(self, message: BagMessage) -> None:
        content = message.read()
        state = state_of(content)
        self._check_tool(state)
        if missing := lacking(content):
            self._note(f"The states of the bag are of another version: they lack {', '.join(missing)}.")
        self._has_events = hasattr(content, "events")
        placed = self._place(message, state.at_us, fresh=False)
        for event in state.events:
            event.at_us += placed - state.at_us
        state.at_us = placed
        self._read[message.topic] += 1
        if self._recording is None:
            if self._first is None:
                self._first = state
                return
            if state.at_us == self._first.at_us:
                return  # the same state again
            self._begin(self._first, self._begun(message, state.at_us))
        self._write(state)

    def _pressure_handler(self, channel: str) -> Callable[[BagMessage], None]:
        return lambda message: self._on_pressure(channel, message)

    def _on_pressure(self, channel: str, message: BagMessage) -> None:
        """Keep a pressure until the same one of the next frame comes."""
        value = pressure_of(message.read())
        self._read[message.topic] += 1
        if channel in self._frame:
            self._write_frames()
        self._frame_us = self._frame_us if self._frame else message.log_us
        self._frame[channel] = value

    def _write_frames(self) -> None:
        if self._frame:
            self._frames.append((self._frame_us, self._frame))
            self._frame = {}
        while self._frames and self._recording is not None:
            log_us, values = self._frames.popleft()
            at = log_us + self._log_offset
            self._newest = max(self._newest, at)
            self._recording.values(at, values)

    def _on_command(self, message: BagMessage) -> None:
        command, part = command_of(message.read())
        self._read[message.topic] += 1
        if self._recording is None:
            return
        if self._commands is None:
            log = CommandsLog(self._folder, self._recording.seconds)
            self._commands = self._stack.enter_context(log)
        try:
            self._commands.write(message.log_us + self._log_offset, command, part)
        except OSError as error:
            what = f"A command could not be written: {error.strerror}."
            raise ReportedError(what, where=str(self._folder)) from None

    def _check_tool(self, state: StateMessage) -> None:
        names, own = list(state.actuator_names), self._description
        if not self._actuators:
            if own is not None and names != list(own.sequence):
                what = f"The tool of the bag has other actuators ({printable(', '.join(names))})."
                raise UsageError(what, where=str(own.source), todo="Name the description with which it ran.")
            if not names or len(set(names)) != len(names):
                raise ValueError("it names no actuators, or one of them twice")
            self._actuators = names
            self._tool = printable(state.tool) or (own.name if own is not None else "")
            if own is not None and own.name != self._tool:
                self._note(f"The tool of the bag is called {self._tool}, that of the description {own.name}.")
        if names != self._actuators:
            raise ValueError("it has other actuators than the first state")

    def _place(self, message: BagMessage, at: int, *, fresh: bool) -> int:
        placed = self._time.place(message.topic, at, message.log_us, fresh=fresh)
        if placed > self._newest:
            self._newest, self._log_offset = placed, placed - message.log_us
        return placed

    def _begun(self, message: BagMessage, at: int) -> int:
        """Return the time at which the bag began, from a stamp that was made when its message was published."""
        return at - max(0, message.log_us - (self._first_log or 0))

    def _begin(self, first: StateMessage, begun: int) -> None:
        """Begin the recording with the first state, which may be older than the bag."""
        kinds = dict(zip(first.actuator_names, first.actuator_kinds, strict=False))
        tool = self._description or RunInfo(
            description=self._tool, actuators={each: kinds.get(each, "") for each in self._actuators}
        )
        self._recording = self._stack.enter_context(
            Recording(
                self._folder, tool, ros=self._generation, limits=WHOLE, events=self._has_events,
                started=_time_of_day(self._first_log or 0),
                now=lambda: begun if self._recording is None else self._newest,
            )
        )  # fmt: skip
        self._first = None
        self._write(first)

    def _write(self, state: StateMessage) -> None:
        recording, last = self._recording, self._last
        assert recording is not None
        write_state(recording, state)
        self._last = state
        at = f"{recording.seconds(state.at_us):.3f} s"
        if last is not None and state.since_us != last.since_us:
            self._restarts, self._restarted = self._restarts + 1, at
        elif last is not None and state.count > last.count + 1:
            missing = state.count - last.count - 1
            self._gaps.append(f"Before {at} {missing} changes of the state are not in the bag.")
            self._note("The bag lacks changes of the state; `gaps` in run.json says when.")


def _time_of_day(us: int) -> datetime:
    try:
        return datetime.fromtimestamp(us / 1_000_000, UTC)
    except (ValueError, OverflowError, OSError):  # a bag may say anything
        return datetime.fromtimestamp(0, UTC)
