"""The lemma of two coils: its network for each output with two coils, and its proof in addition to that of the tool.

In the network of the tool such an output is one boolean that is written at once. This lemma proves the path from that
boolean to the device: pulses, pauses, deaths and records of the line arbiter. It also proves the interface between the
two networks: the path takes less time than the network of the tool allows for it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from end_effector_hal.arbiter import arbiter_policy
from end_effector_hal.description import Description
from end_effector_hal.verification.proof import Finding, Progress, Proof, prove
from timed_automata import Network, load_network

COILS_FILE = Path(__file__).with_name("two_coils.xml")
_TODO = {
    "assumed-on": "raise timeout_s (of the tool changer prove_s and unlock_max_s), or shorten pulse_s and pause_s",
    "assumed-off": "raise reset_s and release_s (of the tool changer prove_s), or shorten pulse_s and pause_s",
}


def coil_constants(description: Description) -> dict[str, dict[str, int]]:
    """Return the constants of ``two_coils.xml``, ms, by the name of an actuator with two coils, or ``tool_changer``."""
    policy, changer = arbiter_policy(description), description.tool_changer
    left_s = {
        name: (part.line, part.timeout_s, min(part.reset_s, part.release_s))
        for name, part in description.ordered
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
        description: the tool.
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
