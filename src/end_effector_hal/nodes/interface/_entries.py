"""The kinds of entries in the ROS interface: topic, service, action, parameter."""

from __future__ import annotations

from dataclasses import dataclass

from end_effector_hal.vocabulary import Command


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic: its publishers, and when and how they publish.

    Attributes:
        name: relative (``/diagnostics`` is global by REP-107).
        type: type of its messages.
        publishers: nodes of this package.
        subscribers: nodes of this package; others are free to subscribe.
        on: the cause of a message: ``change``, ``frame`` or ``command``; empty: only the clock.
        rate_hz: rate of additional periodic messages; None: there are none.
        latched: whether a new subscriber gets the last message at once (ROS 2: transient local, depth 1).
        queue: number of messages kept for a slow subscriber; beyond it the oldest is dropped.
    """

    name: str
    type: str
    publishers: tuple[str, ...]
    subscribers: tuple[str, ...] = ()
    on: str = "change"
    rate_hz: float | None = None
    latched: bool = False
    queue: int = 10


@dataclass(frozen=True, slots=True)
class Service:
    """A service, and the node that serves it."""

    name: str
    type: str
    server: str


@dataclass(frozen=True, slots=True)
class Action:
    """An action and its server.

    Attributes:
        name: relative.
        type: type of its goals, results and feedback.
        server: the node that serves it.
        generations: generations of ROS that offer it.
        optional: whether it is only offered if the package of its type is installed.
    """

    name: str
    type: str
    server: str
    generations: tuple[int, ...] = (1, 2)
    optional: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandAction(Action):
    """An action whose goals all give the same command of Table II."""

    command: Command


@dataclass(frozen=True, slots=True)
class Parameter:
    """A private parameter (``~name``) with a string as its value."""

    name: str
    nodes: tuple[str, ...]
    about: str
