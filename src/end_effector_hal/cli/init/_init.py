"""``eehal init``: writes a folder with a description to start a new tool from."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from end_effector_hal.cli._completion import completed
from end_effector_hal.cli._options import PathName, the_folder, write_whole
from end_effector_hal.cli._output import print_document
from end_effector_hal.description import DeviceLibrary, LibraryDevice, profile_path, schema_path
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import DeviceKind, get_kind, kind_names
from end_effector_hal.kinds.stanza import NO_CHANNEL

from ._new_channels import BOARD, LINKS


@click.command(name="init")
@click.argument("folder", type=PathName())
@click.option(
    "--actuators",
    metavar="NAME:KIND,...",
    shell_complete=completed(
        lambda _: (*kind_names(), *DeviceLibrary().names()), separator=",", after_colon=True
    ),
    help="Of the tool, in the order of a grip, such as cups:vacuum,jaw:gripper. KIND may be a device of the library, "
    "such as fingers:robotiq-2f85, or fingers:robotiq-2f85:LINK where they are on several links; then all must be "
    "devices, and --link is left out.",
)
@click.option(
    "--link",
    type=click.Choice(LINKS),
    help="What carries the signals; none: inputs of the board.  [default: text]",
)
@click.option(
    "--port",
    "ports",
    metavar="[LINK=]PORT",
    multiple=True,
    help="Of a link: a serial device, or an address such as tcp://192.168.1.20 (docs/how-to/network.md).",
)
@click.option("--tool-changer/--no-tool-changer", default=None, help="Whether one is fitted.  [default: yes]")
@click.option(
    "--virtual", is_flag=True, help="On virtual lines and a pseudo-terminal in FOLDER, for `eehal testbench`."
)
@click.option("--json", "as_json", is_flag=True, help="Print the files as JSON.")
def command(
    folder: Path,
    actuators: str | None,
    link: str | None,
    ports: tuple[str, ...],
    tool_changer: bool | None,
    virtual: bool,
    as_json: bool,
) -> None:
    """Write a description into FOLDER as a starting point. Change it to fit your tool.

    With --actuators the description has these actuators, and `eehal check` and `eehal verify` accept it unchanged.
    Without --actuators the description is a copy of the paper's tool.

    The JSON schema that the first line of the description names is written beside it: an editor with the YAML
    language server then completes and checks while you type. Existing files are not changed.
    """
    files = [folder / source.name for source in (profile_path(), schema_path())]
    for path in files:
        if path.exists() or path.is_symlink():  # a link may lead to what does not exist
            raise UsageError("This file is there already.", where=str(path), todo="Name another folder.")
    description = profile_path().read_bytes()
    if actuators is not None:
        description = _described(folder, actuators, link, ports, tool_changer, virtual).encode()
    elif link or ports or tool_changer is not None or virtual:
        raise UsageError(
            "No actuators are named.", todo="Give --actuators, such as cups:vacuum,rod:cylinder."
        )
    the_folder(folder)
    for path, content in zip(files, (description, schema_path().read_bytes()), strict=True):
        write_whole(path, content)
    if as_json:
        print_document({"files": [str(path) for path in files]})
        return
    for path in files:
        click.echo(str(path))
    file = shlex.quote(str(files[0]))
    click.echo(f"Next: edit {file}, then `eehal check {file}`.", err=True)
    if (
        any(each in description.decode() for each in ("frame: {modbus:", "{device: "))
        and find_spec("pymodbus") is None
    ):
        click.echo("A Modbus link needs the extra modbus: pip install '.[modbus]' in a checkout.", err=True)
    if actuators is not None:
        click.echo(f"To try it without hardware: `eehal run --simulate {file}`.", err=True)


def _described(
    folder: Path,
    actuators: str,
    link: str | None,
    ports: tuple[str, ...],
    tool_changer: bool | None,
    virtual: bool,
) -> str:
    wanted = wanted_actuators(actuators)
    if virtual and ports:
        raise UsageError("--virtual has ports of its own.", todo="Leave out --port, or --virtual.")
    if any(each.device for each in wanted):
        from ._with_devices import description_with_devices

        if link or tool_changer:
            raise UsageError(
                "A device of the library has its own link.",
                todo="Leave out --link and --tool-changer; write a tool changer into the file.",
            )
        its_ports = by_link(dict.fromkeys(each.link for each in wanted), ports)
        return description_with_devices(folder, wanted, its_ports, virtual=virtual)
    from ._new_tool import new_description

    link = link or "text"
    port = by_link([] if link == BOARD else [""], ports).get("", "")
    changer = tool_changer is not False
    return new_description(folder, wanted, link, port, tool_changer=changer, virtual=virtual)


NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_OTHER_WORDS = ("null", "true", "false", NO_CHANNEL)


@dataclass(frozen=True)
class WantedActuator:
    """One actuator of the new tool.

    ``device`` is the device of the library that it is, "": it has only a kind; ``link`` is the name of the device's
    link, "": there is only one.
    """

    name: str
    kind: DeviceKind[Any]
    device: str = ""
    link: str = ""


def wanted_actuators(text: str) -> tuple[WantedActuator, ...]:
    """Parse ``cups:vacuum,jaw:gripper``, or devices as in ``left:onrobot-vg10:LINK``; raises UsageError."""
    library = DeviceLibrary()
    found: dict[str, WantedActuator] = {}
    for each in text.split(","):
        name, colon, rest = each.strip().partition(":")
        kind, _, link = rest.partition(":")
        if not colon:
            raise UsageError(
                f"{each.strip()!r} is not an actuator.",
                todo="Write NAME:KIND, such as cups:vacuum,rod:cylinder.",
            )
        if not NAME.fullmatch(name):
            raise UsageError(
                f"{name!r} is not a valid name of an actuator.",
                todo="Write lower-case letters, digits and '_'.",
            )
        if name in _OTHER_WORDS:
            raise UsageError(
                f"{name!r} has another meaning in a description and cannot name an actuator.",
                todo=f"Write another one, such as {name}_1.",
            )
        if name in found:
            raise UsageError(f"Two actuators are named {name!r}.", todo="Give each a name of its own.")
        if isinstance(device := library.get(kind), LibraryDevice):
            if device.kind not in kind_names():
                raise UsageError(
                    f"{kind} is an I/O board: nothing is known of what is connected to it.",
                    todo="Write its actuators and channels into a file: docs/how-to/device.md.",
                )
            found[name] = WantedActuator(name, get_kind(device.kind), kind, link)
        elif near := "" if kind in kind_names() else library.meant(kind):
            raise UsageError(f"There is no kind and no device {kind!r}.", todo=f"{near[0].upper()}{near[1:]}")
        elif link:
            raise UsageError(
                f"{name}: only a device of the library names a link.", todo=f"Write {name}:{kind}."
            )
        else:
            found[name] = WantedActuator(name, get_kind(kind))
    return tuple(found.values())


def by_link(names: Iterable[str], texts: Sequence[str]) -> dict[str, str]:
    """Return the ports by the names of their links: ``tcp://192.168.1.20``, or ``front=/dev/ttyS1``; those without one
    have "". Raises UsageError.
    """
    found = dict.fromkeys(names, "")
    for text in texts:
        name, equals, port = text.partition("=")
        name, port = (name, port) if equals else ("", text)
        if name not in found:
            expected = ", ".join(f"--port {name}=PORT" if name else "--port PORT" for name in found)
            raise UsageError(
                f"--port {text} belongs to no link.", todo=f"Expected: {expected or 'no --port'}."
            )
        if found[name]:
            raise UsageError(f"--port {text}: this link has a port already.", todo="Give each one once.")
        found[name] = port
    return found
