"""Opens the inputs, sensors and ports that options name, and copies a description to virtual ones."""

from __future__ import annotations

from pathlib import Path

from ruamel.yaml import YAML

from end_effector_hal.codecs import board_inputs, codec_of, line_of
from end_effector_hal.description import Description, Inputs, network_address
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.owned import owned_folder
from end_effector_hal.wires.inputs import input_lines, pulls_of

from ._bench import Bench
from ._ports import Port, PtyPort, SerialPort, ServedPort
from ._scenario import TOOL_CHANGER
from ._sensor_board import BoardSensors
from ._units import chosen_models, text_of
from .inputs import (
    GpioInputs,
    GpioSimInputs,
    LineInputs,
    VirtualInputs,
)

RPI3 = {TOOL_CHANGER: "GPIO19", "bottom": "GPIO16", "cylinder": "GPIO26", "top": "GPIO20"}
"""Board pins 35 to 38 of a Raspberry Pi, by the channel that confirms the actuator on the line."""
RPI3_PORT = "/dev/serial0"
_CHOICES = "Expected: virtual:PATH, gpiod, gpiod:LINE=NAME,..., rpi3 or gpio-sim."


def open_inputs(
    text: str | None, description: Description, *, power_cycle: bool = False, scenario: str = "nominal"
) -> LineInputs:
    """Return the inputs for the lines that a text names; nothing is opened yet.

    Args:
        text: ``virtual:PATH``; ``gpiod``: lines of the same names on this machine; ``gpiod:LINE=NAME,...``: lines of
            other names; ``rpi3``; ``gpio-sim``: simulated lines of this machine's kernel; None: the description's
            virtual chip.
        description: description with the lines.
        power_cycle: make a new virtual chip even if there is one.
        scenario: scenario for the initial levels of a virtual chip.

    Raises:
        UsageError: the text or the scenario cannot be used with this description.
    """
    lines = lines_of(description)
    pulled = pulls_of(input_lines(description))
    if text is None:
        if description.lines.backend != "virtual" or not description.lines.path:
            # Taking a HAL's own output lines as inputs would drop what they hold.
            raise UsageError(
                "the description has no virtual lines: name the lines with --lines.",
                todo=f"{_CHOICES} Or make a copy on virtual lines: eehal testbench --prepare FOLDER DESCRIPTION.",
            )
        text = f"virtual:{description.lines.path}"
    kind, _, rest = text.partition(":")
    if kind == "virtual" and rest:
        # what they are commanded is shown on the chip; so is a blow-off that nothing drives, and what moves nothing
        others = [*description.register_outputs, *description.blow_off_lines.values()]
        plain = [each.line for each in description.outputs.values()]
        lines = [*dict.fromkeys([*lines, *others, *plain])]
        shown = Bench(description, scenario).sample(0) if pulled else {}
        levels = BoardSensors(description, rest).levels(
            shown
        )  # the line arbiter may read them before they are played
        return VirtualInputs(rest, lines, power_cycle=power_cycle, pulled=pulled, levels=levels)
    if power_cycle:
        raise UsageError("only virtual lines can be power-cycled.")
    if kind == "gpiod":
        named = (
            _pairs(rest, lines, f"--lines {text}", "line=NAME") if rest else {line: line for line in lines}
        )
        return GpioInputs(named, text)
    if text == "gpio-sim":
        return GpioSimInputs(lines)
    if text == "rpi3":
        return GpioInputs(_preset(description), text)
    raise UsageError(f"lines cannot be read from {text!r}.", todo=_CHOICES)


def open_sensors(text: str | None, description: Description) -> BoardSensors | None:
    """Return the simulated inputs of the board, or None if the tool has none; nothing is opened yet.

    Args:
        text: text of the lines, as for `open_inputs`.
        description: description with the inputs.

    Raises:
        UsageError: inputs cannot be simulated there.
    """
    if board_inputs(description) is None:
        return None
    kind, _, path = text.partition(":") if text else ("virtual", "", description.lines.path or "")
    if input_lines(description) and not (kind == "virtual" and path):
        raise UsageError(
            f"digital inputs of the board cannot be simulated at {text!r}.", todo="Expected: virtual:PATH."
        )
    if any(channel.analog for channel in description.channels.values()):
        folder = description.inputs.iio if description.inputs else Inputs().iio
        if Path(folder).is_relative_to("/sys"):
            raise UsageError(
                "analog inputs cannot be simulated in the kernel's own folder.",
                where=description.where("inputs", "iio"),
                todo="--prepare FOLDER writes a copy of the tool with a folder of its own.",
            )
    return BoardSensors(description, path)


def open_ports(text: str | None, description: Description, lines: str | None) -> dict[str, Port]:
    """Return the ports that a text names, by the names of the links; nothing is opened yet.

    Args:
        text: ``pty:PATH``: a new pty with a symbolic link at PATH; ``PATH``: a serial device; ``tcp://HOST:PORT`` and
            the like: an address of this machine; for several links ``NAME=PORT,...``; None: a pty at every port of the
            description for virtual lines (where it is an address, that address), ``/dev/serial0`` for ``rpi3``.
        description: description with the links.
        lines: the text of the lines.

    Raises:
        UsageError: no port is given and no default exists, or a name is wrong.
    """
    links = description.links
    if not links and board_inputs(description):
        if text is not None:
            raise UsageError(
                f"{description.name} has no sensor link: there is nothing for --port {text}.",
                todo="Leave out --port.",
            )
        return {}
    texts = _port_texts(text, [*links])
    return {name: _port(texts.get(name), description, name, lines) for name in links}


def _port_texts(text: str | None, links: list[str]) -> dict[str, str]:
    if text is None:
        return {}
    if len(links) == 1:
        return {links[0]: text}
    return _pairs(text, links, f"--port {text}", "link=PORT")


def _port(text: str | None, description: Description, name: str, lines: str | None) -> Port:
    link = description.links[name]
    settings = line_of(link, codec_of(description, name))
    if text is not None:
        if address := network_address(text):
            return ServedPort(address)
        kind, _, rest = text.partition(":")
        return PtyPort(rest) if kind == "pty" and rest else SerialPort(text, *settings)
    if lines == "rpi3" and not name:
        return SerialPort(RPI3_PORT, *settings)
    if lines is None or lines.startswith("virtual"):
        address = network_address(link.port)
        return ServedPort(address) if address else PtyPort(link.port)
    raise UsageError("the testbench has no serial port.", todo="Give --port PATH.")


def lines_of(description: Description) -> list[str]:
    """Return the lines that move something: the tool changer, the actuators and the blow-offs."""
    changer = [description.tool_changer.line] if description.tool_changer else []
    second = [each.line for each in description.opposites.values()]
    lines = [*changer, *(actuator.line for _, actuator in description.ordered), *second]
    lines += [each.line for each in description.blow_offs.values()]
    return [line for line in lines if line not in description.register_outputs]


def _pairs(text: str, names: list[str], option: str, form: str) -> dict[str, str]:
    """Return what ``NAME=VALUE,...`` gives to each of the names; raises UsageError."""
    pairs = dict(pair.partition("=")[::2] for pair in text.split(","))
    if set(pairs) != set(names) or not all(pairs.values()):
        noun, _, value = form.partition("=")
        kind = "gpiod:" if "gpiod:" in option else ""
        expected = kind + ",".join(f"{name}={value}" for name in names)
        raise UsageError(f"{option} does not name each {noun} once.", todo=f"Expected: {expected}.")
    return pairs


def _preset(description: Description) -> dict[str, str]:
    channels = {actuator.line: actuator.channel for _, actuator in description.ordered}
    if description.tool_changer:
        channels[description.tool_changer.line] = TOOL_CHANGER
    if unknown := [line for line, channel in channels.items() if channel not in RPI3]:
        raise UsageError(
            f"the preset rpi3 has no pin for {', '.join(unknown)}.", todo="Use --lines gpiod:LINE=NAME,..."
        )
    return {line: RPI3[channel] for line, channel in channels.items()}


NAME = "end_effector.yaml"


def write_virtual_copy(description: Description, folder: Path) -> Path:
    """Write the copy and make its virtual chip in ``folder``, which will also contain the port and the socket.

    Returns:
        The path of the copy.

    Raises:
        UsageError: the copy cannot be written.
    """
    folder = folder.absolute()
    with os_errors("Cannot be made", folder):
        owned_folder(folder)
    virtual = description.with_virtual(folder / "chip", str(folder / "uart"), folder / "arbiter.sock")
    models = text_of(chosen_models(None, description))
    what = "the same tool on virtual lines and simulated ports"
    write_description(
        virtual, folder / NAME, what + (f" (eehal testbench --model {models})" if models else "")
    )
    chip = open_inputs(None, virtual)
    assert isinstance(chip, VirtualInputs)
    chip.make_chip()
    return folder / NAME


def write_description(description: Description, path: Path, what: str) -> None:
    """Write a description that this program made; the path of its automata is kept. Raises UsageError.

    Args:
        path: path of the file.
        what: text for its first line.
    """
    content = description.model_dump(mode="json", by_alias=True, exclude_unset=True)
    content["automata"] = {**content.get("automata", {}), "file": str(description.automata_path)}
    yaml = YAML(typ="safe", pure=True)
    yaml.representer.sort_base_mapping_type_on_output = False  # the first part is the default one
    yaml.width = 10_000  # a stanza on a line
    with os_errors("Cannot be written", path), path.open("w", encoding="utf-8") as file:
        file.write(f"# Written by eehal: {what}.\n")
        yaml.dump(content, file)
