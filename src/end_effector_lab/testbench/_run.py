"""The program: a testbench from its start to a signal."""

from __future__ import annotations

import selectors
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from types import FrameType

from end_effector_hal.description import Description

from ._clock import clock_of
from ._commands import Commands
from ._inputs import LineInputs
from ._mail import Mail
from ._ports import Port
from ._records import Events, Record
from ._testbench import Testbench
from ._voice import Voice

_ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


def run_testbench(
    description: Description,
    inputs: LineInputs,
    port: Port,
    *,
    scenario: str = "nominal",
    seed: int = 0,
    verbose: bool = False,
    as_json: bool = False,
    events: str | Path | None = None,
    record: str | Path | None = None,
) -> None:
    """Run until SIGTERM, SIGINT, SIGHUP or the command ``quit``; in the main thread.

    Says ``ready: …`` when lines are seen and frames sent; reads commands from standard input (`Commands`).

    Args:
        description: of the tool; its link names the codec.
        inputs: where the lines are seen.
        port: where the frames go.
        scenario: what goes wrong.
        seed: of the chance in it.
        verbose: say each edge.
        as_json: say everything as JSON.
        events: file for edges and frames, JSON lines (`Events`).
        record: file for what the sensors really showed, CSV (`Record`).

    Raises:
        UsageError: something that was given cannot be used.
        WireError: lines or port cannot be used, or have gone.
    """
    voice = Voice(as_json=as_json)
    with ExitStack() as stack:
        written = stack.enter_context(closing(Events(events))) if events else None
        recorded = stack.enter_context(closing(Record(record))) if record else None
        mail = stack.enter_context(closing(Mail(voice if verbose else None, written, recorded)))
        stack.enter_context(_signals(mail.end))
        bench = Testbench(
            description, inputs, port, scenario=scenario, seed=seed, watcher=mail, clock=clock_of(inputs)
        )
        with bench:
            hertz = 1e6 / bench.codec.period_us
            voice.say(
                f"ready: {description.name}, scenario {scenario}, lines {inputs.text}, port {port.text}, "
                f"{bench.codec.name} at {hertz:g} Hz",
                ready=description.name,
                scenario=scenario,
                lines=inputs.text,
                port=port.text,
                codec=bench.codec.name,
                hertz=hertz,
            )
            _serve(mail, Commands(voice, bench.choose, mail.end))
        mail.deliver()
        if mail.error:
            raise mail.error


def _serve(mail: Mail, commands: Commands) -> None:
    """Deliver mail and obey standard input, until the end."""
    with selectors.PollSelector() as selector:
        selector.register(mail, selectors.EVENT_READ)
        if sys.stdin is not None:
            selector.register(sys.stdin.fileno(), selectors.EVENT_READ, commands)
        while not mail.ended:
            for key, _ in selector.select():
                if key.data is None:
                    mail.deliver()
                elif not commands.read(key.fd):
                    selector.unregister(key.fd)


@contextmanager
def _signals(end: Callable[[], None]) -> Iterator[None]:
    """Signals end the program, and a background job is not stopped because it reads its terminal."""

    def handle(_number: int, _frame: FrameType | None) -> None:
        end()

    before = {number: signal.signal(number, handle) for number in _ENDING}
    before[signal.SIGTTIN] = signal.signal(signal.SIGTTIN, signal.SIG_IGN)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
