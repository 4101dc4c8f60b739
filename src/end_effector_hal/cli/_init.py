"""``eehal init``: a folder to start an own tool from."""

from __future__ import annotations

import json
from pathlib import Path

import click

from end_effector_hal.description import profile_path, schema_path
from end_effector_hal.errors import UsageError

from ._options import PathName, the_folder, write_whole


@click.command(name="init")
@click.argument("folder", type=PathName())
@click.option("--json", "as_json", is_flag=True, help="Print the files as JSON.")
def command(folder: Path, as_json: bool) -> None:
    """Write a description into FOLDER as a starting point: a copy of the paper's tool. Change it to fit yours.

    Beside it the schema that its first line names: an editor that knows the YAML language server completes and
    checks while you type. Nothing that is there already is touched.
    """
    files = [the_folder(folder) / source.name for source in (profile_path(), schema_path())]
    for path in files:
        if path.exists():
            raise UsageError("This file is there already.", where=str(path), todo="Name another folder.")
    for path, source in zip(files, (profile_path(), schema_path()), strict=True):
        write_whole(path, source.read_bytes())
    if as_json:
        click.echo(json.dumps({"files": [str(path) for path in files]}, ensure_ascii=False))
        return
    for path in files:
        click.echo(str(path))
    click.echo(f"Next: edit {files[0]}, then `eehal check {files[0]}`.", err=True)
