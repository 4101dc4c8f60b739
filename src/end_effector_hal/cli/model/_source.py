"""The network that a command uses: that of a description, or that of a UPPAAL file unchanged."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli._options import PathName
from end_effector_hal.errors import UsageError

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.recording import RunInfo
    from timed_automata import Network

DESCRIPTION = click.argument("description", type=PathName(), required=False)
MODEL = click.option(
    "--model", metavar="FILE", type=PathName(), help="A UPPAAL file, with its own constants."
)
COILS = click.option(
    "--coils",
    metavar="NAME",
    help="Instead: the network of the two coils of an actuator, or of tool_changer.",
)
REGISTERS = click.option(
    "--registers",
    metavar="NAME",
    help="Instead: the network of the registers that command an actuator over a bus.",
)
DEATHS = click.option(
    "--deaths",
    is_flag=True,
    help="Instead: the network of the line arbiter, in which any process may die at any instant.",
)


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


def open_source(
    description: Path | None,
    model: Path | None,
    coils: str | None = None,
    *,
    registers: str | None = None,
    deaths: bool = False,
) -> Source:
    """Open the network of a description (by default the shipped one), or of a UPPAAL file.

    Args:
        description, model: the file.
        coils: use the network of an output with two coils, of this name.
        registers: use the network of an output on a bus, of this name.
        deaths: use the network in which program and line arbiter die.

    Raises:
        DescriptionError, ModelError: the file is not valid.
        UsageError: two networks are named, or there is no such output.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.control import model_constants
    from end_effector_hal.description import profile_path
    from end_effector_hal.runtime import load_automata
    from timed_automata import load_network

    named = {
        "--model": model is not None,
        "--coils": coils is not None,
        "--registers": registers is not None,
        "--deaths": deaths,
    }
    if len(two := [option for option, given in named.items() if given]) > 1:
        raise UsageError(f"Two networks are named: {two[0]} and {two[1]}.", todo="Leave one of them out.")
    if model is not None:
        if description is not None:
            raise UsageError("A description and a model are named.", todo="Leave one of them out.")
        network = load_network(model)
        return Source(str(model), network, None, _told(network))
    path = description or profile_path()
    if is_uppaal(path):
        todo = f"Write '--model {path}'."
        raise UsageError("This is a UPPAAL file, not a description.", where=str(path), todo=todo)
    loaded = load_tool(path)
    if coils is not None:
        return _coils_of(loaded, coils)
    if registers is not None:
        return _registers_of(loaded, registers)
    if deaths:
        return _deaths_of(loaded)
    constants, network = model_constants(loaded), load_automata(loaded)
    told = {name: value for name, value in _told(network).items() if name in constants}
    return Source(str(path), network, loaded, told)


def _coils_of(description: Description, output: str) -> Source:
    from end_effector_hal.verification.lemmas import coil_networks

    networks = coil_networks(description)
    if output not in networks:
        has = f"Those with two coils are {', '.join(networks)}" if networks else "None has two coils"
        raise UsageError(
            f"There is no output {output!r} with two coils. {has}.", where=str(description.source)
        )
    network = networks[output]
    return Source(f"{description.source}: the coils of {output}", network, None, _told(network))


def _registers_of(description: Description, actuator: str) -> Source:
    from end_effector_hal.verification.lemmas import bus_networks

    networks = bus_networks(description)
    if actuator not in networks:
        has = f"Those on a bus are {', '.join(networks)}" if networks else "None is on a bus"
        raise UsageError(f"{actuator!r} is not commanded over a bus. {has}.", where=str(description.source))
    network = networks[actuator]
    return Source(f"{description.source}: the registers of {actuator}", network, None, _told(network))


def _deaths_of(description: Description) -> Source:
    from end_effector_hal.verification.lemmas import death_network

    network = death_network(description)
    return Source(f"{description.source}: deaths", network, None, _told(network))


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
