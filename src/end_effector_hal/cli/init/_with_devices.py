"""Writes a description of a new tool whose actuators are devices of the library."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from end_effector_hal.description import DeviceLibrary, LibraryDevice, schema_path
from end_effector_hal.errors import UsageError

from ._init import WantedActuator
from ._new_tool import refuse_faulty, tool_name


def description_with_devices(
    folder: Path, actuators: Sequence[WantedActuator], ports: Mapping[str, str], *, virtual: bool
) -> str:
    """Return the text of a description that is valid unchanged.

    Args:
        folder: the folder of the description; its name becomes the name of the tool.
        actuators: in the order of a grip.
        ports: those of their links, by name; "": the usual one.
        virtual: use virtual lines and a pty in the folder, for the testbench.

    Raises:
        UsageError: an actuator is no device, only some name a link, or the description would have a fault.
    """
    if kinds := [each.name for each in actuators if not each.device]:
        raise UsageError(
            f"{kinds[0]} is a kind, and others are devices.",
            todo="Name only devices, then add the others to the file; or only kinds.",
        )
    if len(ports) > 1 and "" in ports:
        raise UsageError("Only some of the actuators name a link.", todo="Write NAME:DEVICE:LINK for all.")
    text = "\n".join(
        (*_head(folder, virtual=virtual), *_links(folder, ports, virtual=virtual), *_body(actuators), "")
    )
    refuse_faulty(text, folder)
    return text


def _head(folder: Path, *, virtual: bool) -> Iterator[str]:
    place = folder.absolute()
    yield f"# yaml-language-server: $schema={schema_path().name}"
    yield f"name: {tool_name(place.name)}"
    if virtual:
        yield f"lines: {{backend: virtual, path: {json.dumps(str(place / 'chip'), ensure_ascii=False)}}}"


def _links(folder: Path, ports: Mapping[str, str], *, virtual: bool) -> Iterator[str]:
    if "" not in ports:
        yield "links:"
    for number, (name, port) in enumerate(ports.items()):
        own = str(folder.absolute() / (f"uart_{name}" if name else "uart")) if virtual else port
        said = json.dumps(own, ensure_ascii=False) if own else f"/dev/ttyUSB{number}"
        yield f"  {name}: {{port: {said}}}" if name else f"link: {{port: {said}}}"


def _body(actuators: Sequence[WantedActuator]) -> Iterator[str]:
    yield f"sequence: [{', '.join(each.name for each in actuators)}]"
    yield "actuators:"
    taken: dict[tuple[str, int], list[tuple[str, str]]] = {}
    for each in actuators:
        keys = [
            f"device: {each.device}",
            *_place(each, taken),
            *([f"link: {each.link}"] if each.link else []),
        ]
        yield f"  {each.name}: {{{', '.join(keys)}}}"
    yield "supply: {channel: none}"


def _place(each: WantedActuator, taken: dict[tuple[str, int], list[tuple[str, str]]]) -> Iterator[str]:
    """Yield the keys of an output that is free, on the first unit of the link that no other device has.

    ``taken`` holds device and output of those before it, by link and unit.
    """
    device = DeviceLibrary().get(each.device)
    assert isinstance(device, LibraryDevice)  # it was when it was named
    unit = own = 1 if device.about.unit is None else device.about.unit
    outputs = [(each.device, output) for output in device.about.outputs or ("",)]
    while not (free := _free(outputs, taken.setdefault((each.link, unit), []))):
        unit += 1
    taken[each.link, unit].append(free[0])
    yield from [f"output: {free[0][1]}"] if free[0][1] else []
    yield from [f"unit: {unit}"] if unit != own else []


def _free(outputs: list[tuple[str, str]], taken: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the outputs that are not taken; none if another device is at this unit."""
    return [each for each in outputs if each not in taken and all(used in outputs for used in taken)]
