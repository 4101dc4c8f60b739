"""``eehal model``: the automata as UPPAAL would show them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import click

from end_effector_hal.cli._completion import completed
from end_effector_hal.cli._lab import figures, is_figure, save_all
from end_effector_hal.cli._options import PathName, drawing_option, the_folder, write_or_print
from end_effector_hal.cli._output import Progress, print_document
from end_effector_hal.cli.model._check import check
from end_effector_hal.cli.model._simulate import simulate
from end_effector_hal.cli.model._source import NamedNetwork, network_options
from end_effector_hal.description import profile_path
from end_effector_hal.errors import UsageError
from timed_automata.document import Template, did_you_mean

from ._check import fig5


def edge_needs(template: Template) -> list[dict[str, object]]:
    """Return for each edge, in the order of the file, its ends, the number of judged edits, and for every requirement
    how many edits it detected.
    """
    from end_effector_hal.verification.mutation import kept_record

    names = {each.id: each.name.text.content.strip() if each.name else each.id for each in template.locations}
    found: list[dict[str, object]] = []
    for number, edge in enumerate(template.edges):
        needs = kept_record().of_edge(template, number)
        found.append({
            "edge": f"{names[edge.source]} -> {names[edge.target]}",
            "place": edge.place.where(0),
            "edits": needs.edits if needs else 0,
            "needed_by": dict(needs.needed_by) if needs else {},
        })  # fmt: skip
    return found


def told_edges(template: Template) -> Iterator[str]:
    """Yield one line for each edge."""
    for number, each in enumerate(edge_needs(template), start=1):
        needed_by = each["needed_by"]
        assert isinstance(needed_by, dict)
        if not each["edits"]:
            yield f"  {number}. {each['edge']}: no edit of it was judged"
        else:
            by = ", ".join(needed_by) or "no requirement"
            yield f"  {number}. {each['edge']}: needed by {by} (edits judged: {each['edits']})"


def _template_names(context: click.Context) -> Iterable[str]:
    named: dict[str, Any] = {
        key: context.params.get(key) for key in ("description", "model", "coils", "registers", "deaths")
    }
    return [_name(each) for each in NamedNetwork(**named).open().network.document.templates]


@click.group(name="model")
def command() -> None:
    """Examine the automata: simulate, draw, export for UPPAAL, check a file."""


@command.command(short_help="Draw each template as UPPAAL shows it.")
@network_options("model", "coils", "registers", "deaths")
@drawing_option("Folder of the drawings, or the file of one.", default="runs/model")
@click.option(
    "--template", metavar="NAME", shell_complete=completed(_template_names), help="Draw only this one."
)
@click.option("--edges", is_flag=True, help="Print, too, which requirements need each edge.")
@click.option(
    "--json", "as_json", is_flag=True, help="Print the files, and which requirements need each edge."
)
def show(network: NamedNetwork, output: Path, template: str | None, edges: bool, as_json: bool) -> None:
    """Draw each template as UPPAAL shows it (Fig. 5), as PNG and as SVG.

    Locations, edges and labels have the positions of the file; the constants of the description that a template uses
    are listed under its name. With --edges the requirements that need each edge are printed: a requirement needs an
    edge if it failed after an edit of that edge (make mutants). Nothing is printed about an edge that was never edited
    or that is not in the shipped automata.
    """
    draw, source = figures().draw_template, network.open()
    templates = _wanted(source.network.document.templates, template)
    one = is_figure(output)
    if one and len(templates) > 1:
        known = ", ".join(_name(each) for each in templates)
        what = f"{len(templates)} drawings do not fit into one file."
        raise UsageError(
            what, where=str(output), todo=f"Name a folder, or one of them with --template: {known}."
        )
    folder = output if one else the_folder(output)
    drawn: dict[str, list[str]] = {}
    files = _file_names([_name(each) for each in templates])
    with Progress("Drawing", shown=not as_json) as progress:
        for each, file in zip(templates, files, strict=True):
            progress(f"Drawing {_name(each)}")
            figure = draw(each, source.told)
            paths = [figures().save(figure, output)] if one else save_all(figure, folder, file)
            drawn[_name(each)] = [str(path) for path in paths]
            if not as_json:
                progress.clear()
                click.echo(f"{_name(each)}: {output if one else f'{folder / file}.png, .svg'}")
                if edges:
                    for line in told_edges(each):
                        click.echo(line)
    if as_json:
        needs = {_name(each): edge_needs(each) for each in templates}
        print_document({"source": source.name, "templates": drawn, "edges": needs})


def _name(template: Template) -> str:
    return template.name.content.strip()


def _wanted(templates: Sequence[Template], name: str | None) -> list[Template]:
    found = [each for each in templates if name in (None, _name(each))]
    if not found:
        names = [_name(each) for each in templates]
        todo = did_you_mean(name or "", names) or f"There are: {', '.join(names)}."
        raise UsageError(f"There is no template {name!r}.", todo=todo)
    return found


def _file_names(names: list[str]) -> list[str]:
    """Return file names for templates; no two are equal, even without regard to case."""
    found: list[str] = []
    for name in names:
        plain = "".join(each if each.isalnum() and each.isascii() else "_" for each in name)[:80]
        while plain.lower() in (other.lower() for other in found):
            plain += "_"
        found.append(plain)
    return found


@command.command(name="export", short_help="Write the network with the constants of a description.")
@network_options("coils", "registers", "deaths")
@click.option("-o", "--output", metavar="FILE", type=PathName(), help="Default: stdout.")
def export_network(network: NamedNetwork, output: Path | None) -> None:
    """Write the network with the constants of a description, for UPPAAL.

    Layout, comments and queries are those of the file; only the values of constants differ. The same description gives
    the same bytes.
    """
    from timed_automata import export

    source = network.open()
    inputs = source.description.files if source.description is not None else ()
    write_or_print(output, export(source.network), (*inputs, network.description or profile_path()))


command.add_command(check)
command.add_command(fig5)
command.add_command(simulate)
