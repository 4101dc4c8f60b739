"""``eehal model fig5``: checks that a grip does, on the paper's events, only what the paper's Fig. 5 does."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli._json_output import print_document
from end_effector_hal.cli._progress import Progress
from end_effector_hal.cli.model._source import DESCRIPTION, open_source

if TYPE_CHECKING:
    from end_effector_hal.verification.lemmas import Fig5Report

_DOES_NOT_HOLD = 4


@click.command(short_help="Does a grip do only what the paper's Fig. 5 does?")
@DESCRIPTION
@click.option("--json", "as_json", is_flag=True, help="Print what was found as JSON.")
def fig5(description: Path | None, as_json: bool) -> None:
    """Prove the paper's Fig. 5 with its three devices, and that a grip, seen through the events of Fig. 5, does only
    what Fig. 5 does.

    Fig. 5 is fig5.xml, made from the paper's text: one controller and three devices, with the times of the
    description. It assumes that the tool is locked, that commands are grip and drop, and that feedback comes while an
    actuator is active or never, stays, and is gone in time. The exit code is 4 if something does not hold.
    """
    from end_effector_hal.verification.lemmas import compare_with_fig5

    source = open_source(description, None)
    assert source.description is not None
    with Progress("Comparing", shown=not as_json):
        report = compare_with_fig5(source.description, source.network)
    if as_json:
        print_document({"source": source.name, **_document(report)})
    else:
        for line in _lines(source.name, report):
            click.echo(line)
    if not report.holds:
        sys.exit(_DOES_NOT_HOLD)


def _document(report: Fig5Report) -> dict[str, object]:
    return {
        "fig5": {finding.id: finding.holds for finding in report.proof.findings},
        "included": report.inclusion.holds,
        "states": report.inclusion.states,
        "run": list(report.inclusion.lines),
    }


def _lines(name: str, report: Fig5Report) -> Iterator[str]:
    from end_effector_hal.verification.lemmas import OBSERVED

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
