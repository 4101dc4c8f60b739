"""Smaller proofs in addition to that of a tool: bus outputs, two coils, process deaths at any time, and Fig. 5.

In the network of the tool, an output with two coils and an output on a bus are one boolean that is written at once.

**Two coils.** The lemma proves the path from that boolean to the device: pulses, pauses, deaths and records of the
line arbiter. It also proves the interface between the two networks: the path takes less time than the network of
the tool allows for it.

**Registers of a bus.** The lemma proves what lies between that boolean and the device: the steps of a command,
lost, late and double answers, and deaths of the line arbiter.

**Fig. 5.** ``fig5.xml`` is proven with the times of a tool, and the tool's grip is compared with it as its
specification. The environment is that of the paper: the tool starts with nothing active, locked, and with supply
pressure; commands are grip and drop; the feedback of an actuator comes while its output is active or never, stays
as long as the output is active, and is gone in time. There is no cancel, no reading that is stale, in between or
lost, no refusal of the line arbiter, no unlock.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from end_effector_hal.arbiter import arbiter_policy
from end_effector_hal.control import model_constants
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.verification.proof import Finding, Progress, Proof, prove
from timed_automata import Network, load_network
from timed_automata.inclusion import Inclusion, Interface, trace_inclusion

COILS_FILE = Path(__file__).with_name("two_coils.xml")
_TODO = {
    "assumed-on": "raise timeout_s (of the tool changer prove_s and unlock_max_s), or shorten pulse_s and pause_s",
    "assumed-off": "raise reset_s and release_s (of the tool changer prove_s), or shorten pulse_s and pause_s",
}


def coil_constants(description: Description) -> dict[str, dict[str, int]]:
    """Return the constants of ``two_coils.xml``, ms, by the name of an actuator with two coils, or ``tool_changer``."""
    policy, changer = arbiter_policy(description), description.tool_changer
    left_s = {
        name: (actuator.line, actuator.timeout_s, min(actuator.reset_s, actuator.release_s))
        for name, actuator in description.ordered
    }
    if changer is not None:
        unlocked_s = changer.prove_s if changer.latching else min(changer.prove_s, changer.unlock_max_s)
        left_s["tool_changer"] = (changer.line, unlocked_s, changer.prove_s)
    return {
        name: {
            "PULSE": policy.opposites[line].pulse_us // 1000,
            "PAUSE": policy.opposites[line].pause_us // 1000,
            "SWITCH": policy.min_switch_us // 1000,
            "LEASE": policy.lease_us // 1000,
            "D": description.bounds.reaction_ms,
            "T_ON": round(on_s * 1000),
            "T_OFF": round(off_s * 1000),
        }
        for name, (line, on_s, off_s) in left_s.items()
        if line in policy.opposites
    }


def coil_networks(description: Description) -> dict[str, Network]:
    """Return the network of each output with two coils, by the same names."""
    return {name: load_network(COILS_FILE, values) for name, values in coil_constants(description).items()}


def prove_tool(
    description: Description,
    network: Network,
    progress: Progress | None = None,
    *,
    most_bytes: int | None = None,
) -> Proof:
    """Prove a tool, and then its outputs with two coils; ids of the latter findings begin with the output's name.

    Args:
        network: the network of its automata, with its constants.
        progress, most_bytes: see `prove`.
    """
    automata = description.automata
    proof = prove(network, progress, executed=automata.executed, most_bytes=most_bytes)
    proven: list[tuple[dict[str, int], Proof]] = []  # many zones have the same times
    for name, values in coil_constants(description).items():
        lemma = next((known for constants, known in proven if constants == values), None)
        if lemma is None:
            lemma = prove(load_network(COILS_FILE, values), progress, most_bytes=most_bytes)
            proven.append((values, lemma))
            proof = replace(
                proof,
                states=proof.states + lemma.states,
                seconds=proof.seconds + lemma.seconds,
                stopped=proof.stopped or lemma.stopped,
            )
        proof = replace(proof, findings=(*proof.findings, *(_named(name, each) for each in lemma.findings)))
    return proof


def _named(name: str, finding: Finding) -> Finding:
    sentence = f"The two coils of {name.replace('_', ' ')}: {finding.sentence}"
    todo = _TODO.get(finding.id) if not finding.holds else None
    remark = "; ".join(filter(None, (finding.remark, todo)))
    return replace(finding, id=f"{name}.{finding.id}", sentence=sentence, remark=remark)


FIG5_FILE = Path(__file__).with_name("fig5.xml")
OBSERVED = ("ee", "command", "actuator", "valve")
"""The variables that are compared: the state, the command, the actuators, and the levels that are requested for the
lines.
"""
_GRIPPING = ("Gripper", "Actuator")
"""The templates of the tool that correspond to Fig. 5."""
_DEVICES = 3
_TIMES_OF_PARTS = ("ATTEMPTS", "T_CONFIRM")
"""By part and actuator; Fig. 5 knows one part."""
_TIMES = ("T_RESET", "T_GONE", "D", "COMMAND_GAP")
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
    for name in _TIMES_OF_PARTS:
        constants[name] = cast("Sequence[Sequence[int]]", constants[name])[0]
    return load_network(FIG5_FILE, {name: constants[name] for name in (*_TIMES, *_TIMES_OF_PARTS)})


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


BUS_FILE = Path(__file__).with_name("bus_output.xml")


def bus_networks(description: Description) -> dict[str, Network]:
    """Return the network of each output on a bus, by its name: ``cup``, ``cup.blow_off``, ``tool_changer``."""
    return {
        ".".join(keys[keys[0] in ("actuators", "outputs") :]): load_network(
            BUS_FILE, output_constants(each.modbus)
        )
        for keys, each in description.every_output.items()
        if each.modbus is not None
    }


def output_constants(output: RegisterOutput) -> dict[str, int]:
    """Return the constants of ``bus_output.xml``, which select the steps of an output's commands."""
    order = output.handshake.order if output.handshake else ""
    return {
        "ACTIVATION": int(output.activation is not None),
        "CARRIES": int(output.commands_activate),
        "SHAKE": {"": 0, "before": 1, "after": 2}[order],
        "VERIFY": int(output.verify is not None),
        "RELEASES": int(output.on_link_loss in ("release", "undefined")),
        "PAIR": int(output.opposite is not None),
    }


DEATHS_FILE = Path(__file__).with_name("deaths.xml")


def death_network(description: Description) -> Network:
    """Return the network of deaths, with the time that a line of the tool takes to settle (IL-10).

    In the network of the tool a program dies once, between two reactions, and requests what the automata decide. Here
    it requests anything, and it and the line arbiter die at any instant, any number of times. The network assumes:

    - While a program reports a held part, it deactivates nothing, and its last will keeps what is active ([held] of
      the tool).
    - It reports a held part only after the arbiter has replied to the write whose last will keeps it, with no
      deactivation waiting.
    - A new program reads the levels of the lines before it writes any.
    """
    return load_network(DEATHS_FILE, {"SETTLE": arbiter_policy(description).min_switch_us // 1000})
