"""``eehal devices``: the library of devices, and what the file of one of them says."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import click
from rich.table import Table

from end_effector_hal.cli._completion import completed
from end_effector_hal.cli._options import PathName
from end_effector_hal.cli._output import print_document, print_table
from end_effector_hal.description import CONFIRMED, DeviceLibrary, LibraryDevice
from end_effector_hal.errors import DescriptionError, UsageError


@click.command(name="devices")
@click.argument("name", required=False, shell_complete=completed(lambda _: DeviceLibrary().names()))
@click.option(
    "--folder",
    type=PathName(),
    metavar="FOLDER",
    help="Devices of your own, as the key `devices` of a description names them.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the devices, or the one, as JSON.")
def command(name: str | None, folder: Path | None, as_json: bool) -> None:
    """List the devices of the library, or show one: its registers, and the documents that confirm them.

    `device: NAME` in an actuator of a description uses one.
    """
    if folder is not None and not folder.is_dir():
        raise UsageError("There is no such folder.", where=str(folder), todo="Name a folder with NAME.yaml.")
    library = DeviceLibrary(folder)
    found = [_device(library, each) for each in ([name] if name is not None else library.names())]
    if as_json:
        print_document(_as_json(found[0]) if name is not None else {"devices": [*map(_as_json, found)]})
    elif name is not None:
        for line in _lines(found[0]):
            click.echo(line)
    else:
        _print_list(found)


def _device(library: DeviceLibrary, name: str) -> LibraryDevice:
    device = library.get(name)
    if device is None:
        hint = library.meant(name)
        todo = f"{hint[0].upper()}{hint[1:]}" if hint else "`eehal devices` lists all."
        raise UsageError(f"There is no device {name!r}.", todo=todo)
    if isinstance(device, list):
        raise DescriptionError([fault.diagnostic(name) for fault in device])
    return device


def _print_list(devices: list[LibraryDevice]) -> None:
    table = Table("name", "device", "kind", "confirmed by", "from", box=None, pad_edge=False, padding=(0, 1))
    for each in devices:
        table.add_row(each.name, each.about.title, each.kind, each.about.confirmed, each.origin)
    print_table(table)
    if sys.stdout.isatty():
        click.echo("`eehal devices NAME` shows one; `device: NAME` in an actuator uses it.", err=True)


def _lines(device: LibraryDevice) -> Iterator[str]:
    about = device.about
    yield f"{device.name}: {about.title} ({about.maker}), kind {device.kind}"
    if about.summary:
        yield about.summary
    yield f"file: {device.shown} ({device.origin})"
    yield f"confirmed: {CONFIRMED[about.confirmed]}"
    yield "documents:"
    for number, document in enumerate(about.documents, start=1):
        yield f"  {number}. {document.title}" + (f", {document.url}" if document.url else "")
    yield "registers:"
    for each in about.registers:
        page = f", p. {each.page}" if each.page else ""
        doubt = "" if about.confirmation(each) == about.confirmed else f"; {about.confirmation(each)}"
        last = f" to 0x{each.address + each.count - 1:04X}" if each.count > 1 else ""
        yield f"  0x{each.address:04X}{last}: {each.what} (document {each.document}{page}{doubt})"
    yield f"channels: {', '.join(about.channels)}"
    if about.unit is not None:
        yield f"unit: {about.unit}"
    for sentence in about.not_confirmed:
        yield f"not confirmed: {sentence}"


def _as_json(device: LibraryDevice) -> dict[str, object]:
    return {
        "name": device.name,
        "kind": device.kind,
        "origin": device.origin,
        "file": str(device.path),
        **device.about.model_dump(mode="json"),
    }
