"""The units of one bus that have a model: their requests, physics and power."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, cast

from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.signals import Value

from ._bench import Bench
from ._scenario import did_you_mean
from .devices import MODELS, FrameReader, UnitModel, model_for

if TYPE_CHECKING:
    from end_effector_hal.codecs.modbus import BusCodec

BROADCAST = 0
TERMINALS = (2, 4)
"""Functions that read inputs, to which the sensors of a description are wired."""
Models = Mapping[str, Mapping[int, str]]
"""Names of models by link and unit."""


def chosen_models(text: str | None, description: Description) -> Models:
    """Return the models of the devices that a description names, and those that a text chooses instead.

    Args:
        text: such as ``9=robotiq-2f85``, several with commas, of several links ``arm:9=NAME``; ``9=`` plays the
            description; None: nothing is chosen.

    Raises:
        UsageError: there is no such model, or the bus commands nothing at that unit.
    """
    found: dict[str, dict[int, str]] = {}
    named = {each.line: each.device for each in description.every_output.values()}
    for link, outputs in description.buses.items():
        for line, output in outputs.items():
            device = named.get(line)  # the name of a device in a library
            if device and (model := model_for(device)):
                found.setdefault(link, {})[output.unit] = model.name
    for chosen in filter(None, (text or "").split(",")):
        place, _, name = chosen.partition("=")
        link, _, unit = place.rpartition(":")
        if name and model_for(name) is None:
            raise UsageError(
                f"--model {chosen}: no model is named {name!r}.", todo=did_you_mean(name, MODELS)
            )
        units = {str(each.unit) for each in description.buses.get(link, {}).values()}
        if unit not in units:
            raise UsageError(
                f"--model {chosen}: no output of the tool is at {place!r}.",
                todo=f"Expected: UNIT=NAME or LINK:UNIT=NAME; there are the units {', '.join(sorted(units))}.",
            )
        found.setdefault(link, {}).pop(int(unit), None)
        found[link] |= {int(unit): name} if name else {}
    return found


def text_of(models: Models) -> str:
    """Return the text that chooses these models."""
    return ",".join(
        f"{link and f'{link}:'}{unit}={name}" for link, own in models.items() for unit, name in own.items()
    )


def played_units(description: Description, models: Models) -> Iterator[tuple[str, tuple[str, str | None]]]:
    """Yield how each unit of the commanded buses is played, in words, and its place with the name of its model."""
    for link, outputs in description.buses.items():
        for unit in sorted({each.unit for each in outputs.values()}):
            place, name = f"{link and f'{link}:'}{unit}", models.get(link, {}).get(unit)
            how = f"plays the model of {name}" if name else "plays the description, not the device"
            yield f"unit {place} {how}", (place, name)


def shown_by_models(description: Description, models: Models) -> frozenset[str]:
    """Return the actuators whose pressure sensor is part of a unit that has a model: it has no faults of a sensor."""
    found = set()
    for name, actuator in description.ordered:
        channel = description.channels.get(actuator.channel or "")
        register = channel.modbus if channel else None
        model = models.get(channel.link or "", {}).get(register.unit) if channel and register else None
        if model and _model(model).wire is UnitModel.wire:
            found.add(name)
    return frozenset(found)


class ModelledUnits:
    """Answers for the units of one bus that have a model.

    Args:
        description: says which actuator hangs on which unit.
        link: name of the bus.
        models: names of the models by unit.
        bench: the physics, and the power and the faults of the link.
        obey: called with name and level of an output that a unit begins to drive.

    Raises:
        UsageError: a model cannot drive the kind of its actuator.
    """

    def __init__(
        self,
        description: Description,
        link: str,
        models: Mapping[int, str],
        bench: Bench,
        obey: Callable[[str, bool], None],
    ) -> None:
        self._bench, self._link, self._obey = bench, link or None, obey
        self._outputs = {name: each for name, each in description.buses[link].items() if each.unit in models}
        self._names = {
            (each.unit, _model(models[each.unit]).channel_of(each.address)): name
            for name, each in self._outputs.items()
        }
        self._second = {
            (each.unit, _model(models[each.unit]).channel_of(address)): name
            for name, each in self._outputs.items()
            if (address := _second_coil(each)) is not None
        }
        devices = {line: name for name, line in bench.lines.items()}
        self.models: dict[int, UnitModel] = {}
        """The models by unit."""
        for unit, name in models.items():
            model, own = _model(name), {}
            for (at, channel), output in self._names.items():
                if at == unit and output in devices:
                    own[channel] = bench.devices[devices[output]]
            if not all(isinstance(device, model.physics) for device in own.values()):
                raise UsageError(
                    f"--model {unit}={name}: it cannot drive an actuator of this kind.",
                    todo="Leave it out, and the description is played.",
                )
            self.models[unit] = model(own, self._teller(unit))
        codec = codec_of(description, link)
        reads = cast("BusCodec", codec).reads
        self._wired = [each for each in reads if each.unit in models and each.function in TERMINALS]
        self._alarms = {
            channel: declared.modbus.unit
            for channel, declared in description.channels.items()
            if declared.alarm
            and declared.modbus
            and declared.modbus.unit in models
            and (declared.link or "") == link
        }
        self._frames = FrameReader(line_of(description.links[link], codec)[0])
        self._booted, self._starting = 0, False

    def start(self, levels: Mapping[str, bool], at: int) -> None:
        """Switch the units on at ``at`` (µs); what is active was commanded long ago, by the rows of the description."""
        self._booted, self._starting = self._bench.booted(at, self._link), True
        self.power_up(at)
        for name in self._outputs:
            if levels.get(name):
                self._replay(name, at)
        self._starting = False

    def _replay(self, name: str, at: int) -> None:
        output = self._outputs[name]
        model, activation = self.models[output.unit], output.activation
        rows = [*output.writes(level=True)]
        if activation:
            start = output.address if activation.address is None else activation.address
            rows = [*((start, row) for row in activation.write), *rows]
        for address, row in rows:
            model.write(address, row, at, coils=output.register_type == "coil")
        model.settle()

    @property
    def due(self) -> int | None:
        """Time at which `advance` must be called, µs; None: nothing happens without a message."""
        dues = [due for each in self.models.values() if (due := each.due) is not None]
        restarts = self._bench.restarts_at(self._link)
        if restarts is not None and self._bench.booted(restarts, self._link) != self._booted:
            dues.append(restarts)
        return min(dues, default=None)

    def advance(self, at: int) -> None:
        """Process what the units do without a message by ``at`` (µs): a restart, a watchdog, the end of a motion."""
        if (booted := self._bench.booted(at, self._link)) != self._booted:
            self._booted = booted
            self.power_up(at)
        for model in self.models.values():
            model.advance(at)

    def power_up(self, at: int) -> None:
        """Switch all units off and on again."""
        for model in self.models.values():
            model.power_up(at)

    def owns(self, data: bytes) -> bool:
        """Return whether bytes that a master sent are for one of these units only."""
        return data[0] in self.models

    def answer(self, data: bytes, values: Mapping[str, Value], at: int) -> bytes:
        """Return the answers to the requests that end in ``data``; the physics has reached ``at`` (µs).

        Args:
            values: readings of the sensors that are wired to inputs of the units.
        """
        for read in self._wired:
            words = [0] * read.count  # of an open wire
            for each in read.registers:
                each.put(words, values)
            self.models[read.unit].wire(read.function, read.address, words)
        for channel, unit in self._alarms.items():
            self.models[unit].alarm = self._bench.scenario.alarms.get(channel, 0)
        return b"".join(self._answered(frame, at) for frame in self._frames.feed(data, at))

    def _answered(self, frame: bytes, at: int) -> bytes:
        """Return the answer of the addressed unit; unit 0 addresses all, and none answers, where it is no unit itself
        (over Modbus TCP it may be one).
        """
        unit, pdu = frame[0], frame[1:-2]
        if unit in self.models:
            return self.models[unit].answer(unit, pdu, at)
        for model in self.models.values() if unit == BROADCAST else ():
            model.answer(unit, pdu, at)
        return b""

    def _teller(self, unit: int) -> Callable[[int, bool], None]:
        def tell(channel: int, level: bool) -> None:
            if self._starting:
                return
            if (unit, channel) in self._second:  # the valve stays where a coil has moved it
                if level:
                    self._obey(self._second[unit, channel], False)
            elif (name := self._names.get((unit, channel))) and (level or name not in self._second.values()):
                self._obey(name, level)

        return tell


def _second_coil(output: RegisterOutput) -> int | None:
    """Return the address of the second coil of a valve; None: it has one."""
    if output.opposite is not None:
        return output.opposite.address
    neighbours = output.pulse_s is not None and output.register_type == "coil" and 1 in output.command_off
    return output.address + output.command_off.index(1) if neighbours else None


def _model(name: str) -> type[UnitModel]:
    model = model_for(name)
    assert model is not None
    return model
