"""``eehal listen``: what arrives on each channel, live; and thresholds from what was recorded."""

from __future__ import annotations

import json
import sys
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.errors import LinkBusyError, LinkError

from ._options import PathName, end_in_order

if TYPE_CHECKING:
    from rich.console import RenderableType

    from end_effector_hal.cli._hearing import OpenLink
    from end_effector_hal.description import Description
    from end_effector_hal.sensing import SensorSet
    from end_effector_hal.signals import Frame, Value

STEP_KPA = 0.5
"""A pressure that moves by less is told as it was."""
TICK_S = 0.1
KEPT = 64
"""Frames over which a rate is counted."""
SHOWN = 24
"""Bytes of the newest that are shown."""
SAMPLE = 65_536
"""Bytes by which another codec is recognised."""


@click.command("listen")
@click.argument("description", type=PathName())
@click.option(
    "--seconds", type=click.FloatRange(min=0, min_open=True), help="So long; default: until Ctrl-C."
)
@click.option(
    "--suggest",
    metavar="FOLDER",
    type=PathName(),
    help="Instead: propose thresholds from a recorded grip and drop.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
def command(description: Path, seconds: float | None, suggest: Path | None, as_json: bool) -> None:
    """Show what arrives on each channel of DESCRIPTION: value, evidence, age, rate, errors.

    It opens the port and nothing else: no arbiter is asked and no line moves. On a terminal a table that is refreshed,
    elsewhere a line for each change. A link that somebody reads is left alone.

    --suggest reads a recording (`eehal run --record FOLDER`) of a grip and a drop, and proposes thresholds with the
    levels that speak for each.
    """
    from end_effector_hal.codecs import load_tool

    tool = load_tool(description)
    if suggest is not None:
        from ._suggest import print_suggestions

        print_suggestions(tool, suggest, as_json=as_json)
        return
    end_in_order()
    if tool.link is not None:
        _refuse_busy(tool.link.port)
    with suppress(KeyboardInterrupt):  # how a live view is left
        _listen(tool, seconds, as_json=as_json)


def _refuse_busy(port: str) -> None:
    from end_effector_hal.wires import holders_of

    if holders := holders_of(port):
        raise LinkBusyError(
            f"the port is read by {' and '.join(map(str, holders))}.",
            where=port,
            todo="Stop that program: two readers would steal each other's bytes.",
        )


def _listen(tool: Description, seconds: float | None, *, as_json: bool) -> None:
    from end_effector_hal.wires import now_us

    from ._hearing import open_link, why_no_frame

    if not as_json and sys.stdout.isatty():
        import rich.live  # noqa: F401 now: frames would wait for it
    with open_link(tool) as link:
        heard = ChannelView(tool, link, now_us())
        end = None if seconds is None else heard.begun + round(seconds * 1e6)
        try:
            _show(heard, link, end, as_json=as_json)
        except LinkError:
            raise
        except OSError as error:
            what = f"the port was lost: {error.strerror or error}."
            raise LinkError(what, where=link.name, todo="Is the device plugged in?") from None
    if not heard.link.decoder.counters.frames:
        what, todo = why_no_frame(bytes(heard.sample), link.codec.name)
        raise LinkError(f"{what}.", where=link.name, todo=todo)


def _show(heard: ChannelView, link: OpenLink, end: int | None, *, as_json: bool) -> None:
    from end_effector_hal.wires import now_us

    def hear() -> bool:
        now = now_us()
        if end is not None and now >= end:
            return False
        left_s = TICK_S if end is None else min(TICK_S, (end - now) / 1e6)
        heard.take(*link.hear(left_s), now_us())
        return True

    if as_json or not sys.stdout.isatty():
        changes = ChannelChanges(heard, _json_line if as_json else _words)
        while hear():
            changes.tell(now_us())
        return
    from rich.live import Live

    with Live(heard.table(now_us()), refresh_per_second=8) as live:
        while hear():
            live.update(heard.table(now_us()))


@dataclass
class ChannelView:
    """What has arrived so far, and what it proves."""

    tool: Description
    link: OpenLink
    begun: int
    size: int = 0
    newest: bytes = b""
    sample: bytearray = field(default_factory=bytearray)
    values: dict[str, Value] = field(default_factory=dict)
    arrivals: dict[str, deque[int]] = field(default_factory=dict)
    before: dict[str, int] = field(default_factory=dict)
    due: int | None = None

    def __post_init__(self) -> None:
        from end_effector_hal.sensing import SensorSet

        self.sensors: SensorSet = SensorSet(self.tool, self.link.codec)
        self.arrivals = {name: deque(maxlen=KEPT) for name in self.link.codec.channels}

    def take(self, data: bytes, frames: list[Frame], now: int) -> None:
        """What came, at ``now``."""
        if data:
            self.size += len(data)
            self.newest = data[-SHOWN:]
            self.sample += data[: SAMPLE - len(self.sample)]
        if frames and not self.values:  # a listener comes in the middle of one
            self.before = dict(self.link.decoder.counters.errors)
        for frame in frames:
            self.values.update(frame.values)
            for name, value in frame.values.items():
                if value is not None and name in self.arrivals:
                    self.arrivals[name].append(frame.at)
            if self.sensors.accepts(frame, now):
                self.sensors.frame(frame)
        if self.due is not None and self.due <= now:
            self.sensors.advance(now)
        self.due = self.sensors.deadline(now)

    def age_s(self, channel: str, now: int) -> float | None:
        """Since its last valid value."""
        arrivals = self.arrivals[channel]
        return (now - arrivals[-1]) / 1e6 if arrivals else None

    def rate_hz(self, channel: str, now: int) -> float:
        """Of valid values, lately; one that has stopped falls to 0."""
        arrivals = self.arrivals[channel]
        if len(arrivals) < 2:
            return 0.0
        return (len(arrivals) - 1) / (max(now, arrivals[-1]) - arrivals[0]) * 1e6

    def state(self, channel: str, now: int) -> str:
        """Empty where there is a fresh value; else why there is none."""
        age_s = self.age_s(channel, now)
        if channel not in self.values:
            return "nothing yet"
        if self.values[channel] is None:
            return "invalid"
        return "stale" if age_s is None or age_s * 1e6 >= self.sensors.now.readings.stale_us else ""

    def errors(self) -> dict[str, int]:
        """Of the decoder, by kind; what was lost and reboots are among them."""
        counters = self.link.decoder.counters
        since = {kind: count - self.before.get(kind, 0) for kind, count in counters.errors.items()}
        counted = {"lost": counters.lost, "reboots": counters.reboots, **since}
        return {kind: count for kind, count in counted.items() if count}

    def evidence(self) -> dict[str, str]:
        """Of each actuator."""
        names = (name for name, _ in self.tool.ordered)
        return {name: each.name for name, each in zip(names, self.sensors.now.evidence, strict=True)}

    def table(self, now: int) -> RenderableType:
        """For a terminal."""
        from rich.console import Group
        from rich.table import Table
        from rich.text import Text

        counters = self.link.decoder.counters
        errors = ", ".join(f"{count} {kind}" for kind, count in self.errors().items()) or "no errors"
        head = f"{self.link.name}: {self.size} bytes, {counters.frames} frames, {errors}"
        channels = Table("channel", "raw", "value", "age", "per second", "of", box=None, pad_edge=False)
        for name in self.link.codec.channels:
            value, state, age_s = self.values.get(name), self.state(name, now), self.age_s(name, now)
            channels.add_row(
                name,
                "" if value is None else str(int(value)),
                Text(state, style="red") if state else scaled(value),
                "" if age_s is None else f"{age_s:.2f} s",
                f"{self.rate_hz(name, now):.1f}",
                ", ".join(self._users(name)),
            )
        actuators = Table("actuator", "evidence", box=None, pad_edge=False)
        for name, evidence in self.evidence().items():
            actuators.add_row(name, evidence)
        newest = Text(f"newest bytes  {self.newest.hex(' ')}", style="dim")
        return Group(Text(head), "", channels, "", actuators, "", newest)

    def _users(self, channel: str) -> Iterator[str]:
        from end_effector_hal.kinds import kind_of

        for name, part in self.tool.ordered:
            if channel in kind_of(part).channel_names(part):
                yield name


def scaled(value: Value) -> str:
    """With its unit."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "" if value is None else f"{value / 1000:.1f} kPa"


class ChannelChanges:
    """Tells each change once: a value, an evidence, an error of the decoder."""

    def __init__(self, heard: ChannelView, tell: Callable[[dict[str, object]], None]) -> None:
        self._heard, self._tell = heard, tell
        self._told: dict[str, tuple[str, Value]] = {}
        self._evidence: dict[str, str] = {}
        self._errors: dict[str, int] = {}

    def tell(self, now: int) -> None:
        """What is otherwise than it was told."""
        heard, seconds = self._heard, round((now - self._heard.begun) / 1e6, 3)
        for name in heard.values:
            state, value = heard.state(name, now), heard.values[name]
            if self._changed(name, state, value):
                self._told[name] = (state, value)
                unit = {"unit": "kPa"} if not isinstance(value, bool) and value is not None else {}
                shown = None if state else value if isinstance(value, bool) or value is None else value / 1000
                self._tell(
                    {"event": "channel", "time_s": seconds, "channel": name, "raw": value, "value": shown,
                     **unit, "state": state or "fresh", "rate_hz": round(heard.rate_hz(name, now), 1)}
                )  # fmt: skip
        for actuator, evidence in heard.evidence().items():
            if self._evidence.get(actuator) != evidence:
                self._evidence[actuator] = evidence
                self._tell(
                    {"event": "evidence", "time_s": seconds, "actuator": actuator, "evidence": evidence}
                )
        if (errors := heard.errors()) != self._errors:
            self._errors = errors
            newest = heard.newest.hex(" ")
            self._tell({"event": "errors", "time_s": seconds, "errors": errors, "newest_bytes": newest})

    def _changed(self, name: str, state: str, value: Value) -> bool:
        if name not in self._told:
            return True
        was, before = self._told[name]
        if state != was or state:
            return state != was
        if isinstance(value, bool) or isinstance(before, bool) or value is None or before is None:
            return value != before
        return abs(value - before) >= STEP_KPA * 1000


def _json_line(content: dict[str, object]) -> None:
    click.echo(json.dumps(content, ensure_ascii=False))


def _words(content: dict[str, object]) -> None:
    at = f"{content['time_s']:9.3f} s "
    if content["event"] == "evidence":
        click.echo(f"{at} {content['actuator']} is {content['evidence']}")
    elif content["event"] == "errors":
        errors = content["errors"]
        assert isinstance(errors, dict)
        said = ", ".join(f"{count} {kind}" for kind, count in errors.items())
        click.echo(f"{at} errors: {said} (newest bytes {content['newest_bytes']})")
    elif content["state"] != "fresh":
        click.echo(f"{at} {content['channel']} is {content['state']}")
    else:
        raw = content["raw"]
        assert isinstance(raw, bool | int)
        click.echo(f"{at} {content['channel']} {scaled(raw)} (raw {int(raw)})")
