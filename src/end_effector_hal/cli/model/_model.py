"""``eehal model``: the automata as UPPAAL would show them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
@click.option("--json", "as_json", is_flag=True, help="Print the files.")
def show(network: NamedNetwork, output: Path, template: str | None, as_json: bool) -> None:
    """Draw each template as UPPAAL shows it (Fig. 5), as PNG and as SVG.

    Locations, edges and labels have the positions of the file; the constants of the description that a template uses
    are listed under its name.
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
    if as_json:
        print_document({"source": source.name, "templates": drawn})


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
