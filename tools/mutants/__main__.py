"""``python -m tools.mutants``: checks whether the requirements detect edits of the automata."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import click

from end_effector_hal.cli import PathName, Progress, print_document, write_whole
from end_effector_hal.codecs import load_tool
from end_effector_hal.control import load_automata, model_constants
from end_effector_hal.description import Description, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.verification.mutation import MutationRecord
from tools import run
from tools.mutants import MutantVerdict, judge_all, mutation_record, text_of
from tools.mutants import mutants as mutants_of

_SURVIVORS = 4


@click.command()
@click.argument("description", required=False, type=PathName())
@click.option(
    "--sample",
    type=click.IntRange(1),
    metavar="N",
    help="Judge N of them; default: all, which takes a quarter of an hour.",
)
@click.option("--seed", default=0, show_default=True, help="Of the sample; the same seed, the same mutants.")
@click.option(
    "--template", metavar="NAME", help="Edit only this one; default: every template that a program executes."
)
@click.option(
    "--jobs", type=click.IntRange(1), metavar="N", help="Processes; default: one for each processor."
)
@click.option(
    "--record",
    metavar="FILE",
    type=PathName(),
    help="Also write what was found: the table, and which requirements need which edge.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one object, with each mutant.")
def command(
    description: Path | None,
    sample: int | None,
    seed: int,
    template: str | None,
    jobs: int | None,
    record: Path | None,
    as_json: bool,
) -> None:
    """Edit the automata systematically, one small edit at a time, and verify the requirements of each mutant.

    The edits concern guards, invariants, assignments, synchronisations, targets, committed and urgent, and the
    functions of the templates that a program executes. A mutant is caught if a requirement does not hold of it, and
    survives if no requirement detects the edit. If the edit is proven to change no behaviour, the mutant is
    equivalent; otherwise a requirement may be missing, and the exit code is 4. Edits that the values of the
    description switch off or hide are also judged with those of other tools.
    """
    tool = load_tool(description or profile_path())
    network, constants = load_automata(tool), model_constants(tool)
    executed = _executed(tool, template)
    judged: list[MutantVerdict] = []
    with Progress("Judging mutants", shown=not as_json) as progress:
        found = judge_all(network, constants, executed, sample=sample, seed=seed, jobs=jobs)
        for each in found:
            judged.append(each)
            progress(f"Judging mutants: {len(judged)}")
            if each.outcome == "survives" and not as_json:
                progress.clear()
                click.echo(f"{each.mutant.place}: survives: {each.mutant}")
    counts = Counter(str(each.outcome) for each in judged)
    found_all = mutation_record(
        network.document,
        judged,
        of=sum(1 for _ in mutants_of(network.document, executed, constants)),
        seed=None if sample is None else seed,
    )
    if record is not None:
        write_whole(record, text_of(found_all).encode())
    if as_json:
        mutants = [each.document() for each in judged]
        print_document({"source": str(tool.source), "seed": seed, "outcomes": counts, "mutants": mutants})
    else:
        for line in _table(found_all):
            click.echo(line)
    if counts["survives"]:
        sys.exit(_SURVIVORS)


def _executed(tool: Description, template: str | None) -> tuple[str, ...]:
    executed = tool.automata.executed
    if template is None:
        return executed
    if template not in executed:
        todo = f"There are: {', '.join(executed)}."
        raise UsageError(f"Nothing executes a template {template!r}.", todo=todo)
    return (template,)


def _table(record: MutationRecord) -> Iterator[str]:
    """Yield the lines of a table: the outcomes of each kind of edit."""
    outcomes = ("caught", "equivalent", "survives", "off", "invalid", "open")
    heads = ("caught", "same", "survive", "off", "invalid", "open")
    yield f"{'edit':22}" + "".join(f"{head:>9}" for head in heads)
    total: Counter[str] = Counter()
    for counts in record.outcomes.values():
        total.update(counts)
    for kind, counts in [*record.outcomes.items(), ("all", total)]:
        yield f"{kind:22}" + "".join(f"{counts.get(outcome, 0):>9}" for outcome in outcomes)
    yield "same: proven to change nothing that can happen. off: switched off, with the values of other tools too."
    yield "invalid: no model any more. open: too many states."


if __name__ == "__main__":
    run(command)
