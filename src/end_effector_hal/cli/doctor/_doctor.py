"""``eehal doctor``: finds what this machine lacks to run the tool."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import click

from end_effector_hal.cli._completion import completed
from end_effector_hal.cli._options import PathName
from end_effector_hal.cli._output import Progress, print_document
from end_effector_hal.description import Description, did_you_mean, examine, profile_path
from end_effector_hal.errors import UsageError

from ._check_result import CheckedPart, CheckResult, CheckResults, Level

PARTS = ("python", "description", "ros", "lines", "arbiter", "link", "inputs", "machine")
_STYLE = {Level.OK: "green", Level.WARNING: "yellow", Level.MISSING: "red"}
BAD_DESCRIPTION, UNREACHABLE = 2, 3


def _parts(_context: click.Context, _parameter: click.Parameter, value: str | None) -> tuple[str, ...]:
    chosen = tuple(name.strip() for name in value.split(",")) if value else PARTS
    if unknown := [name for name in chosen if name not in PARTS]:
        guesses = [f"{name} ({hint})" if (hint := did_you_mean(name, PARTS)) else name for name in unknown]
        raise click.BadParameter(f"{', '.join(guesses)}; there are {', '.join(PARTS)}.")
    return chosen


@click.command(name="doctor")
@click.argument("file", metavar="[DESCRIPTION]", type=PathName(), required=False)
@click.option(
    "--only",
    callback=_parts,
    shell_complete=completed(lambda _: PARTS, separator=","),
    metavar="PART,...",
    help=f"Of {', '.join(PARTS)}.",
)
@click.option(
    "--passive", is_flag=True, help="Do not listen to the sensor port, even if no other process has it."
)
@click.option(
    "--report",
    metavar="FILE.(txt|json)",
    type=PathName(),
    help="Also write all that a bug report needs into FILE: findings, versions, the text of DESCRIPTION. Names of "
    "users and machines, home folders and what looks like a secret are taken out.",
)
@click.option("--json", "as_json", is_flag=True, help="Print {ok, exit_code, findings} as JSON.")
def command(
    file: Path | None, only: tuple[str, ...], passive: bool, report: Path | None, as_json: bool
) -> None:
    """Examine this machine and report what is missing to run the tool.

    Each line is ok, warning or missing, with the remedy. Nothing is written or requested: lines are only looked up,
    and a sensor port that another process reads is not opened.

    Exit codes: 0 nothing is missing, 2 the description is bad, 3 something is missing or not reachable.
    """
    path = file or profile_path()
    if report is not None and report.suffix not in (".txt", ".json"):
        raise UsageError(
            "The name of a report ends in .txt or .json.",
            where=str(report),
            todo=f"To look at the tool of this file: eehal doctor {report} --report report.txt."
            if report.suffix in (".yaml", ".yml")
            else "Choose such a name.",
        )
    findings: list[CheckResult] = []
    with Progress("Looking at this machine", shown=not as_json) as progress:
        for finding in _examined(path, only, listen=not passive):
            findings.append(finding)
            if not as_json:
                progress.clear()
                _print(finding)
    code = _exit_code(findings)
    answer = {"ok": not code, "exit_code": code, "findings": [each.as_json() for each in findings]}
    if as_json:
        print_document(answer)
    if report is not None:
        from ._report import write_report

        write_report(report, path, answer, findings)
        click.echo(f"{report}: look through it before you pass it on.", err=True)
    sys.exit(code)


def _examined(path: Path, only: tuple[str, ...], *, listen: bool) -> Iterator[CheckResult]:
    description, faults = _described(path, wholly="description" in only)
    for part, look in _looks(description, listen=listen).items():
        if part == "description" and (part in only or description is None):
            yield from faults
        elif part in only:
            yield from _guarded(part, look)


def _looks(description: Description | None, *, listen: bool) -> dict[str, Callable[[], CheckResults]]:
    """Return the examinations in their order; without a description, only those that need none."""
    from ._machine import look_at_machine, look_at_python
    from ._ros import look_at_ros

    looks: dict[str, Callable[[], CheckResults]] = {
        "python": look_at_python,
        "description": lambda: iter(()),
        "ros": look_at_ros,
    }
    if description is not None:
        from ._arbiter import look_at_arbiter
        from ._lines import look_at_inputs, look_at_lines
        from ._link import look_at_link

        lines = description.output_lines
        looks["lines"] = lambda: look_at_lines(description, description.wired_lines)
        looks["arbiter"] = lambda: look_at_arbiter(description, lines)
        looks["link"] = lambda: look_at_link(description, listen=listen)
        looks["inputs"] = lambda: look_at_inputs(description)
    reaction = description.bounds.reaction_ms * 1000 if description else None
    looks["machine"] = lambda: look_at_machine(reaction)
    return looks


def _described(path: Path, *, wholly: bool) -> tuple[Description | None, list[CheckResult]]:
    """Return the description, or None if it has faults, and the findings about it; ``wholly``: check its codec and its
    automata as well.
    """
    from end_effector_hal.cli._check import check

    say = CheckedPart("description")
    examination = examine(path)
    lines, description = examination.lines(), examination.description
    if description is not None and wholly:
        try:
            lines = [str(fault) for fault in check(path).faults]
        except Exception as error:  # noqa: BLE001 a doctor says what it meets
            lines = [f"{path}: {type(error).__name__}: {error}"]
    if lines or description is None:
        return None, [say.missing(line, "eehal check prints everything.") for line in lines]
    return description, [say.ok(f"{path}: {description.name} ({description.fingerprint()})")]


def _guarded(part: str, look: Callable[[], CheckResults]) -> Iterator[CheckResult]:
    """Yield the findings of an examination; report an exception in it as a finding, too."""
    try:
        yield from look()
    except Exception as error:  # noqa: BLE001 never a traceback: the machine is not as anybody thought
        text = str(error) or "no reason given"
        yield CheckedPart(part).missing(
            f"it could not be looked at: {type(error).__name__}: {text}", "Please report this."
        )


def _exit_code(findings: list[CheckResult]) -> int:
    missing = {finding.part for finding in findings if finding.level is Level.MISSING}
    if "description" in missing:
        return BAD_DESCRIPTION
    return UNREACHABLE if missing else 0


def _print(finding: CheckResult) -> None:
    first, *more = finding.lines
    level = click.style(first[:8], fg=_STYLE[finding.level])
    click.echo("\n".join([level + first[8:], *more]))
