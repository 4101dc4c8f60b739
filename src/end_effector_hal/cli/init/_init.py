"""``eehal init``: writes a folder with a description to start a new tool from."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from end_effector_hal.cli._completion import completed
from end_effector_hal.cli._options import PathName, the_folder, write_whole
from end_effector_hal.cli._output import print_document
from end_effector_hal.codecs import codec_names
from end_effector_hal.description import DeviceLibrary, LibraryDevice, did_you_mean, profile_path, schema_path
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import DeviceKind, get_kind, kind_names
from end_effector_hal.kinds.stanza import NO_CHANNEL


@click.command(name="init")
@click.argument("folder", type=PathName())
@click.option(
    "--actuators",
    metavar="NAME:KIND[:LINK],...",
    shell_complete=completed(
        lambda _: (*kind_names(), *DeviceLibrary().names()), separator=",", after_colon=True
    ),
    help="Of the tool, in the order of a grip; LINK says what proves one of them: the NAME of a link, or none for "
    "inputs of the board, such as cups:vacuum,jaw:gripper:none. KIND may be a device of the library, such as "
    "fingers:robotiq-2f85; then all must be devices, and --link is left out.",
)
@click.option(
    "--link",
    "links",
    metavar="[NAME:]LINK",
    multiple=True,
    shell_complete=completed(lambda _: (*LINKS, *codec_names()), separator=",", after_colon=True),
    help="text, json, binary, modbus, none (inputs of the board), or a codec; several times with a NAME each, such as "
    "front:text: the actuators are distributed among them in turn, or as their LINK says.  [default: text]",
)
@click.option(
    "--port",
    "ports",
    metavar="[NAME=]PORT",
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
    links: tuple[str, ...],
    ports: tuple[str, ...],
    tool_changer: bool | None,
    virtual: bool,
    as_json: bool,
) -> None:
    """Write a description into FOLDER as a starting point. Change it to fit your tool.

    With --actuators the description has these actuators, and `eehal check` and `eehal verify` accept it unchanged; on
    a terminal the command asks for all other values, elsewhere it uses the defaults. Without --actuators the
    description is a copy of the paper's tool.

    The JSON schema that the first line of the description names is written beside it: an editor with the YAML
    language server then completes and checks while you type. Existing files are not changed.
    """
    files = [folder / source.name for source in (profile_path(), schema_path())]
    for path in files:
        if path.exists() or path.is_symlink():  # a link may lead to what does not exist
            raise UsageError("This file is there already.", where=str(path), todo="Name another folder.")
    asking = sys.stdin.isatty() and not as_json
    if actuators is None and (links or ports or tool_changer is not None or virtual):
        if not asking:
            raise UsageError(
                "No actuators are named.", todo="Give --actuators, such as cups:vacuum,rod:cylinder."
            )
        actuators = _asked("Actuators, in the order of a grip (NAME:KIND,...)")
    description = profile_path().read_bytes()
    if actuators is not None:
        description = _described(folder, actuators, links, ports, tool_changer, virtual, asking).encode()
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
    links: tuple[str, ...],
    ports: tuple[str, ...],
    tool_changer: bool | None,
    virtual: bool,
    asking: bool,
) -> str:
    from ._new_tool import new_description

    wanted = wanted_actuators(actuators)
    if virtual and ports:
        raise UsageError("--virtual has ports of its own.", todo="Leave out --port, or --virtual.")
    if any(each.device for each in wanted):
        from ._with_devices import description_with_devices

        if links or tool_changer:
            raise UsageError(
                "A device of the library has its own link.",
                todo="Leave out --link and --tool-changer; write a tool changer into the file.",
            )
        names = dict.fromkeys(each.link for each in wanted)
        its_links = with_ports([WantedLink(name, "modbus") for name in names], ports)
        return description_with_devices(folder, wanted, its_links, virtual=virtual)
    if not links and all(each.link == BOARD for each in wanted):
        links = (BOARD,)
    if not links:
        links = (_asked(f"Link ({', '.join(LINKS)}, or a codec)", "text") if asking else "text",)
    wanted_by = with_ports(wanted_links(links), ports)
    if tool_changer is None:
        tool_changer = not asking or click.confirm("Is a tool changer fitted?", default=True, err=True)
    return new_description(
        folder,
        wanted,
        wanted_by,
        tool_changer=tool_changer,
        virtual=virtual,
        ask=_asked if asking else _refuse,
    )


def _asked(what: str, default: str | None = None) -> str:
    return str(click.prompt(what, default=default, err=True)).strip()


def _refuse(what: str) -> str:
    raise UsageError(f"This has no default: {what}.", todo="Call it on a terminal, where it asks.")


NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_OTHER_WORDS = ("null", "true", "false", NO_CHANNEL)
BOARD = "none"
LINKS: tuple[str, ...] = ("text", "json", "binary", "modbus", BOARD)
"""Links without a codec: a frame that is declared, or inputs of the board; the name of a codec is allowed as well."""


@dataclass(frozen=True)
class WantedActuator:
    """One actuator of the new tool; ``link`` is the name or kind of the link that confirms it, "" for any link.

    ``device`` is the device of the library that it is; "": it has only a kind.
    """

    name: str
    kind: DeviceKind[Any]
    link: str = ""
    device: str = ""


@dataclass(frozen=True)
class WantedLink:
    """A link that confirms actuators: ``what`` is one of `LINKS` or a codec; ``name`` is "" if there is
    only one link; ``port`` is "" for the usual one.
    """

    name: str
    what: str
    port: str = ""

    @property
    def said(self) -> str:
        """The text by which an actuator refers to this link."""
        return self.name or self.what


def wanted_actuators(text: str) -> tuple[WantedActuator, ...]:
    """Parse ``cups:vacuum,jaw:gripper``, or with the link of each actuator ``cups:vacuum:front``; raises UsageError.

    In the place of a kind there may be a device of the library.
    """
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
            found[name] = WantedActuator(name, get_kind(device.kind), link, kind)
        elif near := "" if kind in kind_names() else library.meant(kind):
            raise UsageError(f"There is no kind and no device {kind!r}.", todo=f"{near[0].upper()}{near[1:]}")
        else:
            found[name] = WantedActuator(name, get_kind(kind), link)
    return tuple(found.values())


def wanted_links(texts: Sequence[str]) -> tuple[WantedLink, ...]:
    """Parse ``text``, or ``front:text`` and ``arm:modbus``, or one of these and ``none``; raises UsageError."""
    each_text = [each.strip() for text in texts for each in text.split(",")]
    several = len([each for each in each_text if each != BOARD]) > 1
    found: dict[str, WantedLink] = {}
    for each in each_text:
        name, colon, what = each.partition(":")
        if not colon:
            name, what = BOARD if each == BOARD and len(each_text) > 1 else "", each
        elif not NAME.fullmatch(name) or name in _OTHER_WORDS:
            raise UsageError(
                f"{name!r} is not a valid name of a link.",
                todo="Write lower-case letters, digits and '_': front:text.",
            )
        if not name and several:
            raise UsageError(f"The link {each!r} has no name.", todo=f"Write NAME:{each}, one for each link.")
        if name in found:
            raise UsageError(f"Two links are named {name!r}.", todo="Give each a name of its own.")
        if colon and what == BOARD:
            raise UsageError(
                "Inputs of the board have no link.", todo=f"Write --link {BOARD}, without a name."
            )
        found[name] = WantedLink(name, _known_link(what))
    return tuple(found.values())


def with_ports(links: Sequence[WantedLink], texts: Sequence[str]) -> tuple[WantedLink, ...]:
    """Return the links with their ports: ``tcp://192.168.1.20``, or ``front=/dev/ttyS1``; raises UsageError."""
    found: dict[str, str] = {}
    for text in texts:
        name, equals, port = text.partition("=")
        name, port = (name, port) if equals else ("", text)
        if not any(link.name == name for link in links if link.what != BOARD):
            real = [link.name for link in links if link.what != BOARD]
            names = ", ".join(f"--port {name}=PORT" if name else "--port PORT" for name in real)
            raise UsageError(f"--port {text} belongs to no link.", todo=f"Expected: {names or 'no --port'}.")
        if name in found:
            raise UsageError(f"--port {text}: this link has a port already.", todo="Give each one once.")
        found[name] = port
    return tuple(replace(link, port=found.get(link.name, "")) for link in links)


def _known_link(link: str) -> str:
    if link not in LINKS and link not in codec_names():
        known = [*LINKS, *codec_names()]
        meant = did_you_mean(link, known)
        hint = f"{meant[0].upper()}{meant[1:]} " if meant else ""
        raise UsageError(f"There is no link {link!r}.", todo=f"{hint}There are: {', '.join(known)}.")
    return link
