"""``eehal listen``: what arrives on each channel of a tool, live; and thresholds from what was recorded."""

from __future__ import annotations

import json
import sys
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Self

import click

from end_effector_hal.errors import LinkBusyError, LinkError

from ._options import PathName, end_in_order

if TYPE_CHECKING:
    from rich.console import RenderableType

    from end_effector_hal.description import Description
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
    """Show what arrives on each channel of DESCRIPTION: raw, value, evidence, age, rate, errors.

    It reads links and inputs of the board, and nothing else: no arbiter is asked and no output moves. On a terminal a
    table that is refreshed, elsewhere a line for each change. What somebody else reads is left alone.

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
    for link in tool.links.values():
        _refuse_busy(link.port)
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

    if not as_json and sys.stdout.isatty():
        import rich.live  # noqa: F401 now: frames would wait for it
    heard = ChannelView(tool, now_us())
    end = None if seconds is None else heard.begun + round(seconds * 1e6)
    with heard:
        _show(heard, end, as_json=as_json)
    heard.need_frames()


def _show(heard: ChannelView, end: int | None, *, as_json: bool) -> None:
    from end_effector_hal.wires import now_us

    def hear() -> bool:
        now = now_us()
        if end is not None and now >= end:
            return False
        heard.hear(TICK_S if end is None else min(TICK_S, (end - now) / 1e6))
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
class HeardLink:
    """What came over one link: its newest bytes, its first ones, and errors that were counted before a frame."""

    title: str
    codec: str
    newest: bytes = b""
    sample: bytearray = field(default_factory=bytearray)
    before: dict[str, int] | None = None


class ChannelView:
    """What has arrived so far from every source of a tool, and what it proves; a context in which it is read.

    Args:
        tool: whose channels they are.
        begun: µs, now.
    """

    def __init__(self, tool: Description, begun: int) -> None:
        from end_effector_hal.codecs import carrier_of, codec_of, sources_of
        from end_effector_hal.sensing import SensorSet
        from end_effector_hal.wires.sensors import SensorReader

        from ._hearing import link_title

        self.tool, self.begun = tool, begun
        carrier = carrier_of(tool)
        self.channels = carrier.channels
        self.sensors = SensorSet(tool, carrier)
        self.links = {
            name: HeardLink(link_title(tool, name), codec_of(tool, name).name if link.frame is None else "")
            for name, link in tool.links.items()
        }
        only = next(iter(tool.links), None)
        self._link_of = {
            name: only if source.link is None and len(tool.links) == 1 else source.link
            for source in sources_of(carrier)
            for name in source.channels
            if not (name in tool.channels and tool.channels[name].on_board)
        }
        self.values: dict[str, Value] = {}
        self.arrivals: dict[str, deque[int]] = {name: deque(maxlen=KEPT) for name in self.channels}
        self.due: int | None = None
        self._came: SimpleQueue[Frame | tuple[str, bytes]] = SimpleQueue()
        self._reader = SensorReader(
            tool, self._came.put, on_bytes=lambda name, data: self._came.put((name, data))
        )

    def __enter__(self) -> Self:
        self._reader.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._reader.close()

    def hear(self, longest_s: float) -> None:
        """Take what comes within a time; raises LinkError when no source is left that could bring anything."""
        from end_effector_hal.wires import now_us

        with suppress(Empty):
            self._take(self._came.get(timeout=longest_s))
            while True:
                self._take(self._came.get_nowait())
        now = now_us()
        if self.due is not None and self.due <= now:
            self.sensors.advance(now)
        self.due = self.sensors.deadline(now)
        health = self._reader.health
        errors = [link.error for link in health.links.values()]
        errors += [health.inputs.error] if health.inputs else []
        if all(errors):
            raise LinkError(errors[0])

    def need_frames(self) -> None:
        """Raise LinkError if nothing has come over some link, with what could be done."""
        from ._hearing import why_no_frame

        for name, link in self._reader.health.links.items():
            if not link.frames:
                heard = self.links[name]
                if link.error:
                    raise LinkError(link.error)
                what, todo = why_no_frame(bytes(heard.sample), heard.codec)
                raise LinkError(f"{what}.", where=heard.title, todo=todo)

    def _take(self, came: Frame | tuple[str, bytes]) -> None:
        from end_effector_hal.wires import now_us

        if isinstance(came, tuple):
            name, data = came
            heard = self.links[name]
            heard.newest = data[-SHOWN:]
            heard.sample += data[: SAMPLE - len(heard.sample)]
            return
        link = self._link_of.get(next(iter(came.values), ""))
        if link is not None and self.links[link].before is None:  # a listener comes in the middle of one
            self.links[link].before = dict(self._reader.health.links[link].errors)
        self.values.update(came.values)
        for name, value in came.values.items():
            if value is not None and name in self.arrivals:
                self.arrivals[name].append(came.at)
        if self.sensors.accepts(came, now_us()):
            self.sensors.frame(came)

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
        stale_us = self.sensors.now.readings.stale_after_us(channel)
        return "stale" if age_s is None or age_s * 1e6 >= stale_us else ""

    def raw(self, channel: str) -> float | None:
        """What its source said, before scale and offset; of a codec's own channel, what the codec says."""
        value, declared = self.values.get(channel), self.tool.channels.get(channel)
        if value is None or declared is None or declared.codec is not None:
            return value
        raw = round(declared.raw(value), 3)
        return int(raw) if raw.is_integer() else raw

    def errors(self) -> dict[str, dict[str, int]]:
        """Of the decoder of each link, by kind; what was lost and reboots are among them."""
        found: dict[str, dict[str, int]] = {}
        for name, counters in self._reader.health.links.items():
            before = self.links[name].before or {}
            since = {kind: count - before.get(kind, 0) for kind, count in counters.errors.items()}
            counted = {"lost": counters.lost, "reboots": counters.reboots, **since}
            found[name] = {kind: count for kind, count in counted.items() if count}
        return found

    def evidence(self) -> dict[str, str]:
        """Of each actuator."""
        names = (name for name, _ in self.tool.ordered)
        return {name: each.name for name, each in zip(names, self.sensors.now.evidence, strict=True)}

    def table(self, now: int) -> RenderableType:
        """For a terminal."""
        from rich.console import Group
        from rich.table import Table
        from rich.text import Text

        channels = Table("channel", "raw", "value", "age", "per second", "of", box=None, pad_edge=False)
        for name in self.channels:
            value, state, age_s = self.values.get(name), self.state(name, now), self.age_s(name, now)
            channels.add_row(
                name,
                "" if value is None else str(int(raw) if isinstance(raw := self.raw(name), bool) else raw),
                Text(state, style="red") if state else scaled(value),
                "" if age_s is None else f"{age_s:.2f} s",
                f"{self.rate_hz(name, now):.1f}",
                ", ".join(self._users(name)),
            )
        actuators = Table("actuator", "evidence", box=None, pad_edge=False)
        for name, evidence in self.evidence().items():
            actuators.add_row(name, evidence)
        sources = map(Text, self._sources())
        newest = (
            Text(f"newest bytes{name and f' of {name}'}  {each.newest.hex(' ')}", style="dim")
            for name, each in self.links.items()
        )
        return Group(*sources, "", channels, "", actuators, "", *newest)

    def _sources(self) -> Iterator[str]:
        health, errors = self._reader.health, self.errors()
        for name, link in health.links.items():
            counted = ", ".join(f"{count} {kind}" for kind, count in errors[name].items()) or "no errors"
            told = link.error or f"{link.bytes} bytes, {link.frames} frames, {counted}"
            yield f"{name and f'{name}: '}{self.links[name].title}: {told}"
        if inputs := health.inputs:
            told = inputs.error or f"{inputs.frames} frames, {inputs.edges} edges"
            yield f"inputs of the board: {told}"

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
        self._errors: Mapping[str, Mapping[str, int]] = {}

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
                    {"event": "channel", "time_s": seconds, "channel": name, "raw": heard.raw(name),
                     "value": shown,
                     **unit, "state": state or "fresh", "rate_hz": round(heard.rate_hz(name, now), 1)}
                )  # fmt: skip
        for actuator, evidence in heard.evidence().items():
            if self._evidence.get(actuator) != evidence:
                self._evidence[actuator] = evidence
                self._tell(
                    {"event": "evidence", "time_s": seconds, "actuator": actuator, "evidence": evidence}
                )
        before, self._errors = self._errors, heard.errors()
        for name, errors in self._errors.items():
            if errors != before.get(name, {}):
                link = {"link": name} if name else {}
                newest = heard.links[name].newest.hex(" ")
                self._tell(
                    {"event": "errors", "time_s": seconds, **link, "errors": errors, "newest_bytes": newest}
                )

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
        of = f" of {content['link']}" if "link" in content else ""
        click.echo(f"{at} errors{of}: {said} (newest bytes {content['newest_bytes']})")
    elif content["state"] != "fresh":
        click.echo(f"{at} {content['channel']} is {content['state']}")
    else:
        raw, value, unit = content["raw"], content["value"], content.get("unit")
        shown = f"{value:.1f} {unit}" if isinstance(value, float) else "yes" if value else "no"
        click.echo(f"{at} {content['channel']} {shown} (raw {int(raw) if isinstance(raw, bool) else raw})")
