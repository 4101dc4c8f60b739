"""``eehal model check``: all faults of a UPPAAL file, or its content; ``fig5``: a grip beside the paper's Fig. 5."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import click

from end_effector_hal.cli._options import PathName
from end_effector_hal.cli._output import Progress, print_document
from end_effector_hal.codecs import load_tool
from end_effector_hal.control import model_constants
from end_effector_hal.description import profile_path
from end_effector_hal.errors import ReportedError
from end_effector_hal.verification.lemmas import OBSERVED, Fig5Report, compare_with_fig5
from timed_automata import Network, load_document, make_network
from timed_automata.check import ChannelEnds, channel_ends, find_faults

from ._source import NamedNetwork, is_uppaal, network_options


@click.command(short_help="Type-check a UPPAAL file and list what it holds.")
@click.argument("file", metavar="[FILE|DESCRIPTION]", type=PathName(), required=False)
@click.option("--json", "as_json", is_flag=True, help="Print the faults, or what the file holds, as JSON.")
def check(file: Path | None, as_json: bool) -> None:
    """Type-check a UPPAAL file, or that of a description with its constants inserted.

    Every fault is a line on stderr with file:line:column, and the exit code is 2. Without faults the command lists the
    processes, the clocks, the channels with their senders and receivers, and the queries. If only queries are faulty,
    they are named on stderr, everything else is listed, and the exit code is 4.
    """
    path = file or profile_path()
    try:
        network, faults = _read(path)
    except ReportedError as error:
        network, faults = None, [error]
    exit_code = 2 if network is None else 4 if faults else 0
    told = [each for fault in faults for each in fault.diagnostics]
    if as_json:
        begin = {"file": str(path), "ok": not told, "exit_code": exit_code}
        begin["faults"] = [each.as_json() for each in told]
        print_document(begin if network is None else begin | _document(network))
    elif network is not None:
        for line in _lines(path, network):
            click.echo(line)
    for each in told if not as_json else ():
        click.echo(str(each), err=True)
    if network is not None and faults and not as_json:
        click.echo(f"{len(faults)} of {len(network.document.queries)} queries cannot be asked.", err=True)
    sys.exit(exit_code)


def _read(path: Path) -> tuple[Network | None, list[ReportedError]]:
    constants = None
    if not is_uppaal(path):
        description = load_tool(path)
        constants, path = model_constants(description), description.automata_path
    document = load_document(path)
    faults: list[ReportedError] = [*find_faults(document, constants)]
    try:
        return make_network(document, constants), faults
    except ReportedError:
        return None, faults


def _document(network: Network) -> dict[str, object]:
    return {
        "notes": [asdict(note) for note in network.document.notes],
        "processes": [{"name": each.name, "template": each.template} for each in network.processes],
        "clocks": list(network.clocks[1:]),
        "channels": [asdict(each) for each in channel_ends(network)],
        "queries": [
            {"query": _one_line(each.formula.content), "sentence": each.comment}
            for each in network.document.queries
        ],
    }


def _lines(path: Path, network: Network) -> Iterator[str]:
    locations = sum(len(process.locations) for process in network.processes)
    edges = sum(len(process.edges) for process in network.processes)
    yield f"{path} is valid: {len(network.processes)} processes, {locations} locations, {edges} edges"
    yield f"automata   {network.document.path}"
    yield f"processes  {', '.join(process.name for process in network.processes)}"
    yield f"clocks     {', '.join(network.clocks[1:]) or 'none'}"
    ends = channel_ends(network)
    width = max((len(each.name) for each in ends), default=0)
    for each in ends:
        kind = "broadcast" if each.broadcast else "binary"
        yield (
            f"channel    {each.name:<{width}}  {'urgent ' if each.urgent else ''}{kind}: "
            f"{', '.join(each.senders) or 'nobody'} → {', '.join(each.receivers) or 'nobody'}"
        )
    for each in ends:
        yield from _open_ends(each)
    for note in network.document.notes:
        yield f"note       {note}"
    for query in network.document.queries:
        sentence = f"   {_one_line(query.comment)}" if query.comment else ""
        yield f"query      {_one_line(query.formula.content)}{sentence}"


def _open_ends(ends: ChannelEnds) -> Iterator[str]:
    for names, what in ((ends.unsent, "nobody sends"), (ends.unreceived, "nobody receives")):
        if names:
            more = f" and {len(names) - 4} more" if len(names) > 4 else ""
            yield f"note       {what} {', '.join(names[:4])}{more}"


def _one_line(text: str) -> str:
    return " ".join(text.split())


_DOES_NOT_HOLD = 4


@click.command(short_help="Does a grip do only what the paper's Fig. 5 does?")
@network_options()
@click.option("--json", "as_json", is_flag=True, help="Print what was found as JSON.")
def fig5(network: NamedNetwork, as_json: bool) -> None:
    """Prove the paper's Fig. 5 with its three devices, and that a grip, seen through the events of Fig. 5, does only
    what Fig. 5 does.

    Fig. 5 is fig5.xml, made from the paper's text: one controller and three devices, with the times of the
    description. It assumes that the tool is locked, that commands are grip and drop, and that feedback comes while an
    actuator is active or never, stays, and is gone in time. The exit code is 4 if something does not hold.
    """
    source = network.open()
    assert source.description is not None
    with Progress("Comparing", shown=not as_json):
        report = compare_with_fig5(source.description, source.network)
    if as_json:
        print_document({"source": source.name, **_fig5_document(report)})
    else:
        for line in _fig5_lines(source.name, report):
            click.echo(line)
    if not report.holds:
        sys.exit(_DOES_NOT_HOLD)


def _fig5_document(report: Fig5Report) -> dict[str, object]:
    return {
        "fig5": {finding.id: finding.holds for finding in report.proof.findings},
        "included": report.inclusion.holds,
        "states": report.inclusion.states,
        "run": list(report.inclusion.lines),
    }


def _fig5_lines(name: str, report: Fig5Report) -> Iterator[str]:
    findings, inclusion = report.proof.findings, report.inclusion
    holding = sum(finding.holds for finding in findings)
    yield f"fig5.xml: {holding} of {len(findings)} requirements hold ({report.proof.states} states)"
    yield from (f"  does not hold: {each.id}: {each.sentence}" for each in findings if not each.holds)
    if inclusion.holds:
        yield f"{name}: a grip does nothing that Fig. 5 does not ({inclusion.states} pairs of states)"
    else:
        yield f"{name}: a grip does something that Fig. 5 does not; ms, and what happens:"
        yield from (f"  {line}" for line in inclusion.lines)
    yield f"Compared with their times: {', '.join(OBSERVED)}. World: as in the paper (eehal model fig5 --help)."
