"""The description of an end-effector as frozen, typed objects: the nouns of the YAML file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, PrivateAttr, TypeAdapter
from pydantic_core import CoreSchema, PydanticCustomError, PydanticKnownError, core_schema

from end_effector_hal.description._address import loopback, network_address
from end_effector_hal.description._fault import Place, Places, UsedDevice
from end_effector_hal.description._paths import SHIPPED_AUTOMATA, run_directory
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import get_kind, kind_names, kind_of, usable_kinds
from end_effector_hal.kinds.stanza import (
    Actuator,
    BaseStanza,
    Endings,
    Hold,
    Name,
    Names,
    Opposite,
    Output,
    RegisterOutput,
    Supply,
    Word,
)

from ._channels import Channel, Channels, Inputs
from ._durations import BlowOffTimes, Durations, blow_off_of, durations
from ._stanzas import (
    Automata,
    Bounds,
    EStop,
    Freshness,
    GrippedPart,
    Interlocks,
    Lines,
    Link,
    MaintenanceSettings,
    PlainOutput,
    ToolChanger,
)


class _ByKind:
    """Selects an actuator's stanza by its kind when it is read, since other distributions add kinds."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(_validated)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        stanzas: Any = reduce(or_, (kind.stanza for kind in usable_kinds(kind_names()).values()))
        return handler(TypeAdapter(Annotated[stanzas, Field(discriminator="kind")]).core_schema)


def _validated(value: object) -> Actuator:
    if isinstance(value, Actuator):
        return value
    if not isinstance(value, dict):
        raise PydanticKnownError("dict_type")
    try:
        stanza = get_kind(str(value.get("kind"))).stanza
    except UsageError as error:
        raise PydanticCustomError("kind", "{why}", {"why": str(error)}) from None
    return stanza.model_validate(value)


AnyActuator = Annotated[Actuator, _ByKind()]


class Description(BaseStanza):
    """The description of a whole end-effector."""

    schema_version: Literal[2] = Field(
        default=2, alias="schema", exclude=True, description="version of this schema"
    )
    name: Name = Field(description="of the tool; names its socket and its recordings")
    summary: Word = Field(default="", description="one sentence, for people")
    devices: Word | None = Field(
        default=None,
        exclude=True,
        description="folder with devices of your own, `NAME.yaml` each, relative to this file; they precede the "
        "shipped ones",
    )
    lines: Lines = Field(default=Lines.model_construct(), description="how the output lines are reached")
    link: Link | None = Field(
        default=None, description="the sensor link; absent: `links`, or `channels` are inputs"
    )
    named_links: dict[Name, Link] = Field(
        default={},
        alias="links",
        description="several sensor links by names of your own, each with the keys of `link`",
    )
    channels: Channels = Field(
        default={},
        description="signals by name, where the codec has none: fields of the link, inputs of the board",
    )
    inputs: Inputs | None = Field(default=None, description="how the inputs of the board are read")
    sequence: Names = Field(min_length=1, description="actuators in the order of a grip")
    release_order: Names | None = Field(default=None, description="default: the sequence reversed")
    actuators: dict[Name, AnyActuator] = Field(description="by name")
    parts: dict[Name, GrippedPart] = Field(
        default={},
        description="what is gripped, by name; a grip names one, and the first one is the default. Absent: one part "
        "without a name, gripped by the whole sequence",
    )
    outputs: dict[Name, PlainOutput] = Field(
        default={}, description="beside the grip, by name: lamps, fans, air knives; no step drives them"
    )
    tool_changer: ToolChanger | None = Field(default=None, description="absent: none is fitted")
    e_stop: EStop | None = Field(default=None, description="absent: none is fitted")
    supply: Supply = Field(default=Supply.model_construct(), description="the compressed air")
    hold: Hold = Field(default=Hold.model_construct(), description="what is watched while a part is held")
    maintenance: MaintenanceSettings = Field(
        default=MaintenanceSettings.model_construct(), description="single outputs driven with services"
    )
    endings: Endings = Field(
        default=Endings.model_construct(), description="what each ending does to the outputs"
    )
    interlocks: Interlocks = Field(default=Interlocks.model_construct(), description="true: enforced")
    bounds: Bounds = Field(default=Bounds.model_construct(), description="what the proof assumes and shows")
    automata: Automata = Field(default=Automata.model_construct(), description="the UPPAAL file")

    _places: Places = PrivateAttr(default_factory=lambda: Places(Path("<description>")))
    _of_parts: dict[str, Description] = PrivateAttr(default_factory=dict)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Description:
        """Return a copy with some values changed."""
        copied = super().model_copy(update=update, deep=deep)
        copied._of_parts = {}
        return copied

    @property
    def source(self) -> Path:
        """Absolute path of the file; ``<description>`` if the description was made in code."""
        return self._places.file

    @property
    def used_devices(self) -> Mapping[str, UsedDevice]:
        """The devices of the library by the actuator that uses them."""
        return self._places.devices

    def where(self, *keys: str | int) -> str:
        """Return ``file:line:column`` of a value, or of the nearest written stanza, for an error message."""
        return self._places.where(*keys)

    def key_place(self, *keys: str | int) -> Place:
        """Return the place of a key."""
        return self._places.key(*keys)

    def place(self, *keys: str | int) -> Place:
        """Return the place of a value, or of the nearest written stanza, with its text, for a `Fault`."""
        return self._places.value(*keys)

    @property
    def links(self) -> Mapping[str, Link]:
        """The sensor links by name; a link declared as `link` has the empty name."""
        return self.named_links or ({} if self.link is None else {"": self.link})

    def link_path(self, name: str) -> tuple[str, ...]:
        """Return the keys that lead to the stanza of a link."""
        return ("links", name) if name else ("link",)

    def channels_over(self, name: str) -> dict[str, Channel]:
        """Return the declared channels that come over a link."""
        only = next(iter(self.links)) if len(self.links) == 1 else None
        return {
            channel: each
            for channel, each in self.channels.items()
            if not each.on_board and (only if each.link is None else each.link) == name
        }

    def freshness_of(self, link: str | None) -> Freshness:
        """Return how long a reading of a link is valid; the default for inputs of the board (None)."""
        return self.links.get(link or "") or Freshness()

    def link_name(self, name: str) -> str:
        """Return a link's words: ``sensor link /dev/ttyUSB0``, or ``sensor link left (/dev/ttyUSB0)``."""
        port = self.links[name].port
        return f"sensor link {name} ({port})" if name else f"sensor link {port}"

    @property
    def sensors(self) -> str:
        """The sources of readings in words: ``sensor link /dev/ttyUSB0``, or ``inputs of the board``."""
        board = ["inputs of the board"] if any(each.on_board for each in self.channels.values()) else []
        said = [*map(self.link_name, self.links), *board] or ["inputs of the board"]
        return " or the ".join(said)

    def sensors_are(self, what: str, link: str | None = None) -> str:
        """Return a clause such as ``sensor link /dev/ttyUSB0 is down`` or ``inputs of the board are down``.

        Args:
            what: the state, such as ``down``.
            link: name of the link, if there are several; None: the inputs of the board.
        """
        if not self.named_links:
            return f"{self.sensors} {'is' if self.link else 'are'} {what}"
        return f"inputs of the board are {what}" if link is None else f"{self.link_name(link)} is {what}"

    @property
    def arbiter_inputs(self) -> frozenset[str]:
        """Input lines of the board that interlocks need: the line arbiter reads them itself.

        They are the e-stop, the sensors of the tool changer and those of the tool's stand.
        """
        changer, stop = self.tool_changer, self.e_stop
        asked = {stop.channel} if stop else set()
        if changer:
            asked |= {getattr(changer, key) for key in changer.BITS}
        return frozenset(name for name in asked & self.channels.keys() if self.channels[name].digital)

    def with_inputs(self, names: Collection[str]) -> Description:
        """Return the same tool with only these channels of its board, and all channels of its links."""
        kept = {name: each for name, each in self.channels.items() if name in names or not each.on_board}
        return self.model_copy(update={"channels": kept})

    @property
    def ordered(self) -> tuple[tuple[str, Actuator], ...]:
        """Name and actuator of each step, in the order of a grip."""
        return tuple((name, self.actuators[name]) for name in self.sequence)

    @property
    def part_names(self) -> tuple[str, ...]:
        """Names of the parts, the default first; a tool without `parts` has one without a name."""
        return tuple(self.parts) or ("",)

    @property
    def per_part(self) -> tuple[Description, ...]:
        """The tool as it grips each part, in the order of `part_names`: with the values of the part."""
        return tuple(map(self.for_part, self.part_names))

    def part_number(self, name: str) -> int | None:
        """Return the position of a part; an empty name is the default; None: there is no such part."""
        names = self.part_names
        return 0 if not name else names.index(name) if name in names else None

    def for_part(self, name: str) -> Description:
        """Return the tool as it grips a part; an empty name is the default; raises KeyError for an unknown one.

        Its actuators have the values of that part, and the places of faults are those of these values.
        """
        name = name or self.part_names[0]
        if not name:
            return self
        if name not in self._of_parts:
            self._of_parts[name] = self._changed_for(name)
        return self._of_parts[name]

    def _changed_for(self, name: str) -> Description:
        own = self.parts[name].actuators
        actuators = {
            each: type(stanza).model_validate(
                with_keys(stanza.model_dump(by_alias=True, exclude_unset=True), own[each])
            )
            if each in own
            else stanza
            for each, stanza in self.actuators.items()
        }
        changed = self.model_copy(update={"actuators": actuators, "parts": {}})
        changed._places = self._places.for_part(name)
        return changed

    def uses(self, part: str) -> tuple[bool, ...]:
        """Return for each actuator of the sequence whether it grips a part; an empty name is the default.

        Raises KeyError for an unknown one.
        """
        part = part or self.part_names[0]
        used = self.parts[part].uses if part else None
        return tuple(used is None or name in used for name in self.sequence)

    @property
    def releasing(self) -> tuple[str, ...]:
        """Names of the actuators in the order of a release."""
        return self.release_order if self.release_order is not None else self.sequence[::-1]

    @property
    def durations(self) -> Durations:
        """Longest time of a grip, a release and a cancel: as in ``bounds``, else computed."""
        grips = [
            [step for (_, step), used in zip(tool.ordered, self.uses(name), strict=True) if used]
            for name, tool in zip(self.part_names, self.per_part, strict=True)
        ]
        return durations([step for _, step in self.ordered], grips, self.bounds)

    def endings_of(self, name: str) -> Endings:
        """Return the effect of each ending on one actuator; raises KeyError for an unknown one."""
        return self.actuators[name].endings.over(self.endings)

    @property
    def every_output(self) -> dict[tuple[str, ...], Output]:
        """Every output by its keys: actuators in the order of a grip, the tool changer, blow-offs, plain outputs."""
        found: dict[tuple[str, ...], Output] = {
            ("actuators", name): actuator for name, actuator in self.ordered
        }
        found |= {("tool_changer",): self.tool_changer} if self.tool_changer else {}
        for name, actuator in self.ordered:
            if output := kind_of(actuator).opposing_output(actuator):
                found["actuators", name, kind_of(actuator).opposing] = output
        return found | {("outputs", name): each for name, each in self.outputs.items()}

    @property
    def blow_off_lines(self) -> dict[str, str]:
        """Line of each blow-off valve by its actuator, in the order of a grip."""
        found = ((name, kind_of(actuator).opposing_output(actuator)) for name, actuator in self.ordered)
        return {name: output.line for name, output in found if output}

    @property
    def blow_offs(self) -> dict[str, BlowOffTimes]:
        """Times of the blow-offs that a release drives by actuator, in the order of a grip."""
        found = ((name, blow_off_of(actuator, self.bounds)) for name, actuator in self.ordered)
        return {name: times for name, times in found if times}

    @property
    def opposites(self) -> dict[str, Opposite]:
        """Second coils by the line of their output."""
        outputs: list[Actuator | ToolChanger] = [actuator for _, actuator in self.ordered]
        outputs += [self.tool_changer] if self.tool_changer else []
        return {each.line: each.opposite for each in outputs if each.opposite is not None}

    @property
    def output_lines(self) -> tuple[str, ...]:
        """Every output: actuators in the order of a grip, the tool changer, blow-offs, plain outputs."""
        return tuple(each.line for each in self.every_output.values())

    @property
    def wired_lines(self) -> tuple[str, ...]:
        """Every output line of the board: the outputs that are on no bus, and second coils."""
        lines = (line for line in self.output_lines if line not in self.register_outputs)
        return (*lines, *(each.line for each in self.opposites.values()))

    @property
    def buses(self) -> dict[str, dict[str, RegisterOutput]]:
        """Outputs on each bus that has outputs, by its link; a rule ensures that each output has a link."""
        over = [name for name, link in self.links.items() if link.frame and link.frame.modbus]
        of_each: dict[str, dict[str, RegisterOutput]] = {name: {} for name in over}
        for line, output in self.register_outputs.items():
            name = output.link if output.link is not None else over[0] if over else ""
            of_each.setdefault(name, {})[line] = output
        return {name: outputs for name, outputs in of_each.items() if outputs}

    @property
    def register_outputs(self) -> dict[str, RegisterOutput]:
        """Outputs on all buses by the name used as their `line`."""
        return {each.line: each.modbus for each in self.every_output.values() if each.modbus is not None}

    @property
    def release_us(self) -> dict[str, int]:
        """How long the release of each actuator on a bus takes, µs, by the name used as its `line`."""
        lines = self.register_outputs
        return {
            actuator.line: round(actuator.release_s * 1e6)
            for _, actuator in self.ordered
            if actuator.line in lines
        }

    @property
    def part_outputs(self) -> frozenset[str]:
        """The outputs on buses whose values that make them grip are other ones for some part."""
        found = [tool.register_outputs for tool in self.per_part]
        return frozenset(
            line
            for line, output in self.register_outputs.items()
            if any(each[line].command_on != output.command_on for each in found)
        )

    @property
    def may_be_unknown(self) -> frozenset[str]:
        """Outputs whose state may be unknown at a start."""
        return frozenset((*self.opposites, *self.register_outputs))

    def service_of(self, name: str) -> str:
        """Return the ROS service of an actuator (relative name); raises KeyError for an unknown one."""
        return self.actuators[name].service or "Set" + camel_case(name)

    def output_service_of(self, name: str) -> str:
        """Return the ROS service of a plain output (relative name); raises KeyError for an unknown one."""
        return self.outputs[name].service or "Set" + camel_case(name)

    def topic_of(self, name: str) -> str:
        """Return the ROS topic of an actuator's pressure (relative); raises KeyError for an unknown one."""
        return self.actuators[name].topic or "Pressure" + camel_case(name)

    @property
    def automata_path(self) -> Path:
        """Absolute path of the UPPAAL file: beside the description, or the shipped one.

        The shipped file is used only if the description names none and none exists beside it.
        """
        beside = self.source.parent / self.automata.file
        named = "file" in self.automata.model_fields_set
        return beside.absolute() if named or beside.is_file() else SHIPPED_AUTOMATA

    @property
    def files(self) -> tuple[Path, ...]:
        """Files that the description was read from: its own, the UPPAAL file, and those of its devices."""
        return self.source, self.automata_path, *(each.file for each in self.used_devices.values())

    def with_virtual(
        self, lines_path: str | Path, port: str, socket: str | Path | None = None
    ) -> Description:
        """Return the same tool on virtual lines, other ports, and analog inputs in a folder beside the lines.

        Args:
            lines_path: the file of the virtual chip.
            port: port of the sensor link; with several links, each port is ``port`` with ``_`` and the link's name.
                A port that is an address in a network becomes an address of this machine instead.
            socket: socket of the line arbiter; None: the default one.
        """
        lines = Lines(backend="virtual", path=str(lines_path), socket=str(socket) if socket else None)
        changed: dict[str, object] = {"lines": lines}
        if self.link:
            changed["link"] = _moved(self.link, port)
        if self.named_links:
            changed["named_links"] = {
                name: _moved(link, f"{port}_{name}") for name, link in self.named_links.items()
            }
        if any(channel.analog for channel in self.channels.values()):
            iio = str(Path(lines_path).with_name("iio"))
            changed["inputs"] = (self.inputs or Inputs()).model_copy(update={"iio": iio})
        return self.model_copy(update=changed)

    def with_automata(self, file: str | Path) -> Description:
        """Return the same tool with another UPPAAL file, given as an absolute path."""
        return self.model_copy(update={"automata": self.automata.model_copy(update={"file": str(file)})})

    def with_socket(self, socket: str | Path) -> Description:
        """Return the same tool with another socket for its line arbiter."""
        return self.model_copy(update={"lines": self.lines.model_copy(update={"socket": str(socket)})})

    def fingerprint(self) -> str:
        """Return twelve hex digits of a hash of the content.

        Layout, order of keys and omitted defaults do not change it; the order of the parts does, for the first is the
        default one.
        """
        content = json.dumps(
            self.model_dump(mode="json", by_alias=True), sort_keys=True, separators=(",", ":")
        )
        return hashlib.sha256((content + ",".join(self.parts)).encode()).hexdigest()[:12]


def with_keys(stanza: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of an actuator with those of a part in their place; under ``modbus`` key by key."""
    bus, given = stanza.get("modbus"), own.get("modbus")
    both = {**bus, **given} if isinstance(bus, Mapping) and isinstance(given, Mapping) else given
    return {**stanza, **own, **({"modbus": both} if "modbus" in own else {})}


def _moved(link: Link, port: str) -> Link:
    """Return the link at another port: a path, or an address of this machine that belongs to this path."""
    address = network_address(link.port)
    here = str(loopback(address, port)) if address else port
    return link.model_copy(update={"port": here})


def camel_case(name: str) -> str:
    """Convert ``bottom_vacuum`` to ``BottomVacuum``."""
    return "".join(word.capitalize() for word in name.split("_"))


def socket_path(description: Description) -> Path:
    """Return the Unix socket of the line arbiter: the description's, or ``<name>.sock`` in the run directory.

    Raises:
        WireError: the run directory is not for this user alone.
    """
    if description.lines.socket:
        return Path(description.lines.socket)
    return run_directory() / f"{description.name}.sock"
