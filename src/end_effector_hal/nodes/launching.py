"""Checks before a start: of a launch file, while it is read, and of a managed node before it activates a tool."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from end_effector_hal.control import Status, load_automata, network_of
from end_effector_hal.description import Description, content_hash, tool_path
from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import changer_is_sensed
from end_effector_hal.vocabulary import ChangerState, EndEffectorState, Evidence

from .interface import load_for_nodes
from .process import guarded

if TYPE_CHECKING:
    from end_effector_hal.verification.proof import Verdict


NAME = "end_effector.launch"


def check_launch(argv: Sequence[str], launcher: str) -> int:
    """Print the name, the fingerprint and the path of the tool, or one sentence why it cannot be launched.

    Args:
        argv: ``--description`` as it was given, ``--file``: the path that the nodes will read, ``--profile``.
        launcher: the program that reads the launch file.

    Returns:
        The exit code.
    """
    return guarded(NAME, lambda: _check(argv, launcher))


def _check(argv: Sequence[str], launcher: str) -> None:
    parser = argparse.ArgumentParser(prog=NAME)
    for option in ("--description", "--file", "--profile"):
        parser.add_argument(option, default="")
    given = parser.parse_args(argv)
    how = f"description:=FILE or profile:=NAME ({launcher} ignores an argument that it does not know)"
    path = tool_path(given.file, given.profile, how=how)
    _is_the_one_meant(given.description, path)
    description = load_for_nodes(path)
    load_automata(description)
    print(_identity(description, path))  # noqa: T201 the launch file reads it


def _is_the_one_meant(given: str, path: Path) -> None:
    """Raise UsageError if ``$PWD`` and the current folder lead from a relative path to different files."""
    meant = Path(given).expanduser()
    if given and not meant.is_absolute() and os.path.realpath(meant) != os.path.realpath(path):
        raise UsageError(
            f"The relative path {given} means {meant.absolute()} here, but $PWD leads to {path}.",
            todo="Give an absolute path.",
        )


def _identity(description: Description, path: Path) -> str:
    return f"{description.name} {description.fingerprint()} {path}"


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
