"""``eehal plugin``: add, list and remove packages of one's own."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from end_effector_hal import plugins
from end_effector_hal.cli._options import PathName
from end_effector_hal.cli._output import print_document, print_table

from ._store import add, added, remove

_RUNS = "Its code runs in every program of this environment that uses it, with all rights of that program."


@click.group("plugin")
def command() -> None:
    """Codecs, kinds, their physics, and commands of your own in this environment.

    They are in the folder `plugins` of the environment, which an upgrade of the product keeps. Nothing is downloaded.
    A device (.yaml) or automata (.xml) of your own need no plug-in: they belong beside the description.
    """


@command.command("add")
@click.argument("package", type=PathName())
def add_plugin(package: Path) -> None:
    """Add the PACKAGE, a folder with a pyproject.toml or a wheel; one of the same name is replaced.

    A plug-in is code that you trust: it runs once now, as the user who adds it, and then in every program that uses
    it. Of a folder the modules are copied that its entry points name; no build program runs. It is refused
    if it declares no entry point of this product, has a name that exists already, or needs a package that is
    not installed in the version that it names (a requirement with a condition, `; …`, is not compared).
    """
    found = add(package)
    click.echo(f"{found.name} {found.version} is in {plugins.FOLDER}: {', '.join(found.brings)}.")
    click.echo(f"{_RUNS} Programs that run now use it after a restart.", err=True)


@command.command("list")
@click.option("--json", "as_json", is_flag=True, help="Print the plug-ins as JSON.")
def list_plugins(as_json: bool) -> None:
    """List the plug-ins, what they bring, and whether each can be loaded, which runs its code."""
    if as_json:
        print_document({"plugins": [asdict(each) for each in added()]})
        return
    from rich.table import Table

    table = Table("name", "version", "brings", "loads", box=None, pad_edge=False, padding=(0, 1))
    for each in added():
        table.add_row(each.name, each.version, ", ".join(each.brings), each.fault or "yes")
    print_table(table)


@command.command("remove")
@click.argument("name")
def remove_plugin(name: str) -> None:
    """Remove the plug-in NAME. Programs that run keep it until they end."""
    click.echo(f"{remove(name)} is removed. A description that uses it is refused from now on.")
