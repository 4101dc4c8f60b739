"""Expands ``device: NAME`` of an output, of a channel, or of a link, while a description is read.

1. The device's channels become channels of the description, named ``<actuator>_<channel>``; names of channels in the
   device's stanza follow, and ``self`` is the actuator.
2. ``unit`` beside ``device``, else the device's own, becomes the unit of all its registers. ``link`` does likewise.
3. A device with several ``outputs`` drives several actuators: ``output`` beside ``device`` names one of them.
   A channel with ``device`` and ``input`` is one of its ``inputs``. The tool changer, a blow-off and a plain output
   use an output as well: its channels and its registers.
4. The device's keys of the link are added to the link that the actuator uses.
5. A link with ``device`` is a sensor: all its channels come with it, under ``links`` as ``<link>_<channel>``.
6. What the description writes under the same names has precedence, key by key. Lists, and the conditions of an
   evidence, are replaced as a whole.

The places of what was added are those in the file of the device, so that a fault names that file. Everything after
this step sees an ordinary description.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from end_effector_hal.description._address import has_line
from end_effector_hal.description._fault import Fault, Keys, Place, Places, UsedDevice
from end_effector_hal.description.model._channels import Channel

from ._library import DeviceLibrary, LibraryDevice, renamed

SERIAL = ("baudrate", "parity", "stopbits")
"""Keys of a link that mean nothing over a network."""
BLOW_OFF = "blow_off"
SELF = "self"
"""Name of the actuator in the file of a device."""
Tree = dict[str, Any]
Bus = dict[str, tuple[Any, Place]]
"""Value and place of ``unit`` and ``link``, as far as they are known."""


@dataclass
class Expansion:
    """What an expansion found.

    Attributes:
        faults: devices that are unknown or cannot be used, and devices that do not fit on one link.
        unusable: the actuators of unknown or unusable devices; their kind is not known.
        refused: paths of stanzas that cannot be judged: what belongs to a device that has no place on a link, and the
            channels of unknown or unusable devices.
    """

    faults: list[Fault] = field(default_factory=list)
    unusable: set[str] = field(default_factory=set)
    refused: set[Keys] = field(default_factory=set)


@dataclass
class _Links:
    """What the devices have added to the links.

    Attributes:
        given: the device that gave a key of a link, by the path of the key.
        placed: device and outputs of each unit, by the path of its link.
    """

    given: dict[Keys, str] = field(default_factory=dict)
    placed: dict[tuple[Keys, str], tuple[str, list[str]]] = field(default_factory=dict)


def expand(tree: Tree, places: Places) -> Expansion:
    """Add to a tree, and to its places, what the devices of its actuators and channels say."""
    done, found, links = Expansion(), dict[str, LibraryDevice | list[Fault] | None](), _Links()
    users = list(_users(tree))
    library = _library(tree, places, done)
    for at, stanza in users:
        wanted, place = str(stanza["device"]), places.value(*at, "device")
        if wanted not in found:
            found[wanted] = library.get(wanted)
        device = found[wanted]
        if isinstance(device, LibraryDevice) and isinstance(tree.setdefault("channels", {}), dict):
            use = _Use(at, device, tree, places, links)
            expanded = {"channels": use.expand_channel, "link": use.expand_link, "links": use.expand_link}
            fine = expanded.get(str(at[0]), use.expand_output)(stanza)
            done.faults += use.faults
            done.refused |= use.refused
        else:
            fine = False
            if device is None and isinstance(stanza["device"], str):
                what, expected = "there is no such device in the library", "a name that `eehal devices` lists"
                hint = library.meant(wanted)
                done.faults.append(Fault.at(place, "EE-230", what, expected=expected, hint=hint))
            if isinstance(device, list):
                done.faults += [replace(each, uses=places.where(*at, "device")) for each in device]
        if not fine:
            done.unusable |= {str(at[1])} if _is_actuator(at) else set()
            done.refused |= set() if _is_actuator(at) else {at}
    return done


def _users(tree: Tree) -> Iterator[tuple[Keys, Tree]]:
    """Yield path and stanza of each link, output or channel that names a device; blow-offs after their actuators."""
    places: list[Keys] = [("link",)]
    for top in ("links", "actuators", "channels", "outputs"):
        stanzas = tree.get(top)
        names = list(stanzas) if isinstance(stanzas, dict) else []
        places += [(top, name) for name in names]
        places += [(top, name, BLOW_OFF) for name in names if top == "actuators"]
    for at in (*places, ("tool_changer",)):
        stanza: Any = tree
        for key in at:
            stanza = stanza.get(key) if isinstance(stanza, dict) else None
        if isinstance(stanza, dict) and stanza.get("device") is not None:
            yield at, stanza


def _is_actuator(at: Keys) -> bool:
    return at[0] == "actuators" and len(at) == 2


def _library(tree: Tree, places: Places, done: Expansion) -> DeviceLibrary:
    written = tree.get("devices")
    if not isinstance(written, str) or not written:
        return DeviceLibrary()
    own = places.file.parent / written
    if not os.path.isdir(own):  # Path.is_dir raises if the name is too long, or may not be looked up
        what, expected = "there is no such folder of devices", "a folder with NAME.yaml"
        done.faults.append(Fault.at(places.value("devices"), "EE-230", what, expected=expected))
    return DeviceLibrary(own, Path(places.name or places.file).parent / written)


class _Use:
    """One output, or channel, that uses a device.

    Args:
        at: the path of its stanza.
        device: the device.
        tree, places: the description, which is changed.
        links: what the devices have added to the links; shared by all uses.
    """

    def __init__(self, at: Keys, device: LibraryDevice, tree: Tree, places: Places, links: _Links) -> None:
        self.faults: list[Fault] = []
        self.refused: set[Keys] = set()
        self._at, self._name = at, "_".join(map(str, at[len(at) > 1 :]))
        self._device, self._tree, self._places, self._links = device, tree, places, links
        self._uses = places.where(*at, "device")
        self._names: dict[str, str] = {SELF: self._name}
        self._overridden: list[str] = []

    def expand_output(self, stanza: Tree) -> bool:
        """Add the device's channels, the keys of its link and those of the actuator; return whether it could.

        Of the keys of the actuator, an output that is none gets the registers only.
        """
        about, written, actuates = self._device.about, stanza.get("modbus"), _is_actuator(self._at)
        if not actuates and not about.outputs:
            what = f"{self._device.name} is no board with outputs that a tool changer, a blow-off or a lamp could use"
            return self._refuse(what, "a device with outputs, or modbus: with the registers")
        output = written if isinstance(written, dict) else {}
        bus = self._bus(unit=self._beside(stanza, output, "unit"), link=self._beside(stanza, output, "link"))
        parts: list[tuple[Keys, Tree, Tree]] = [((), about.channels, about.actuator)]
        if about.outputs or "output" in stanza:
            if (name := self._part(stanza, "output", about.outputs)) is None:
                return False
            chosen = about.outputs[name]
            parts = [(("outputs", name), chosen.channels, chosen.actuator), *parts]
        for _, channels, _ in parts:
            self._names |= {each: f"{self._name}_{each}" for each in channels}
        user = stanza if actuates else self._tree.get("actuators", {}).get(str(self._at[-2:][0]), {})
        kind = str(user.get("kind", about.actuator.get("kind")))
        for source, channels, actuator in parts:
            for channel, fragment in channels.items():
                self._channel(self._names[channel], (*source, "channels", channel), fragment, bus)
            left_out = () if "line" not in stanza else ("modbus",)  # a line drives it instead
            for key in (key for key in actuator if key not in left_out and (actuates or key == "modbus")):
                given = renamed(actuator[key], self._names, (*self._at, key), kind)
                self._put(stanza, (*self._at, key), (*source, "actuator", key), given)
        if "line" not in stanza and isinstance(stanza.get("modbus"), dict):
            self._address(stanza["modbus"], (*self._at, "modbus"), bus)
        if not self._add_link(bus, str(parts[0][0][1]) if len(parts) > 1 else "", drives=True):
            self.refused |= {self._at, *(("channels", name) for name in self._names.values())}
        self._used(self._name)
        return True

    def expand_channel(self, stanza: Tree) -> bool:
        """Add an input of the device to a channel, and the keys of its link; return whether it could."""
        del stanza["device"]
        inputs, written = self._device.about.inputs, stanza.get("modbus")
        if (name := self._part(stanza, "input", inputs)) is None:
            return False
        register = written if isinstance(written, dict) else {}
        place = self._places.value(*self._at, "link")
        bus = self._bus(
            unit=self._beside({}, register, "unit"),
            link=(stanza["link"], place) if "link" in stanza else None,
        )
        self._channel(self._name, ("inputs", name), inputs[name], bus)
        self.refused |= set() if self._add_link(bus) else {self._at}
        self._used(f"channel {self._name}")
        return True

    def expand_link(self, stanza: Tree) -> bool:
        """Add the keys of a sensor's link, and its channels; return whether it is one."""
        about, named = self._device.about, len(self._at) > 1
        if about.actuator or about.outputs or not about.channels:
            what = f"{self._device.name} is no sensor with a link of its own"
            return self._refuse(what, "device under actuators or channels")
        place = self._places.key(*self._at)
        bus = self._bus(unit=self._beside(stanza, {}, "unit"), link=(self._name, place) if named else None)
        unit = str(bus.get("unit", (1,))[0])
        self._links.placed.setdefault((self._at, unit), (self._device.name, [SELF]))
        self._add_keys(stanza, self._at)
        self._names = {each: f"{self._name}_{each}" if named else each for each in about.channels}
        for channel, fragment in about.channels.items():
            name = self._names[channel]
            self._channel(name, ("channels", channel), fragment, bus)
            if named and isinstance(written := self._tree["channels"][name], dict):
                self._address(written, ("channels", name), {"link": bus["link"]})
        self._used(f"link {self._name}" if named else "link")
        return True

    def _add_keys(self, link: Tree, path: Keys) -> None:
        """Add the device's keys of a link."""
        for key, value in self._device.about.link.items():
            if key not in SERIAL or has_line(str(link.get("port"))):
                self._put(link, (*path, key), ("link", key), deepcopy(value))

    def _used(self, by: str) -> None:
        about = self._device.about
        channels = tuple(name for each, name in self._names.items() if each != SELF)
        self._places.devices[by] = UsedDevice(
            self._device.name,
            about.title,
            self._device.path,
            about.confirmed,
            channels,
            tuple(self._overridden),
        )

    def _part(self, stanza: Tree, key: str, known: Mapping[str, Any]) -> str | None:
        """Return which output or input of the device is meant; None, with a fault: there is no such."""
        path: Keys = (*self._at, key if key in stanza else "device")
        wanted, place = stanza.pop(key, None), self._places.value(*path)
        self._places.keys.pop((*self._at, key), None)
        if isinstance(wanted, str) and wanted in known:
            return wanted
        expected = f"{key}: {' or '.join(known)}" if known else f"a device without {key}"
        what = f"{self._device.name} has {'no such' if wanted or not known else 'more than one'} {key}"
        self.faults.append(Fault.at(place, "EE-230", what, expected=expected))
        return None

    def _beside(self, stanza: Tree, register: Tree, key: str) -> tuple[Any, Place] | None:
        """Return the value and the place of ``unit`` or ``link``: beside ``device``, else in ``modbus``."""
        if key in stanza:
            place = self._places.value(*self._at, key)
            del self._places.keys[(*self._at, key)]
            return stanza.pop(key), place
        if key in register:
            return register[key], self._places.value(*self._at, "modbus", key)
        return None

    def _bus(self, **written: tuple[Any, Place] | None) -> Bus:
        unit = self._device.about.unit
        own = {} if unit is None else {"unit": (unit, self._moved(self._device.places.value("unit")))}
        return own | {key: each for key, each in written.items() if each is not None}

    def _channel(self, name: str, source: Keys, fragment: Tree, bus: Bus) -> None:
        channels: Tree = self._tree["channels"]
        path, written = ("channels", name), channels.get(name)
        own = [
            each for each in Channel.SOURCES if isinstance(written, dict) and written.get(each) is not None
        ]
        if own and own[0] not in fragment:
            self._overridden.append(".".join(path))
            return  # a sensor of the user's in place of the device's
        given = deepcopy(fragment)
        alarms = given.get("alarm")
        for each in alarms if isinstance(alarms, list) else ():
            if isinstance(each, dict) and isinstance(each.get("unproven"), list):
                each["unproven"] = [self._names.get(one, one) for one in each["unproven"]]
        self._put(channels, path, source, given)
        if isinstance(channels[name], dict) and isinstance(register := channels[name].get("modbus"), dict):
            self._address(register, (*path, "modbus"), {key: bus[key] for key in bus if key == "unit"})
            self._address(channels[name], path, {key: bus[key] for key in bus if key == "link"})

    def _address(self, target: Tree, path: Keys, bus: Bus) -> None:
        """Add unit and link to the stanza of a register, unless they are written."""
        for key, (value, place) in bus.items():
            if key not in target:
                target[key] = value
                self._places.values[(*path, key)] = place

    def _add_link(self, bus: Bus, output: str = "", *, drives: bool = False) -> bool:
        """Add the device's keys to its link; return whether it has a place there: a link, and a unit of its own."""
        links = self._tree.get("links")
        links = links if isinstance(links, dict) else {}
        written = str(bus["link"][0]) if "link" in bus else None
        chosen = next(iter(links)) if written is None and len(links) == 1 else written
        path: Keys = ("links", str(chosen)) if links else ("link",)
        link = links.get(chosen) if links else self._tree.get("link")
        if (links or written is not None) and chosen not in links:
            missing = f"{self._device.name} needs the name of a link"
            what = missing if written is None else "there is no such link"
            expected = f"link: {' or '.join(links)}" if links else "no name: there is one link"
            return self._refuse(what, expected, bus.get("link"))
        if not isinstance(link, dict):
            return False  # another fault says so
        first, outputs = self._links.placed.setdefault(
            (path, str(bus.get("unit", (1,))[0])), (self._device.name, [])
        )
        if first != self._device.name or (drives and output in outputs):
            what = f"this unit of the link has {first} already"
            what += f", {output}" if output in outputs and output else ""
            return self._refuse(what, "another unit beside device", bus.get("unit"))
        known = bool(outputs)
        outputs.append(output if drives else SELF)
        frame = link.get("frame", {})
        if known or "codec" in link or not isinstance(frame, dict) or frame.keys() - {"modbus"}:
            return True  # another output of it; or another format, and the rules say what does not fit
        self._add_keys(link, path)
        return True

    def _refuse(self, what: str, expected: str, written: tuple[Any, Place] | None = None) -> bool:
        """Report a fault where a value is written; if it is not, or in the device's file, where that is used."""
        place = self._places.value(*self._at, "device")
        place = place if written is None or written[1].file else written[1]
        self.faults.append(Fault.at(place, "EE-230", what, expected=expected))
        return False

    def _put(self, target: Tree, where: Keys, source: Keys, value: Any) -> None:
        """Add a value of the device unless the description writes its key; of two mappings, add key by key."""
        key, linked = str(where[-1]), where[0] in ("link", "links")
        if key not in target:
            target[key] = value
            self._copy_places(source, where)
            if linked:
                self._links.given |= {(*where, *each): self._device.name for each in _leaves(value)}
        elif isinstance(value, dict) and isinstance(target[key], dict) and where[-2] != "evidence":
            for inner, each in value.items():
                self._put(target[key], (*where, inner), (*source, inner), each)
        elif linked and where in self._links.given:
            target[key] = self._agreed(where, target[key], value)
        elif not (linked and target[key] == value):
            self._overridden.append(".".join(map(str, where)))

    def _agreed(self, where: Keys, before: Any, value: Any) -> Any:
        """Return the value of a link's key that fits two devices: periods add up, other times are the longest."""
        key, numbers = str(where[-1]), isinstance(before, int) and isinstance(value, int)
        if key == "period_ms" and numbers:
            return before + value
        if key.endswith("_ms") and numbers:
            return max(before, value)
        if before != value:
            what = f"{self._links.given[where]} needs {key}: {before}, and {self._device.name} on the same link {value}"
            place = self._places.value(*self._at, "device")
            expected = f"{key} written under the link, or a link of its own"
            self.faults.append(Fault.at(place, "EE-230", what, found="", expected=expected))
        return before

    def _moved(self, place: Place) -> Place:
        return replace(place, file=self._device.shown, uses=self._uses)

    def _copy_places(self, source: Keys, where: Keys) -> None:
        size, theirs = len(source), self._device.places
        for mine, those in ((self._places.keys, theirs.keys), (self._places.values, theirs.values)):
            for path, place in those.items():
                if path[:size] == source:
                    mine.setdefault((*where, *path[size:]), self._moved(place))


def _leaves(value: Any, path: Keys = ()) -> list[Keys]:
    if isinstance(value, dict):
        return [leaf for key, each in value.items() for leaf in _leaves(each, (*path, key))]
    return [path]
