"""What goes into an execution and what comes out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from timed_automata.network import Change


@dataclass(frozen=True, slots=True)
class Event:
    """A broadcast of the environment: its channel, and the interface variables that its sender writes."""

    channel: str
    writes: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class TakenEdge:
    """An edge that was taken: its process, the names of its locations, its number and where it stands."""

    process: str
    source: str
    target: str
    index: int
    where: str


@dataclass(frozen=True, slots=True)
class Step:
    """One discrete transition.

    Attributes:
        at: when it was taken, µs.
        due: when it had to be taken, µs; None for an event of the environment.
        late_us: how much later than due.
        missed: taken beyond what the model allows (an invariant, or an upper bound of a guard).
        received: channel of the environment's event, if that is what it was.
        sent: channel on which an executed process synchronised.
        edges: the participants, the sender first.
        changes: of variables, in the order in which they are declared.
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
    """What an event did: ``taken`` by any process; the steps, those included that were due before it."""

    taken: bool
    steps: tuple[Step, ...]


@dataclass(frozen=True, slots=True)
class ExecutionSnapshot:
    """Where an execution stands: enough to go on from.

    Since when a transition could be taken is not in it: between two calls nothing is due but what a clock makes due.

    Attributes:
        at: µs, the latest time that the execution was given.
        entered: µs, when the discrete state was entered.
        locations: name of the location by process.
        variables: value by name.
        zeros: by clock: the instant, µs, at which it was zero.
    """

    at: int
    entered: int
    locations: Mapping[str, str]
    variables: Mapping[str, int]
    zeros: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Begun:
    """An execution began at ``at`` µs, all clocks at zero, with these values of the interface."""

    at: int
    writes: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Written:
    """The environment set variables of the interface, without an event."""

    at: int
    writes: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Received:
    """An event of the environment came to be taken; the next observation is its step, if anybody took it."""

    at: int
    channel: str
    writes: Mapping[str, int]


Observation = Begun | Written | Received | Step
"""What can be seen of an execution from outside, in order: enough to judge whether it is a run of the network."""
