"""Selects the faults that a tool can have, and serves them to a page over a socket."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator

from end_effector_hal.description import Description, content_hash, socket_path
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.faults import (
    LONGEST,
    FaultOffer,
    FaultRequest,
    TestbenchHeader,
    TestbenchScenario,
    socket_of_testbench,
)
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import ClientLimits, Reply, Server, record_line

from ._scenario import FAULTS, Fault, links_with, traits_of
from ._testbench import Testbench
from ._units import Models, chosen_models, played_units, shown_by_models
from .physics import PRESSURE


def possible_faults(description: Description) -> Iterator[str]:
    """Yield the faults that a tool can have, with their places and without their numbers."""
    for offer in offered_faults(description):
        if offer.anywhere:
            yield offer.name
        else:
            yield from (f"{offer.name}:{place}" for place in offer.places)


def offered_faults(description: Description, models: Models | None = None) -> Iterator[FaultOffer]:
    """Yield the faults that a tool can have, with the data that a user interface needs to offer them: meaning, usage,
    places and number.

    Args:
        models: units that have a model, which shows its own pressures; default: those of `chosen_models`.
    """
    own = shown_by_models(description, chosen_models(None, description) if models is None else models)
    traits = {
        name: each - {PRESSURE} if name in own else each for name, each in traits_of(description).items()
    }
    alarms = tuple(name for name, channel in description.channels.items() if channel.alarm)
    named = tuple(description.named_links)
    for fault in FAULTS:
        if fault.on:
            places = tuple(name for name, each in traits.items() if not each.isdisjoint(fault.on))
            if places:
                yield _offer(fault, places, anywhere=False)
        elif fault.channel:
            if alarms:
                yield _offer(fault, alarms, anywhere=False)
        elif fault.link:
            able = links_with(fault, description)
            if able or fault.link == "also":
                yield _offer(fault, tuple(name for name in named if name in able))
        else:
            yield _offer(fault)


def _offer(fault: Fault, places: tuple[str, ...] = (), *, anywhere: bool = True) -> FaultOffer:
    return FaultOffer(fault.name, fault.meaning, fault.usage, places, anywhere, fault.number)


_log = logging.getLogger("end_effector_lab.testbench")
LOOK_S = 0.1
ALIVE_US = 400_000


class FaultServer:
    """Serves the socket from `start` to `close`.

    Args:
        bench: the running testbench.
        chosen: called with every scenario that a page selects, in a thread of this server.
    """

    def __init__(self, description: Description, bench: Testbench, chosen: Callable[[str], None]) -> None:
        self._description, self._bench, self._chosen = description, bench, chosen
        self._server: Server | None = None
        self._sent, self._sent_at = "", 0

    def start(self) -> None:
        """Create the socket, mode 0660, with the group of the line arbiter's socket if that exists; raises nothing."""
        tool = self._description
        try:
            faults = tuple(offered_faults(tool, self._bench.models))
            units = tuple(text for text, _ in played_units(tool, self._bench.models))
            header = TestbenchHeader(tool.name, content_hash(tool), faults, units)
            self._header = record_line("header", now_us(), header)
            arbiter = socket_path(tool)
            group = str(arbiter.stat().st_gid) if arbiter.exists() else None
            server = Server(
                socket_of_testbench(tool),
                ClientLimits(line=LONGEST),
                group,
                whose="the testbench",
                greets=True,
                request=FaultRequest,
                handle=self._obey,
            )
            self._server = server
            server.start("faults", lambda: self._turn(server))
        except (ReportedError, OSError, RuntimeError) as error:
            _log.warning("no page can choose faults: %s", error)

    def close(self) -> None:
        """Close all connections, and remove the socket."""
        if self._server is not None:
            self._server.close()

    def __enter__(self) -> FaultServer:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _turn(self, server: Server) -> float:
        scenario, at = self._bench.scenario, now_us()
        line = record_line("scenario", at, TestbenchScenario(scenario))
        if scenario != self._sent or at - self._sent_at >= ALIVE_US:
            self._sent, self._sent_at = scenario, at
            server.send(line)
        server.begin(self._header + line)
        return LOOK_S

    def _obey(self, request: FaultRequest) -> Reply:
        if not request.scenario.isprintable():
            raise UsageError(f"scenario {request.scenario!r} has characters that cannot be printed.")
        if request.word == "check":
            self._bench.check(request.scenario)
        else:
            self._bench.choose(request.scenario)
            self._chosen(request.scenario)
        return Reply(True)
