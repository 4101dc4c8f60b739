"""The command ``eehal listen``: a live table on a terminal, elsewhere a line for each change."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

import click

from end_effector_hal.cli._options import PathName, end_in_order
from end_effector_hal.cli._output import print_line
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.errors import LinkBusyError
from end_effector_hal.sensing import why_invalid
from end_effector_hal.signals import Kind, Measure, Value
from end_effector_hal.wires import now_us
from end_effector_hal.wires.link import users_of

from ._channel_view import ChannelView

TICK_S = 0.1


@click.command("listen")
@click.argument("description", type=PathName())
@click.option(
    "--seconds",
    type=click.FloatRange(min=0, min_open=True),
    help="Stop after this time; default: run until Ctrl-C.",
)
@click.option(
    "--suggest",
    metavar="FOLDER",
    type=PathName(),
    help="Instead: propose thresholds from a recorded grip and drop.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
def command(description: Path, seconds: float | None, suggest: Path | None, as_json: bool) -> None:
    """Show what arrives on each channel of DESCRIPTION: raw value, scaled value, evidence, age, rate, errors.

    The command only reads links and inputs of the board: no output moves. Values that the line arbiter reads itself (a
    bus that is commanded, inputs that interlocks need) come from the arbiter, if it runs. On a terminal a table is
    refreshed, elsewhere a line is printed for each change. A port that another process reads is not opened.

    --suggest reads a recording (`eehal run --record FOLDER`) of a grip and a drop, and proposes thresholds with the
    recorded levels that justify them.
    """
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
    if holders := users_of(port):
        raise LinkBusyError(
            f"the port is read by {' and '.join(map(str, holders))}.",
            where=port,
            todo="Stop that program: two readers would steal each other's bytes.",
        )


def _listen(tool: Description, seconds: float | None, *, as_json: bool) -> None:
    if not as_json and sys.stdout.isatty():
        import rich.live  # noqa: F401 now: frames would wait for it
    heard = ChannelView(tool, now_us())
    end = None if seconds is None else heard.begun + round(seconds * 1e6)
    with heard:
        _show(heard, end, as_json=as_json)
    heard.need_frames()


def _show(heard: ChannelView, end: int | None, *, as_json: bool) -> None:
    def hear() -> bool:
        now = now_us()
        if end is not None and now >= end:
            return False
        heard.hear(TICK_S if end is None else min(TICK_S, (end - now) / 1e6))
        return True

    if as_json or not sys.stdout.isatty():
        words = partial(print_words, heard.measure)
        changes = ChannelChanges(heard, (lambda content: print_line(**content)) if as_json else words)
        while hear():
            changes.tell(now_us())
        return
    from rich.live import Live

    with Live(heard.table(now_us()), refresh_per_second=8) as live:
        while hear():
            live.update(heard.table(now_us()))


STEP = 5
"""Smallest change that is reported, in units of the last decimal: 0.5 kPa for a pressure."""


class ChannelChanges:
    """Reports every change of a value, an evidence or an error counter of the decoder once."""

    def __init__(self, heard: ChannelView, tell: Callable[[dict[str, object]], None]) -> None:
        self._heard, self._tell = heard, tell
        self._told: dict[str, tuple[str, Value]] = {}
        self._evidence: dict[str, str] = {}
        self._alarms: tuple[str, ...] = ()
        self._errors: Mapping[str, Mapping[str, int]] = {}

    def tell(self, now: int) -> None:
        """Report all differences from the values reported last."""
        heard, seconds = self._heard, round((now - self._heard.begun) / 1e6, 3)
        for name in heard.values:
            state, value = heard.state(name, now), heard.values[name]
            if self._changed(name, state, value):
                self._told[name] = (state, value)
                kind, measure = heard.channels.get(name), heard.measure(name)
                measured = kind in (Kind.PRESSURE, Kind.QUANTITY) and not isinstance(value, bool)
                unit = {"unit": measure.unit} if measured and value is not None else {}
                why = {"why": why_invalid(heard.tool, name)} if state == "invalid" else {}
                shown = None if state else value if value is None or not measured else value / 1000
                self._tell(
                    {"event": "channel", "time_s": seconds, "channel": name, "raw": heard.raw(name),
                     "value": shown,
                     **unit, **why, "state": state or "fresh", "rate_hz": round(heard.rate_hz(name, now), 1)}
                )  # fmt: skip
        for actuator, evidence in heard.evidence().items():
            if self._evidence.get(actuator) != evidence:
                self._evidence[actuator] = evidence
                self._tell(
                    {"event": "evidence", "time_s": seconds, "actuator": actuator, "evidence": evidence}
                )
        stood, self._alarms = self._alarms, (*heard.alarms(now), *heard.lost())
        for alarm in dict.fromkeys((*stood, *self._alarms)):
            if (alarm in stood) is not (alarm in self._alarms):
                self._tell(
                    {"event": "alarm", "time_s": seconds, "alarm": alarm, "stands": alarm in self._alarms}
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
        if self._heard.channels.get(name) is Kind.CODE:
            return value != before
        return abs(value - before) >= STEP * 10.0 ** (3 - self._heard.measure(name).decimals)


def print_words(measure_of: Callable[[str], Measure], content: dict[str, object]) -> None:
    """Print a change as a line for people; ``measure_of`` returns how the values of a channel are shown."""
    at = f"{content['time_s']:9.3f} s "
    if content["event"] == "evidence":
        click.echo(f"{at} {content['actuator']} is {content['evidence']}")
    elif content["event"] == "alarm":
        click.echo(f"{at} {'alarm' if content['stands'] else 'over'}: {content['alarm']}")
    elif content["event"] == "errors":
        errors = content["errors"]
        assert isinstance(errors, dict)
        said = ", ".join(f"{count} {kind}" for kind, count in errors.items())
        of = f" of {content['link']}" if "link" in content else ""
        click.echo(f"{at} errors{of}: {said} (newest bytes {content['newest_bytes']})")
    elif content["state"] != "fresh":
        why = f" ({content['why']})" if "why" in content else ""
        click.echo(f"{at} {content['channel']} is {content['state']}{why}")
    else:
        raw, value, unit = content["raw"], content["value"], content.get("unit")
        said = "yes" if value is True else "no" if value is False else str(value)
        decimals = measure_of(str(content["channel"])).decimals
        shown = f"{value:.{decimals}f} {unit}" if isinstance(value, float) else said
        click.echo(f"{at} {content['channel']} {shown} (raw {int(raw) if isinstance(raw, bool) else raw})")
