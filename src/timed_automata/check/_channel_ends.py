"""Lists the templates that send and receive on each channel."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata.network import Network


@dataclass(frozen=True, slots=True)
class ChannelEnds:
    """A channel or an array of channels as declared, and the templates at its ends.

    Attributes:
        name: the name, for an array with the number of elements: ``confirmed[3]``.
        broadcast, urgent: as declared.
        senders, receivers: names of templates, in the order of the system line.
        unsent, unreceived: the single channels that no edge sends on, or that no edge receives.
    """

    name: str
    broadcast: bool
    urgent: bool
    senders: tuple[str, ...]
    receivers: tuple[str, ...]
    unsent: tuple[str, ...]
    unreceived: tuple[str, ...]


def channel_ends(network: Network) -> tuple[ChannelEnds, ...]:
    """Return the ends of all channels, in the order of declaration."""
    groups: dict[str, list[int]] = {}
    for number, channel in enumerate(network.channels):
        groups.setdefault(channel.name.partition("[")[0], []).append(number)
    used: dict[str, dict[str, set[int]]] = {"!": {}, "?": {}}  # by direction and template
    for process in network.processes:
        for edge in process.edges:
            if edge.channel is not None:
                used[edge.direction].setdefault(process.template, set()).update(edge.channels)

    def templates(numbers: list[int], direction: str) -> tuple[str, ...]:
        return tuple(name for name, found in used[direction].items() if not found.isdisjoint(numbers))

    def missing(numbers: list[int], direction: str) -> tuple[str, ...]:
        found = set().union(*used[direction].values())
        return tuple(network.channels[n].name for n in numbers if n not in found)

    return tuple(
        ChannelEnds(
            name=name if network.channels[numbers[0]].name == name else f"{name}[{len(numbers)}]",
            broadcast=network.channels[numbers[0]].broadcast,
            urgent=network.channels[numbers[0]].urgent,
            senders=templates(numbers, "!"),
            receivers=templates(numbers, "?"),
            unsent=missing(numbers, "!"),
            unreceived=missing(numbers, "?"),
        )
        for name, numbers in groups.items()
    )
