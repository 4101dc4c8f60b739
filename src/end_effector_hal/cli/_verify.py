"""``eehal verify``: proves every requirement of the model and prints verdicts, worst cases and counterexamples."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli.model import NamedNetwork, Source, network_options
from end_effector_hal.errors import UsageError

from ._lab import Drawing, draw_run, figures, is_figure
from ._options import drawing_option
from ._output import Progress, print_document

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.verification.proof import Finding, Proof

_FAILED = 4
_MOST_LISTED, _MOST_NOTES = 6, 3  # in short
_MOST_STEPS, _COLUMNS, _INDENT = 12, 110, " " * 7


@click.command(name="verify")
@network_options("model", "registers", "deaths")
@click.option("--all", "every", is_flag=True, help="Print every requirement, not only what does not hold.")
@click.option(
    "--json", "as_json", is_flag=True, help="Print {requirements, bounds, ...} as JSON, all of them."
)
@drawing_option(
    "Write each counterexample there: text, states.csv, timeline; or only its timeline, into this file."
)
@click.option(
    "--free-sensors",
    "free",
    type=click.Choice(["actuators", "all"]),
    help="Let these readings change to anything at any time; all: the tool changer's as well.",
)
@click.option(
    "--memory",
    "most_gib",
    type=click.FloatRange(0.1),
    metavar="GIB",
    help="Stop beyond it; default: 75 % of the memory that the machine, or the container, has for it.",
)
def command(
    network: NamedNetwork,
    every: bool,
    as_json: bool,
    output: Path | None,
    free: str | None,
    most_gib: float | None,
) -> None:
    """Prove the requirements of the automata with the constants of DESCRIPTION, or show a run that violates one.

    The command prints how many requirements hold, the worst cases, and for every requirement that does not hold the
    shortest run that violates it, with the reason; --all lists every requirement.

    For every output with two coils a separate network is proven as well: it justifies what the automata assume about
    that output. DESCRIPTION defaults to the shipped one; --model checks a UPPAAL file unchanged, with its own queries.
    The exit code is 4 when a requirement does not hold. The verdict about a DESCRIPTION is kept in
    ${XDG_STATE_HOME:-~/.local/state}/end-effector-hal/verdicts, named by the content of the description.

    With --deaths another network is proven, which is the same for all tools: no matter which process dies, when and
    how often, no line of a held part becomes inactive except after a Drop. This takes some seconds.

    With --registers NAME the network of an actuator that is commanded over a bus is proven instead: a command counts
    as done only when its device has accepted it, although the bus loses, delays and duplicates answers. The proof of
    the DESCRIPTION does not contain this network.

    With --free-sensors the automata alone are proven, with sensors that have no memory and no least time between two
    changes. This shows that the ordinary, smaller model of the sensors leaves nothing out. Time need not diverge
    there, since a sensor may change for ever at one instant: the requirement [time] becomes [timelock]. No verdict is
    kept. With three steps the proof takes about forty times as long, with all several times as long again.

    A proof that needs too much memory is stopped: it lists the requirements that are not decided, the exit code is 4,
    and no verdict is kept.
    """
    from end_effector_hal.description import content_hash
    from end_effector_hal.recording import check_replaceable
    from end_effector_hal.verification.lemmas import prove_tool
    from end_effector_hal.verification.proof import prove

    if (network.deaths or network.registers is not None) and free is not None:
        which = "deaths" if network.deaths else "registers"
        raise UsageError(f"The network of {which} has no sensors.", todo="Leave --free-sensors out.")
    source = network.open()
    if free is not None:
        source = _set_free(source, free)
    content = content_hash(source.description) if source.description is not None else ""
    if output is not None and is_figure(output):
        figures()  # without what draws them nothing is proven
    elif output is not None:
        check_replaceable(output)
    most_bytes = None if most_gib is None else round(most_gib * 2**30)
    if not as_json:
        # at once: in a log the first progress comes after half a minute
        click.secho(f"Proving {source.name}", bold=True)
    with Progress("Proving", shown=not as_json) as progress:

        def tell(what: str, states: int) -> None:
            progress(f"Proving {what}{f', {states:,} states' if states else ''}")

        if free is not None:
            proof = prove(source.network, tell, flickers=True, most_bytes=most_bytes)
        elif source.description is not None:
            proof = prove_tool(source.description, source.network, tell, most_bytes=most_bytes)
        else:
            proof = prove(source.network, tell, most_bytes=most_bytes)
    drawing = Drawing()
    files = _write(source, proof, output, drawing) if output is not None else {}
    if as_json:
        reasons = {each.id: _why(source, each) for each in proof.findings if each.trace is not None}
        document = proof.document(reasons) | {"computed_bounds": list(_computed(source))}
        document |= {"free_sensors": free} if free is not None else {}
        print_document(document)
        for file in (file for each in files.values() for file in each):
            click.echo(str(file), err=True)
    else:
        _print(source, proof, files, every=every, free=free is not None)
    if drawing.note:
        click.echo(f"Note: {drawing.note}", err=True)
    if source.description is not None and free is None and not proof.stopped:
        _keep(source.description, content, proof)
    if not proof.holds:
        sys.exit(_FAILED)


def _set_free(source: Source, which: str) -> Source:
    """Return the same automata with sensors that may change at any time."""
    from end_effector_hal.control import model_constants
    from end_effector_hal.verification.proof import free_constants
    from timed_automata import make_network

    given = model_constants(source.description) if source.description is not None else {}
    free = free_constants(source.network, which)
    return replace(
        source,
        name=f"{source.name}, sensors free ({which})",
        network=make_network(source.network.document, {**given, **free}),
    )


def _keep(description: Description, content: str, proof: Proof) -> None:
    """Store the verdict; a managed node of ROS 2 requires it before it moves a line."""
    from end_effector_hal.description import content_hash
    from end_effector_hal.verification.proof import keep_verdict, proof_verdict

    try:
        if content_hash(description) != content:
            raise UsageError("The description changed during the proof: the verdict is not stored.")
        keep_verdict(proof_verdict(content, proof))
    except UsageError as error:
        click.echo(f"Note: {error}", err=True)


def _print(source: Source, proof: Proof, files: dict[str, list[Path]], *, every: bool, free: bool) -> None:
    what = "tool" if source.description is not None else "model"
    if every:
        for finding in proof.findings:
            _print_line(finding)
    else:
        _print_what_is_to_be_said(source, proof)
    _print_bounds(proof)
    if computed := _computed(source):
        click.echo(f"computed from times and attempts, for lack of `bounds:`: {', '.join(computed)}")
    for note in source.network.document.notes[: None if every else _MOST_NOTES]:
        click.echo(f"note: {note}")
    if proof.off and every:
        click.echo(_wrapped(f"\n{len(proof.off)} edges are for other {what}s: {', '.join(proof.off)}", ""))
    _print_runs(source, proof, files, every=every)
    if not files and any(finding.trace for finding in proof.findings):
        click.echo("-o DIR writes the runs and draws them.")
    _print_verdict(proof, what, every=every, free=free)


def _print_what_is_to_be_said(source: Source, proof: Proof) -> None:
    """Print the reason for every requirement that does not hold, and those that are open or have an answer."""
    from end_effector_hal.verification.proof import UNMET

    failing = [each for each in proof.findings if not each.holds and each.decided]
    run = next((each for each in failing if each.trace is not None), None)  # ends with why
    for finding in failing[:_MOST_LISTED]:
        _print_line(finding, most=_MOST_NOTES)
        if finding.trace is not None and finding is not run:
            click.echo(_wrapped(_why(source, finding), _INDENT))
    if more := failing[_MOST_LISTED:]:
        click.echo(_wrapped(f"{len(more)} fail as well: {_ids(more)}", ""))
    told = [
        each for each in proof.findings if not each.decided or (each.holds and each.remark not in ("", UNMET))
    ]
    if proof.stopped:
        stopped = [each for each in told if not each.decided]
        told = [each for each in told if each.decided]
        click.echo(_wrapped(f"{len(stopped)} {stopped[0].remark}", ""))
    for finding in told[:_MOST_LISTED]:
        _print_line(finding, most=1)
    if len(told) > _MOST_LISTED:
        click.echo(f"and {len(told) - _MOST_LISTED} more that are open, or have an answer")


def _print_bounds(proof: Proof) -> None:
    # what never begins with this tool, such as an unlock, has no worst case
    bounds = {name: worst for name, worst in proof.bounds.items() if str(worst) != "never"}
    if bounds:
        click.echo("\nworst cases, computed and required:")
    for name, worst in bounds.items():
        click.echo(
            f"  {name.removesuffix('_s').replace('_', '-'):16} {worst!s:>9}  {worst.declared_ms / 1000:g} s"
        )


def _print_runs(source: Source, proof: Proof, files: dict[str, list[Path]], *, every: bool) -> None:
    """Print the runs that refute a requirement; in the short form, only some steps of the first one."""
    refuted = [finding for finding in proof.findings if finding.trace is not None]
    if every:
        for finding in refuted:
            _print_run(source, finding, files.get(finding.id, []))
        return
    for finding in refuted[:1]:
        _print_run(source, finding, files.get(finding.id, []), most=_MOST_STEPS // min(2, len(refuted)))
    folders = dict.fromkeys(file.parent for each in refuted[1:] for file in files.get(each.id, []))
    if refuted[1:]:
        click.echo(_wrapped(f"{len(refuted) - 1} more have a run each: {_ids(refuted[1:])}", "  "))
    if folders:
        click.echo(
            f"the same files of these are in {', '.join(dict.fromkeys(map(str, (each.parent for each in folders))))}"
        )


def _print_verdict(proof: Proof, what: str, *, every: bool, free: bool) -> None:
    from end_effector_hal.verification.proof import UNMET

    count = len(proof.findings)
    failed = sum(not finding.holds and finding.decided for finding in proof.findings)
    left = sum(not finding.decided for finding in proof.findings)
    unmet = sum(finding.holds and finding.remark == UNMET for finding in proof.findings)
    applying = f"all {count - unmet} that apply hold" if unmet else f"all {count} hold"
    held = f"{count - left} of {count} hold" if left else applying
    verdict = f"{failed} of {count} fail" if failed else held
    verdict += f", {left} are not decided" if left else ""
    verdict += f", {unmet} {'does' if unmet == 1 else 'do'} not apply to this {what}" if unmet else ""
    hint = "" if every else "  (--all lists every requirement" + (" and run)" if failed else ")")
    color = "red" if failed else "yellow" if left else "green"
    text = click.style(f"\n{verdict}; {proof.states:,} states, {proof.seconds:.2f} s", fg=color, bold=True)
    click.echo(text + hint)
    if free:
        click.echo(
            "not asked: that time diverges [time]; a sensor that is free may flicker without end at one instant"
        )


def _ids(findings: Sequence[Finding]) -> str:
    return ", ".join(finding.id for finding in findings)


def _why(source: Source, finding: Finding) -> str:
    from end_effector_hal.verification.proof import told_run

    return told_run(finding, _actuators(source))[-1]


def _actuators(source: Source) -> tuple[str, ...]:
    return tuple(source.description.sequence) if source.description is not None else ()


def _computed(source: Source) -> tuple[str, ...]:
    return source.description.durations.computed if source.description is not None else ()


def _print_line(finding: Finding, most: int | None = None) -> None:
    mark = click.style("holds", fg="green") if finding.holds else click.style("FAILS", fg="red", bold=True)
    mark = mark if finding.decided else click.style("open ", fg="yellow")
    cost = click.style(f"[{finding.id}; {finding.states:,} states, {finding.seconds:.2f} s]", dim=True)
    click.echo(f"{mark}  {finding.sentence}  {cost}")
    remarks = finding.remark.split("; ") if finding.remark else []
    if most is not None and finding.trace is not None and finding.remark == finding.trace.remark:
        remarks = []  # the sentence that says why begins with it
    for remark in remarks[:most]:
        click.echo(f"       {remark}")
    if most is not None and len(remarks) > most:
        click.echo(f"       and {len(remarks) - most} more")


def _print_run(source: Source, finding: Finding, files: list[Path], most: int | None = None) -> None:
    """Print a run with all its remarks; ``most`` limits the number of steps, and every step is cut to one line of a
    terminal.
    """
    from end_effector_hal.verification.proof import told_run

    cut = (lambda line: line) if most is None else _cut
    click.echo(f"\n[{finding.id}] {finding.sentence}")
    if finding.query:
        click.echo(cut(finding.query))
    *lines, _, why = told_run(finding, _actuators(source))
    left_out = 0 if most is None else max(0, len(lines) - most)
    first = most // 3 if most is not None and left_out else len(lines)
    for line in lines[:first]:
        click.echo(cut(f"  {line}"))
    if left_out:
        click.echo(f"  … {left_out} steps more, which --all shows …")
    for line in lines[first + left_out :]:
        click.echo(cut(f"  {line}"))
    click.echo(_wrapped(why, "  "))
    for file in files:
        click.echo(str(file))


def _cut(line: str) -> str:
    return line if len(line) <= _COLUMNS else f"{line[: _COLUMNS - 1]}…"


def _wrapped(text: str, by: str) -> str:
    return textwrap.fill(text, _COLUMNS, initial_indent=by, subsequent_indent=by, break_on_hyphens=False)


def _write(source: Source, proof: Proof, output: Path, draw: Drawing) -> dict[str, list[Path]]:
    from end_effector_hal.verification.proof import counterexample_run, write_counterexample

    names = _actuators(source)
    info, refuted = source.run_info(), [finding for finding in proof.findings if finding.trace is not None]
    if is_figure(output):
        files: dict[str, list[Path]] = {}
        for each in refuted:
            if (run := counterexample_run(each, info, names)) is None:
                raise UsageError("The model has no states to draw.", where=str(output), todo="Name a folder.")
            file = output if len(refuted) == 1 else output.with_stem(f"{output.stem}-{each.id}")
            files[each.id] = [draw_run(*run, file)]
        return files
    return {each.id: write_counterexample(each, output, info, draw, names) for each in refuted}
