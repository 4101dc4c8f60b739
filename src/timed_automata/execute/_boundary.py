"""The boundary between executed processes and their environment: which channels and variables they share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from timed_automata.compiler import Effects
from timed_automata.document import did_you_mean, fault, refused
from timed_automata.errors import ModelError, UsageError
from timed_automata.network import Network, Process, effects_of


class ExecutionBoundary:
    """The boundary between the executed processes and their environment.

    Attributes:
        executed: indices of the executed processes.
        inputs: numbers of the broadcast channels on which no executed process sends, by name.
        outputs: numbers of the channels on which executed processes send, by name.
        interface: variables that both sides may share, and that the environment may write.

    Raises:
        UsageError: a name of ``executed`` or ``interface`` is not in the network.
        ModelError: the sides share anything else, or a construct cannot be executed.
    """

    def __init__(self, network: Network, executed: Iterable[str], interface: Iterable[str]) -> None:
        self.network = network
        self.executed = _chosen(network, executed)
        self.interface = frozenset(interface)
        variables = {variable.name for variable in network.variables}
        for name in sorted(self.interface - variables):
            todo = did_you_mean(name, variables)
            raise UsageError(f"The interface variable '{name}' is not in the network.", todo=todo)
        ours = [process for process in network.processes if process.index in self.executed]
        theirs = [process for process in network.processes if process.index not in self.executed]
        for process in ours:
            _refuse_what_cannot_run(process)
        network.refuse_broadcast_by_clock(ours, "an executed process")
        self._refuse_shared(effects_of(ours), effects_of(theirs))
        self._refuse_channels(ours, theirs)
        sent = _channels(ours, "!")
        numbered = list(enumerate(network.channels))
        self.outputs = {channel.name: n for n, channel in numbered if n in sent}
        self.inputs = {channel.name: n for n, channel in numbered if channel.broadcast and n not in sent}
        self._places: dict[str, tuple[int, int, int]] = {}

    def input(self, channel: str) -> int:
        """Return the number of an input channel.

        Raises:
            UsageError: there is no input of this name.
        """
        if channel in self.inputs:
            return self.inputs[channel]
        ours = "is sent by the executed processes" if channel in self.outputs else "is not one of its inputs"
        raise UsageError(f"The channel '{channel}' {ours}.", todo=did_you_mean(channel, self.inputs))

    def writes(self, values: Mapping[str, int]) -> dict[int, int]:
        """Translate values by name to values by offset.

        Raises:
            UsageError: a variable is not part of the interface, or a value is out of its range.
        """
        offsets = {}
        for name, value in values.items():
            offset, low, high = self._places.get(name) or self._place(name)
            if not isinstance(value, int) or not low <= value <= high:
                raise UsageError(f"{name} = {value!r} is no integer from {low} to {high}.")
            offsets[offset] = int(value)
        return offsets

    def _place(self, name: str) -> tuple[int, int, int]:
        """Return offset and range of an interface variable."""
        offset = self.network.offset(name)
        variable = self.network.variable(offset)
        if variable.name not in self.interface:
            raise UsageError(f"'{name}' is not an interface variable.")
        type_ = self.network.scalar(offset)
        place = self._places[name] = offset, type_.low, type_.high
        return place

    def _refuse_shared(self, ours: Effects, theirs: Effects) -> None:
        shared = (ours.writes & (theirs.reads | theirs.writes)) | (theirs.writes & ours.reads)
        hidden = sorted(shared - self.interface)
        if hidden:
            names = ", ".join(f"'{name}'" for name in hidden)
            what = f"The executed processes share {names} with the environment, but not as interface."
            todo = "Name shared variables in the interface; clocks cannot be shared."
            raise ModelError(what, where=self.network.document.path, todo=todo)

    def _refuse_channels(self, ours: Sequence[Process], theirs: Sequence[Process]) -> None:
        sent, received = _channels(ours, "!"), _channels(ours, "?")
        elsewhere = _channels(theirs, "!")
        for edge in (edge for process in ours for edge in process.edges):
            for number in edge.channels:
                channel = self.network.channels[number]
                if channel.broadcast:
                    if edge.direction == "!" and number in elsewhere:
                        raise fault(edge.span, f"Both sides send on the broadcast channel '{channel.name}'.")
                elif number not in sent & received or number in elsewhere | _channels(theirs, "?"):
                    what = f"Both ends of the binary channel '{channel.name}' must be executed."
                    raise fault(edge.span, what, "Only broadcast channels lead to the environment.")


def boundary_of(network: Network, executed: Iterable[str], interface: Iterable[str]) -> ExecutionBoundary:
    """Return the boundary of the given processes, cached per network; raises the same errors as `ExecutionBoundary`."""
    key = ExecutionBoundary, tuple(executed), tuple(interface)
    found: ExecutionBoundary | None = network.derived.get(key)
    if found is None:
        found = network.derived[key] = ExecutionBoundary(network, *key[1:])
    return found


def _chosen(network: Network, executed: Iterable[str]) -> frozenset[int]:
    chosen: set[int] = set()
    for name in executed:
        found = [process.index for process in network.processes if name in (process.name, process.template)]
        if not found:
            known = [known for process in network.processes for known in (process.name, process.template)]
            what = f"'{name}' is neither a process nor a template of the network."
            raise UsageError(what, todo=did_you_mean(name, known))
        chosen.update(found)
    return frozenset(chosen)


def _channels(processes: Sequence[Process], direction: str) -> set[int]:
    return {
        channel
        for process in processes
        for edge in process.edges
        if edge.direction == direction
        for channel in edge.channels
    }


def _refuse_what_cannot_run(process: Process) -> None:
    for constraint in (constraint for edge in process.edges for constraint in edge.guard.clocks):
        if constraint.op == "==":
            what = f"'{constraint.span.snippet}' cannot be executed: no program can act at an exact instant."
            raise fault(constraint.span, what, "Expected '>=', and an upper bound as invariant.")
    for location in process.locations:
        if location.invariant.data is not None or location.invariant.never:
            span = location.drawn.labels["invariant"].text.whole
            raise refused(span, "an executed location whose invariant is about data", "Use guards.")
        for constraint in location.invariant.clocks:
            if constraint.op in (">", ">="):
                what = (
                    f"'{constraint.span.snippet}' cannot be executed: an event cannot wait for a lower bound."
                )
                raise fault(constraint.span, what, "Move it to the guards of the edges that lead there.")
