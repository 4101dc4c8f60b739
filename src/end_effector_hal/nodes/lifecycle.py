"""Checks of a managed node before it activates a tool: its proof, and whether its sensors show its state."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from end_effector_hal.control import Status, network_of
from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import changer_is_sensed
from end_effector_hal.vocabulary import ChangerState, EndEffectorState, Evidence

if TYPE_CHECKING:
    from end_effector_hal.verification.proof import Verdict


def require_proof(description: Description, *, prove_now: bool) -> Verdict:
    """Return the verdict on exactly this tool; raises UsageError if there is none, or if it is negative.

    Args:
        description: the tool.
        prove_now: whether to prove it if no verdict is stored, which takes seconds.
    """
    from end_effector_hal.verification.lemmas import prove_tool
    from end_effector_hal.verification.proof import keep_verdict, kept_verdict, proof_verdict

    verdict = kept_verdict(description)
    if verdict is None and prove_now:
        content = content_hash(description)
        proof = prove_tool(description, network_of(description))
        verdict = proof_verdict(content, proof)
        if content_hash(description) != content:
            what = "The description or its automata have changed while they were proven."
            raise UsageError(what, where=str(description.source), todo="Configure again.")
        if not proof.stopped:
            with suppress(UsageError):  # the next one proves it again, then
                keep_verdict(verdict)
    if verdict is None:
        raise UsageError(
            f"No proof is stored of {description.name} as it is now.",
            where=str(description.source),
            todo="Run `eehal verify` on it as this user, or set the parameter prove to true; `hal` asks for no proof.",
        )
    if not verdict.holds:
        raise UsageError(str(verdict), where=str(description.source), todo="`eehal verify` shows why.")
    return verdict


def what_is_missing(description: Description, status: Status) -> tuple[str, ...]:
    """Return clauses with the reasons why a tool is not ready, and its alarms; empty: it is ready."""
    pairs = zip(description.sequence, status.evidence, strict=True)
    unknown = [name for name, level in pairs if level == Evidence.UNKNOWN]
    lacks: list[str] = []
    if not status.link_up:
        silent = f"no frame comes over the {description.sensors}"
        lacks.append(silent if description.links else "the inputs of the board are not read")
    elif status.ee == EndEffectorState.OFF:
        lacks.append("its lines are not adopted")
    elif unknown:
        lacks.append(f"its sensors do not show {', '.join(unknown)}")
    elif status.changer == ChangerState.UNKNOWN and changer_is_sensed(description):
        lacks.append("its sensors do not show whether the tool is locked")
    return (*lacks, *(alarm.rstrip(".") for alarm in status.alarm_texts if lacks))
