"""``eehal verify``: every requirement of the model with its verdict, the worst cases, counterexamples."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli.model import DESCRIPTION, MODEL, Source, open_source
from end_effector_hal.errors import UsageError

from ._figures import Drawing
from ._options import PathName

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.verification.proof import Finding, Proof

_FAILED = 4


@click.command(name="verify")
@DESCRIPTION
@MODEL
@click.option("--json", "as_json", is_flag=True, help="Print {requirements, bounds, ...} as JSON.")
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=PathName(),
    help="Write each counterexample there: text, states.csv, timeline.",
)
def command(description: Path | None, model: Path | None, as_json: bool, output: Path | None) -> None:
    """Prove what the automata must do, with the constants of DESCRIPTION, or show a run that does not.

    DESCRIPTION defaults to the shipped one; --model checks a UPPAAL file as it stands, with its own queries. The
    exit code is 4 when a requirement does not hold. The verdict about a DESCRIPTION is kept in
    ${XDG_STATE_HOME:-~/.local/state}/end-effector-hal/verdicts, by its content.
    """
    from end_effector_hal.recording import content_hash
    from end_effector_hal.verification.proof import prove

    source = open_source(description, model)
    content = content_hash(source.description) if source.description is not None else ""
    with _Progress() as progress:
        proof = prove(source.network, progress)
    drawing = Drawing()
    files = _write(source, proof, output, drawing) if output is not None else {}
    if as_json:
        document = proof.document() | {"computed_bounds": list(_computed(source))}
        click.echo(json.dumps(document, indent=2, ensure_ascii=False))
        for file in (file for each in files.values() for file in each):
            click.echo(str(file), err=True)
    else:
        _print(source, proof, files)
    if drawing.note:
        click.echo(f"Note: {drawing.note}", err=True)
    if source.description is not None:
        _keep(source.description, content, proof)
    if not proof.holds:
        sys.exit(_FAILED)


def _keep(description: Description, content: str, proof: Proof) -> None:
    """A managed node of ROS 2 asks for it before it moves a line."""
    from end_effector_hal.recording import content_hash
    from end_effector_hal.verification.proof import keep_verdict, proof_verdict

    try:
        if content_hash(description) != content:
            raise UsageError("The tool has changed while it was proven: the verdict is not kept.")
        keep_verdict(proof_verdict(content, proof))
    except UsageError as error:
        click.echo(f"Note: {error}", err=True)


def _print(source: Source, proof: Proof, files: dict[str, list[Path]]) -> None:
    click.secho(f"{source.name}: {len(proof.findings)} requirements", bold=True)
    for finding in proof.findings:
        _print_line(finding)
    if proof.bounds:
        click.echo("\nworst cases, computed and required:")
    for name, worst in proof.bounds.items():
        click.echo(
            f"  {name.removesuffix('_s').replace('_', '-'):16} {worst!s:>9}  {worst.declared_ms / 1000:g} s"
        )
    if computed := _computed(source):
        click.echo(f"bounds that are not written are what the steps add up to: {', '.join(computed)}")
    if proof.off:
        click.echo(
            f"\n{len(proof.off)} edges can never be taken with the values of this description; --json lists them"
        )
    for finding in proof.findings:
        if finding.trace is not None:
            _print_run(finding, files.get(finding.id, []))
    failed = sum(not finding.holds and finding.decided for finding in proof.findings)
    left = sum(not finding.decided for finding in proof.findings)
    verdict = f"{failed} of {len(proof.findings)} fail" if failed else f"all {len(proof.findings)} hold"
    verdict += f", {left} are not decided" if left else ""
    text = f"\n{verdict}; {proof.states:,} states, {proof.seconds:.2f} s"
    click.secho(text, fg="red" if failed else "green", bold=True)
    if failed and not files and any(finding.trace for finding in proof.findings):
        click.echo("-o DIR writes the runs and draws them.")


def _computed(source: Source) -> tuple[str, ...]:
    return source.description.durations.computed if source.description is not None else ()


def _print_line(finding: Finding) -> None:
    mark = click.style("holds", fg="green") if finding.holds else click.style("FAILS", fg="red", bold=True)
    mark = mark if finding.decided else click.style("open ", fg="yellow")
    cost = click.style(f"[{finding.id}; {finding.states:,} states, {finding.seconds:.2f} s]", dim=True)
    click.echo(f"{mark}  {finding.sentence}  {cost}")
    for remark in finding.remark.split("; ") if finding.remark else ():
        click.echo(f"       {remark}")


def _print_run(finding: Finding, files: list[Path]) -> None:
    assert finding.trace is not None
    click.echo(f"\n[{finding.id}] {finding.sentence}")
    if finding.query:
        click.echo(finding.query)
    for line in finding.trace.lines:
        click.echo(f"  {line}")
    for file in files:
        click.echo(str(file))


def _write(source: Source, proof: Proof, output: Path, draw: Drawing) -> dict[str, list[Path]]:
    from end_effector_hal.verification.proof import write_counterexample

    names = tuple(source.description.sequence) if source.description is not None else ()
    info, refuted = source.run_info(), [finding for finding in proof.findings if finding.trace is not None]
    return {each.id: write_counterexample(each, output, info, draw, names) for each in refuted}


class _Progress:
    """Says on stderr what is being done, when it takes long."""

    _FIRST_S = 1.0

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()
        self._every_s = 0.2 if self._terminal else 5.0
        self._begun = time.monotonic()
        self._next = self._begun + (self._FIRST_S if self._terminal else self._every_s)
        self._told = False

    def __call__(self, what: str, states: int) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next, self._told = now + self._every_s, True
        count = f", {states:,} states" if states else ""
        text = f"{what}{count}, {now - self._begun:.0f} s"
        click.echo(f"\r\x1b[K{text}" if self._terminal else text, err=True, nl=not self._terminal)

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._told and self._terminal:
            click.echo("\r\x1b[K", err=True, nl=False)
