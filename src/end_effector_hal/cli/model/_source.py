"""The network that a command uses: that of a description, or that of a UPPAAL file unchanged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from end_effector_hal.cli._options import PathName
from end_effector_hal.errors import UsageError

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.recording import RunInfo
    from timed_automata import Network


@dataclass(frozen=True)
class Source:
    """A network, and the description whose constants were inserted; ``told``: the constants that are listed for the
    user.
    """

    name: str
    network: Network = field(repr=False)
    description: Description | None
    told: dict[str, object] = field(repr=False)

    def run_info(self, scenario: str = "") -> RunInfo:
        """Return the metadata for a recording of a run, marked as simulated."""
        from end_effector_hal.recording import RunInfo, run_info

        if self.description is None:
            return RunInfo(scenario=scenario, description=Path(self.name).name, simulated=True)
        return replace(run_info(self.description, scenario=scenario), simulated=True)


@dataclass(frozen=True)
class NamedNetwork:
    """The network that the options of a command name.

    Attributes:
        description: of the tool; None: the shipped one.
        model: a UPPAAL file instead.
        coils, registers: name of an output whose own network it is: of its two coils, or of its registers on a bus.
        deaths: whether it is the network in which program and line arbiter die.
    """

    description: Path | None = None
    model: Path | None = None
    coils: str | None = None
    registers: str | None = None
    deaths: bool = False

    def open(self) -> Source:
        """Open the network.

        Raises:
            DescriptionError, ModelError: the file is not valid.
            UsageError: two networks are named, or there is no such output.
        """
        from end_effector_hal.codecs import load_tool
        from end_effector_hal.control import load_automata, model_constants
        from end_effector_hal.description import profile_path
        from timed_automata import load_network

        if len(two := [f"--{name}" for name in _OPTIONS if getattr(self, name) not in (None, False)]) > 1:
            raise UsageError(f"Two networks are named: {two[0]} and {two[1]}.", todo="Leave one of them out.")
        if self.model is not None:
            if self.description is not None:
                raise UsageError("A description and a model are named.", todo="Leave one of them out.")
            network = load_network(self.model)
            return Source(str(self.model), network, None, _told(network))
        path = self.description or profile_path()
        if is_uppaal(path):
            todo = f"Write '--model {path}'."
            raise UsageError("This is a UPPAAL file, not a description.", where=str(path), todo=todo)
        loaded = load_tool(path)
        if two:
            return self._lemma(loaded)
        constants, network = model_constants(loaded), load_automata(loaded)
        told = {name: value for name, value in _told(network).items() if name in constants}
        return Source(str(path), network, loaded, told)

    def _lemma(self, tool: Description) -> Source:
        """Return the network of two coils, of registers, or of deaths, without the description of the tool."""
        from end_effector_hal.verification.lemmas import bus_networks, coil_networks, death_network

        where, network = str(tool.source), death_network(tool) if self.deaths else None
        what, known = "deaths", dict[str, Any]()
        if self.coils is not None:
            what, known = f"the coils of {self.coils}", coil_networks(tool)
            if (network := known.get(self.coils)) is None:
                has = f"Those with two coils are {', '.join(known)}" if known else "None has two coils"
                raise UsageError(f"There is no output {self.coils!r} with two coils. {has}.", where=where)
        elif self.registers is not None:
            what, known = f"the registers of {self.registers}", bus_networks(tool)
            if (network := known.get(self.registers)) is None:
                has = f"Those on a bus are {', '.join(known)}" if known else "None is on a bus"
                raise UsageError(f"{self.registers!r} is not commanded over a bus. {has}.", where=where)
        assert network is not None
        return Source(f"{where}: {what}", network, None, _told(network))


_OPTIONS = {
    "model": click.option(
        "--model", metavar="FILE", type=PathName(), help="A UPPAAL file, with its own constants."
    ),
    "coils": click.option(
        "--coils",
        metavar="NAME",
        help="Instead: the network of the two coils of an actuator, or of tool_changer.",
    ),
    "registers": click.option(
        "--registers",
        metavar="NAME",
        help="Instead: the network of the registers that command an actuator over a bus.",
    ),
    "deaths": click.option(
        "--deaths",
        is_flag=True,
        help="Instead: the network of the line arbiter, in which any process may die at any instant.",
    ),
}


def network_options(*names: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add the argument DESCRIPTION and these options, which become the parameter ``network``, a `NamedNetwork`."""

    def add(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def collected(**values: Any) -> None:
            named = {name: values.pop(name) for name in ("description", *names)}
            command(network=NamedNetwork(**named), **values)

        for name in reversed(names):
            collected = _OPTIONS[name](collected)
        return click.argument("description", type=PathName(), required=False)(collected)

    return add


def _told(network: Network) -> dict[str, object]:
    """Return the global constants; booleans have the type bool."""
    kinds = {name: getattr(symbol, "type", None) for name, symbol in network.scope.symbols.items()}
    return {
        name: _boolean(value) if (kind := kinds[name]) is not None and kind.kind == "bool" else value
        for name, value in network.constants.items()
    }


def _boolean(value: object) -> object:
    return [_boolean(item) for item in value] if isinstance(value, list) else bool(value)


def is_uppaal(path: Path) -> bool:
    """Return whether a file is XML, by its suffix, or else by its first bytes."""
    suffix = path.suffix.lower()
    if suffix in (".xml", ".yaml", ".yml"):
        return suffix == ".xml"
    try:
        with path.open("rb") as file:
            return file.read(64).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<")
    except OSError:
        return False
