"""Writes a description of a new tool from the kinds of its actuators."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from pydantic.fields import FieldInfo

from end_effector_hal.codecs import match_codec
from end_effector_hal.description import ToolChanger as ChangerStanza
from end_effector_hal.description import examine_text, has_line, schema_path
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds.stanza import NO_CHANNEL, Actuator
from end_effector_hal.nodes.interface import name_faults

from ._init import NAME, WantedActuator
from ._new_channels import BOARD, NewChannels, channel_lines, frame_line, new_channels

_WHAT = 34
"""Column at which the comments of the written description begin."""
_TIMES = ("timeout_s", "reset_s", "attempts", "release_s")


def new_description(
    folder: Path,
    actuators: Sequence[WantedActuator],
    link: str,
    port: str,
    *,
    tool_changer: bool,
    virtual: bool,
) -> str:
    """Return the text of a description that is valid unchanged.

    Args:
        folder: the folder of the description; its name becomes the name of the tool.
        actuators: in the order of a grip.
        link: carries the signals, one of `LINKS`.
        port: of the link; "": the usual one.
        tool_changer: whether a tool changer is fitted.
        virtual: use virtual lines and a pty in the folder, for the testbench.

    Raises:
        UsageError: the description would have a fault.
    """
    pairs = [(each.name, each.kind) for each in actuators]
    channels = new_channels(pairs, on_board=link == BOARD, tool_changer=tool_changer)
    lines = [
        *_head(folder, virtual=virtual),
        *(_link(folder, link, port, channels, virtual=virtual) if link != BOARD else ()),
        *channel_lines(link, channels),
        *_sequence(actuators),
    ]
    for number, each in enumerate(actuators, start=1):
        lines += _actuator(each, number, channels.given[each.name])
    lines += _changer(len(actuators) + 1) if tool_changer else ()
    lines += (
        "",
        "supply:",
        _key("channel", NO_CHANNEL, "no sensor of the compressed air: a lack of it is not seen"),
    )
    text = "\n".join(
        (
            *lines,
            "",
            "# bounds: grip_s, release_s and cancel_s are computed from the times above; write them to require less.",
            "",
        )
    )
    refuse_faulty(text, folder)
    return text


def refuse_faulty(text: str, folder: Path) -> None:
    """Raise UsageError if the new description has a fault, as a third-party kind may cause: no faulty file
    is written.
    """
    examination = examine_text(text, folder / "end_effector.yaml")
    faults = list(examination.faults)
    if examination.description is not None:
        faults += (*match_codec(examination.description).faults, *name_faults(examination.description))
    if faults:
        first = faults[0]
        named = f"Name the actuator {first.path[1]!r} otherwise." if first.path[:1] == ("actuators",) else ""
        raise UsageError(f"The description would be invalid: {first.message}.", todo=named)


def _head(folder: Path, *, virtual: bool) -> Iterator[str]:
    place = folder.absolute()
    yield f"# yaml-language-server: $schema={schema_path().name}"
    yield "# Every key that is not written here has a default: docs/reference/keys.md, or `eehal schema`."
    yield "schema: 2"
    yield f"name: {tool_name(place.name)}"
    yield ""
    yield "lines:"
    if virtual:
        yield _key("backend", "virtual", "no hardware: `eehal testbench` plays it")
        yield _key("path", json.dumps(str(place / "chip"), ensure_ascii=False), "is the virtual chip")
    else:
        yield _key("backend", "gpiod", "virtual: no hardware; `eehal run --simulate` does that")


def _link(folder: Path, link: str, port: str, channels: NewChannels, *, virtual: bool) -> Iterator[str]:
    own = str(folder.absolute() / "uart") if virtual else port
    made = "made by the testbench" if virtual else "yours: the serial device of the sensors"
    yield from ("", "link:")
    yield _key("port", json.dumps(own, ensure_ascii=False) if own else "/dev/ttyS0", "" if port else made)
    if has_line(port):
        yield _key("baudrate", "9600" if link == "modbus" else "115200", "yours: bits per second")
    yield frame_line(link, channels)


def _sequence(actuators: Sequence[WantedActuator]) -> Iterator[str]:
    yield ""
    yield (
        f"sequence: [{', '.join(each.name for each in actuators)}]".ljust(_WHAT - 1)
        + " # in the order of a grip"
    )
    yield ""
    yield "actuators:"


def _actuator(each: WantedActuator, number: int, channels: dict[str, str]) -> Iterator[str]:
    fields = each.kind.stanza.model_fields
    yield f"  {each.name}:"
    yield _key("kind", each.kind.name, "", indent=4)
    yield _key("line", f"LINE_{number}", "yours: its name as gpioinfo shows it", indent=4)
    if "channel" not in channels and fields["channel"].is_required():
        channels = {"channel": NO_CHANNEL, **channels}
    for key, channel in channels.items():
        yield _key(key, channel, _meaning(fields[key]), indent=4)
    own = [key for key in fields if key not in Actuator.model_fields and key not in ("kind", *channels)]
    for key in (*_TIMES, *own):
        if isinstance(default := fields[key].default, int | float):
            yield _key(key, json.dumps(default), _meaning(fields[key]), indent=4)


def _changer(number: int) -> Iterator[str]:
    yield from ("", "tool_changer:", _key("line", f"LINE_{number}", "yours: active means unlock"))
    for key in ChangerStanza.BITS:
        field = ChangerStanza.model_fields[key]
        yield _key(key, field.default, _meaning(field))


def _meaning(field: FieldInfo) -> str:
    return field.description or ""


def _key(key: str, value: str, what: str, *, indent: int = 2) -> str:
    line = f"{' ' * indent}{key}: {value}"
    return f"{line.ljust(_WHAT - 1)} # {what}" if what else line


def tool_name(folder: str) -> str:
    """Return a valid tool name made from the name of a folder."""
    name = re.sub(r"[^a-z0-9]+", "_", folder.lower()).strip("_")[:34]
    return name if NAME.fullmatch(name) else f"tool_{name}".rstrip("_")
