"""The socket of a testbench: over it a page shows the present faults, and selects others.

The bench never waits for the socket, and no error of the socket ends a testbench: without it there is a warning, and
no page has a panel. Only the testbench checks a scenario; a request that comes too late changes nothing.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.faults import (
    LONGEST,
    FaultRequest,
    TestbenchHeader,
    TestbenchScenario,
    socket_of_testbench,
)
from end_effector_hal.recording import content_hash
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import ClientLimits, Reply, Server, record_line
from end_effector_lab.testbench._possible import offered_faults
from end_effector_lab.testbench._testbench import Testbench

_log = logging.getLogger("end_effector_lab.testbench")
LOOK_S = 0.1
ALIVE_US = 400_000


class FaultServer:
    """Serves the socket from `start` to `close`.

    Args:
        description: description of the tool.
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
            faults = tuple(offered_faults(tool))
            header = TestbenchHeader(tool.name, content_hash(tool), faults)
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
