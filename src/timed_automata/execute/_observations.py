"""The inputs and outputs of an execution: events, steps, snapshots and observations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from timed_automata.network import Change


@dataclass(frozen=True, slots=True)
class Event:
    """A broadcast from the environment: its channel, and the interface variables that its sender writes."""

    channel: str
    writes: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class TakenEdge:
    """A taken edge: its process, the names of its locations, its number and its position in the file."""

    process: str
    source: str
    target: str
    index: int
    where: str


@dataclass(frozen=True, slots=True)
class Step:
    """One discrete transition.

    Attributes:
        at: time at which it was taken, µs.
        due: time at which it had to be taken, µs; None for an event of the environment.
        late_us: delay after ``due``, µs.
        missed: it was taken later than the model allows (an invariant, or an upper bound of a guard).
        received: channel of the environment's event, if the step received one.
        sent: channel on which an executed process synchronised.
        edges: the edges of all participants, the sender first.
        changes: changes of variables, in the order of declaration.
    """

    at: int
    due: int | None
    late_us: int
    missed: bool
    received: str | None
    sent: str | None
    edges: tuple[TakenEdge, ...]
    changes: tuple[Change, ...]


@dataclass(frozen=True, slots=True)
class Reaction:
    """The result of an event: ``taken`` if a process received it, and all steps, including those due before it."""

    taken: bool
    steps: tuple[Step, ...]


@dataclass(frozen=True, slots=True)
class ExecutionSnapshot:
    """The state of an execution, sufficient to continue from it.

    The time since which a transition has been possible is not stored: between two calls only clocks make transitions
    due.

    Attributes:
        at: the latest time that the execution received, µs.
        entered: time at which the discrete state was entered, µs.
        locations: name of the current location, by process.
        variables: value, by name.
        zeros: instant at which a clock was zero, µs, by name of the clock.
    """

    at: int
    entered: int
    locations: Mapping[str, str]
    variables: Mapping[str, int]
    zeros: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Begun:
    """Observation that an execution began at ``at`` µs with all clocks at zero and these values of the interface."""

    at: int
    writes: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Written:
    """Observation that the environment set interface variables without an event."""

    at: int
    writes: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Received:
    """Observation that an event of the environment arrived; if an edge received it, the next observation is
    that step.
    """

    at: int
    channel: str
    writes: Mapping[str, int]


Observation = Begun | Written | Received | Step
"""An observation of an execution from outside; their sequence is enough to judge whether it is a run of the network."""
