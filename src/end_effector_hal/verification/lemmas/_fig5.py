"""Prove ``fig5.xml`` with the times of a tool, and compare the tool's grip with it as its specification.

The environment is that of the paper: the tool starts with nothing active, locked, and with supply pressure; commands
are grip and drop; the feedback of an actuator comes while its output is active or never, stays as long as the output
is active, and is gone in time. There is no cancel, no reading that is stale, in between or lost, no refusal of the
line arbiter, no unlock.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.control import model_constants
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.verification.proof import Proof, prove
from timed_automata import Network, load_network
from timed_automata.inclusion import Inclusion, Interface, trace_inclusion

FIG5_FILE = Path(__file__).with_name("fig5.xml")
OBSERVED = ("ee", "command", "actuator", "valve")
"""The variables that are compared: the state, the command, the actuators, and the levels that are requested for the
lines.
"""
_GRIPPING = ("Gripper", "Actuator")
"""The templates of the tool that correspond to Fig. 5."""
_DEVICES = 3
_TIMES = ("ATTEMPTS", "T_CONFIRM", "T_RESET", "T_GONE", "D", "COMMAND_GAP")
_ENVIRONMENT = ("Sensor", "Supervisor")  # templates


@dataclass(frozen=True, slots=True)
class Fig5Report:
    """The result of the comparison of a tool with Fig. 5.

    Attributes:
        proof: the proof of ``fig5.xml`` with the times of the tool.
        inclusion: whether every behaviour of the tool is also one of Fig. 5.
    """

    proof: Proof
    inclusion: Inclusion

    @property
    def holds(self) -> bool:
        """Whether both the proof and the inclusion hold."""
        return self.inclusion.holds and all(finding.holds for finding in self.proof.findings)


def compare_with_fig5(description: Description, network: Network) -> Fig5Report:
    """Prove Fig. 5 with the times of a tool, and compare the automata of the tool with it.

    Args:
        description: the tool, with three actuators.
        network: the network of its automata, with its constants.

    Raises:
        UsageError: the tool does not have three actuators.
        ModelError: its automata cannot be compared; the error names the place.
    """
    fig5 = fig5_network(description)
    return Fig5Report(prove(fig5), grips_as_fig5(network, _GRIPPING, fig5))


def fig5_network(description: Description) -> Network:
    """Return the network of Fig. 5 with the times of a tool.

    Raises:
        UsageError: the tool does not have three actuators.
    """
    if len(description.sequence) != _DEVICES:
        what = (
            f"Fig. 5 has {_DEVICES} devices, this tool {len(description.sequence)}: they cannot be compared."
        )
        raise UsageError(what, where=str(description.source))
    constants = model_constants(description)
    return load_network(FIG5_FILE, {name: constants[name] for name in _TIMES})


def grips_as_fig5(network: Network, templates: tuple[str, ...], fig5: Network) -> Inclusion:
    """Check whether each timed trace of a tool in the paper's environment is also a trace of Fig. 5.

    Args:
        network: the network of the tool's automata.
        templates: its templates that correspond to Fig. 5.
        fig5: the network of Fig. 5 with the same times.
    """
    interface = Interface(
        environment=[each.name for each in fig5.processes if each.template in _ENVIRONMENT],
        observed=OBSERVED,
        system=[each.name for each in network.processes if each.template in templates],
        before=["adopt"],
        start={"tool": _number(network, "LOCKED")},
    )
    return trace_inclusion(network, fig5, interface)


def _number(network: Network, name: str) -> int:
    value = network.constants.get(name)
    if not isinstance(value, int):
        raise UsageError(f"The automata have no constant '{name}'.", where=network.document.path)
    return value
