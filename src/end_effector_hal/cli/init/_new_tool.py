"""Writes a description of a new tool from the kinds of its actuators and the channels of a link."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from pydantic.fields import FieldInfo

from end_effector_hal.codecs import Codec, codec_names, get_codec, match_codec
from end_effector_hal.description import ToolChanger as ChangerStanza
from end_effector_hal.description import did_you_mean, examine_text, has_line, schema_path
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds.stanza import NO_CHANNEL, Actuator
from end_effector_hal.nodes.interface import name_faults
from end_effector_hal.signals import Kind

from ._init import BOARD, LINKS, NAME, WantedActuator, WantedLink
from ._new_channels import (
    CHANGER_DEFAULTS,
    CHANNELS_HEAD,
    NewChannels,
    channel_lines,
    frame_lines,
    new_channels,
    renamed_channels,
)

_WHAT = 34
"""Column at which the comments of the written description begin."""
_TIMES = ("timeout_s", "reset_s", "attempts", "release_s")
Ask = Callable[[str], str]
"""Asks the user for a value; raises UsageError without a terminal."""


def new_description(
    folder: Path,
    actuators: Sequence[WantedActuator],
    links: Sequence[WantedLink],
    *,
    tool_changer: bool,
    virtual: bool,
    ask: Ask,
) -> str:
    """Return the text of a description that is valid unchanged.

    Args:
        folder: the folder of the description; its name becomes the name of the tool.
        actuators: in the order of a grip. An actuator with `BOARD` is confirmed by inputs of the board, even if no
            such link is requested.
        links: the links that confirm the actuators. An actuator uses the link that it names; the others are
            distributed over the links in turn.
        tool_changer: whether a tool changer is fitted.
        virtual: use virtual lines and a pty in the folder, for the testbench.
        ask: asks for the values that a kind needs and that have no default.

    Raises:
        UsageError: the link carries too few channels, or the description would have a fault.
    """
    named = any(link.name for link in links if link.what != BOARD)
    shares = _shares(actuators, links, tool_changer=tool_changer)
    declaring = (link for link in links if link.what in LINKS and (named or link.what != BOARD))
    changers_link = next(declaring, links[0]) if tool_changer else None
    given: dict[str, dict[str, str]] = {}
    stanzas: list[str] = []
    declared: list[str] = []
    carried: dict[str, Kind] = {}
    air: Mapping[str, Kind] = {}
    for number, (link, share) in enumerate(shares.items()):
        channels = _channels(link, share, tool_changer=link is changers_link)
        given |= channels.given
        if not link.name:
            carried = dict(channels.carried)
            air = {} if link.what in LINKS else carried
        stanzas += _link(folder, link, number, channels, virtual=virtual) if link.what != BOARD else ()
        declared += channel_lines(link.what, link.name, channels) if link.what in LINKS or link.name else ()
        carried |= {name: kind for name, kind in channels.carried.items() if name in CHANGER_DEFAULTS}
    text = "\n".join(
        [
            *_head(folder, virtual=virtual),
            *(["", "links:" if named else "link:"] if stanzas else ()),
            *stanzas,
            *(CHANNELS_HEAD if declared else ()),
            *declared,
            *_sequence(actuators),
            *(
                line
                for number, each in enumerate(actuators, start=1)
                for line in _actuator(each, number, given[each.name], ask)
            ),
            *(_changer(len(actuators) + 1, carried) if tool_changer else ()),
            *_supply(air),
            "",
            "# bounds: grip_s, release_s and cancel_s are computed from the times above; write them to require less.",
            "",
        ]
    )
    refuse_faulty(text, folder)
    return text


def _channels(link: WantedLink, share: Sequence[WantedActuator], *, tool_changer: bool) -> NewChannels:
    """Return the channels of a link for the actuators that it confirms."""
    pairs = [(each.name, each.kind) for each in share]
    if link.what in LINKS:
        return new_channels(pairs, on_board=link.what == BOARD, tool_changer=tool_changer)
    codec = get_codec(link.what)
    chosen = _CodecChannels(codec, tool_changer=tool_changer).given(share)
    if not link.name:
        return NewChannels(dict(codec.channels), chosen)
    return renamed_channels(pairs, chosen, codec.channels, tool_changer=tool_changer)


def _shares(
    actuators: Sequence[WantedActuator], links: Sequence[WantedLink], *, tool_changer: bool
) -> dict[WantedLink, list[WantedActuator]]:
    """Return the actuators of each link; raise UsageError if an actuator fits no link, or a link would
    carry nothing.
    """
    by_name = {link.said: link for link in links}
    if BOARD not in by_name and any(each.link == BOARD for each in actuators):
        by_name[BOARD] = WantedLink(BOARD, BOARD)
    shares: dict[WantedLink, list[WantedActuator]] = {link: [] for link in by_name.values()}
    for number, each in enumerate(actuators):
        if each.link and each.link not in by_name:
            known = [*(name for name in by_name if name != BOARD), f"{BOARD} (inputs of the board)"]
            todo = did_you_mean(each.link, [*by_name, BOARD]) or f"there are: {', '.join(known)}"
            raise UsageError(
                f"{each.name}: no --link is named {each.link!r}.", todo=f"{todo[0].upper()}{todo[1:]}."
            )
        turn = number % len(links)
        choice = [by_name[each.link]] if each.link else [*links[turn:], *links[:turn]]
        fits = (link for link in choice if _fits(link, [*shares[link], each], tool_changer=tool_changer))
        shares[next(fits, choice[0])].append(each)
    idle = [link.said for link, share in shares.items() if not share]
    if idle:
        raise UsageError(
            f"The link {idle[0]!r} would prove no actuator.",
            todo="Name fewer links, or NAME:KIND:LINK for one.",
        )
    return shares


def _fits(link: WantedLink, share: Sequence[WantedActuator], *, tool_changer: bool) -> bool:
    try:
        _channels(link, share, tool_changer=tool_changer)
    except UsageError:
        return False
    return True


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


class _CodecChannels:
    """Assigns the channels of a codec that are still free."""

    def __init__(self, codec: Codec, *, tool_changer: bool) -> None:
        self._codec = codec
        self._free = {
            name: kind
            for name, kind in codec.channels.items()
            if name not in ("supply", "estop_ok") and (name not in CHANGER_DEFAULTS or not tool_changer)
        }

    def given(self, actuators: Sequence[WantedActuator]) -> dict[str, dict[str, str]]:
        """Return a channel or none for each key of each actuator; channels with a matching name are assigned first."""
        found: dict[str, dict[str, str]] = {each.name: {} for each in actuators}
        for exact in (True, False):
            for each in actuators:
                proven = any(asked.key in found[each.name] for asked in each.kind.channels if asked.confirms)
                for asked in each.kind.channels:
                    if (
                        not (proven and not exact)
                        and asked.key not in found[each.name]
                        and (
                            channel := self._choose(
                                each, asked.key, asked.carries, asked.bit_instead, exact=exact
                            )
                        )
                    ):
                        del self._free[channel]
                        found[each.name][asked.key] = channel
        for each in actuators:
            proofs = [asked.key for asked in each.kind.channels if asked.confirms]
            if not any(key in found[each.name] for key in proofs):
                raise UsageError(
                    f"{self._codec.name} has no free channel that can prove {each.name!r}, a {each.kind.name}.",
                    todo="Name fewer actuators, or another --link: "
                    f"{', '.join(each for each in codec_names() if each != self._codec.name)}.",
                )
            for asked in each.kind.channels:
                found[each.name].setdefault(asked.key, NO_CHANNEL)
        return found

    def _choose(
        self, each: WantedActuator, key: str, carries: Kind, bit_instead: bool, *, exact: bool
    ) -> str | None:
        usual = each.kind.stanza.model_fields[key]
        names = [each.name, each.kind.name, "" if usual.is_required() else str(usual.default)]
        if exact or carries is Kind.BIT:
            return next((name for name in names if self._free.get(name) is carries), None)
        switches = [name for name in self._free if bit_instead and not self._means_position(name)]
        return next((name for name, kind in self._free.items() if kind is carries), None) or next(
            (name for name in switches if self._free[name] is Kind.BIT), None
        )

    def _means_position(self, name: str) -> bool:
        return name in CHANGER_DEFAULTS or name.endswith(("_extended", "_retracted"))


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


def _link(
    folder: Path, link: WantedLink, number: int, channels: NewChannels, *, virtual: bool
) -> Iterator[str]:
    """Yield the lines of one link, under its name if it has one; ``number`` counts the links from 0."""
    place, indent = folder.absolute(), 4 if link.name else 2
    if link.name:
        yield f"  {link.name}:"
    uart = f"uart_{link.name}" if link.name else "uart"
    own = str(place / uart) if virtual else link.port
    made = "made by the testbench" if virtual else "yours: the serial device of the sensors"
    port = json.dumps(own, ensure_ascii=False) if own else f"/dev/ttyS{number}"
    yield _key("port", port, "" if link.port else made, indent=indent)
    serial = has_line(link.port)
    if link.what in LINKS:
        if serial:
            yield _key(
                "baudrate",
                "9600" if link.what == "modbus" else "115200",
                "yours: bits per second",
                indent=indent,
            )
        yield from (" " * (indent - 2) + line for line in frame_lines(link.what, channels))
        return
    yield _key("codec", link.what, "docs/reference/codecs.md has the others", indent=indent)
    if serial:
        yield _key("baudrate", str(get_codec(link.what).baudrate), "bits per second", indent=indent)


def _sequence(actuators: Sequence[WantedActuator]) -> Iterator[str]:
    yield ""
    yield (
        f"sequence: [{', '.join(each.name for each in actuators)}]".ljust(_WHAT - 1)
        + " # in the order of a grip"
    )
    yield ""
    yield "actuators:"


def _actuator(each: WantedActuator, number: int, channels: dict[str, str], ask: Ask) -> Iterator[str]:
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
        field = fields[key]
        if field.is_required():
            yield _key(key, ask(f"{each.name}: {key} ({_meaning(field)})"), _meaning(field), indent=4)
        elif isinstance(field.default, int | float):
            yield _key(key, json.dumps(field.default), _meaning(field), indent=4)


def _changer(number: int, carried: Mapping[str, Kind]) -> Iterator[str]:
    yield ""
    yield "tool_changer:"
    yield _key("line", f"LINE_{number}", "yours: active means unlock")
    for key in ChangerStanza.BITS:
        field = ChangerStanza.model_fields[key]
        yield _key(key, field.default if field.default in carried else NO_CHANNEL, _meaning(field))


def _supply(carried: Mapping[str, Kind]) -> Iterator[str]:
    if carried.get("supply") is not Kind.PRESSURE:
        yield ""
        yield "supply:"
        yield _key("channel", NO_CHANNEL, "no sensor of the compressed air: a lack of it is not seen")


def _meaning(field: FieldInfo) -> str:
    return field.description or ""


def _key(key: str, value: str, what: str, *, indent: int = 2) -> str:
    line = f"{' ' * indent}{key}: {value}"
    return f"{line.ljust(_WHAT - 1)} # {what}" if what else line


def tool_name(folder: str) -> str:
    """Return a valid tool name made from the name of a folder."""
    name = re.sub(r"[^a-z0-9]+", "_", folder.lower()).strip("_")[:34]
    return name if NAME.fullmatch(name) else f"tool_{name}".rstrip("_")
