"""``eehal model``: the automata themselves, as one would open them in UPPAAL."""

from __future__ import annotations

from pathlib import Path

import click

from end_effector_hal.cli._figures import figures, save_all
from end_effector_hal.cli._options import PathName, the_folder, write_whole
from end_effector_hal.cli.model._check import check
from end_effector_hal.cli.model._simulate import simulate
from end_effector_hal.cli.model._source import DESCRIPTION, MODEL, open_source


@click.group(name="model")
def command() -> None:
    """Look at the automata: simulate, draw, export for UPPAAL, check a file."""


@command.command(short_help="Draw each template as UPPAAL shows it.")
@DESCRIPTION
@MODEL
@click.option(
    "-o",
    "--output",
    default="runs/model",
    show_default=True,
    type=PathName(),
    help="Folder of the drawings.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the files as JSON.")
def show(description: Path | None, model: Path | None, output: Path, as_json: bool) -> None:
    """Draw each template as UPPAAL shows it (Fig. 5), as PNG and as SVG.

    Locations, edges and labels stand where the file says; the constants of the description that a template
    mentions are told under its name.
    """
    import json

    draw, source = figures().draw_template, open_source(description, model)
    folder = the_folder(output)
    names = _file_names([template.name.content.strip() for template in source.network.document.templates])
    drawn: dict[str, list[str]] = {}
    for template, name in zip(source.network.document.templates, names, strict=True):
        figure = draw(template, source.told)
        drawn[template.name.content.strip()] = [str(path) for path in save_all(figure, folder, name)]
        if not as_json:
            click.echo(f"{template.name.content.strip()}: {folder / name}.png, .svg")
    if as_json:
        click.echo(json.dumps({"source": source.name, "templates": drawn}, indent=2, ensure_ascii=False))


def _file_names(names: list[str]) -> list[str]:
    """Names of templates as names of files, none twice, also where case does not count."""
    found: list[str] = []
    for name in names:
        plain = "".join(each if each.isalnum() and each.isascii() else "_" for each in name)[:80]
        while plain.lower() in (other.lower() for other in found):
            plain += "_"
        found.append(plain)
    return found


@command.command(name="export", short_help="Write the network with the constants of a description.")
@DESCRIPTION
@click.option("-o", "--output", metavar="FILE", type=PathName(), help="Default: stdout.")
def export_network(description: Path | None, output: Path | None) -> None:
    """Write the network with the constants of a description, for UPPAAL.

    Layout, comments and queries are those of the file; only the values of constants differ. The same
    description gives the same bytes.
    """
    from timed_automata import export

    data = export(open_source(description, None).network)
    if output is None:
        click.echo(data, nl=False)
    else:
        write_whole(output, data)
        click.echo(str(output))


command.add_command(check)
command.add_command(simulate)
