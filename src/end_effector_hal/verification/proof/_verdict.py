"""The stored verdict of a proof, found by the hash of the tool and its automata."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import UsageError
from end_effector_hal.owned import open_owned, owned_folder, write_owned
from end_effector_hal.recording import product_version

from ._finding import Proof

_LONGEST_BYTES = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """The stored result of `prove` for a tool.

    Attributes:
        hash: hash of the tool and its automata, see `content_hash`.
        version: version of the product that proved it; another version may check more.
        at: time of the proof, local time, ISO 8601.
        requirements: number of requirements.
        failed, undecided: the ids of those that do not hold, and of those that were not decided.
    """

    hash: str
    version: str
    at: str
    requirements: int
    failed: tuple[str, ...] = ()
    undecided: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether every requirement was decided and holds."""
        return self.requirements > 0 and not self.failed and not self.undecided

    def __str__(self) -> str:
        """Return the verdict as a sentence."""
        at = self.at.replace("T", " ")
        if self.holds:
            return f"All {self.requirements} requirements hold ({at})."
        parts = [
            f"{len(names)} {what} ({', '.join(names[:5])}{', …' if len(names) > 5 else ''})"
            for names, what in ((self.failed, "fail"), (self.undecided, "are not decided"))
            if names
        ]
        return f"Of {self.requirements} requirements {' and '.join(parts)} ({at})."


_VERDICT = TypeAdapter(Verdict)


def proof_verdict(content: str, proof: Proof) -> Verdict:
    """Return the verdict of a proof; ``content``: `content_hash` of the tool from before its network was read."""
    return Verdict(
        hash=content,
        version=product_version(),
        at=datetime.now().astimezone().isoformat(timespec="seconds"),
        requirements=len(proof.findings),
        failed=tuple(each.id for each in proof.findings if each.decided and not each.holds),
        undecided=tuple(each.id for each in proof.findings if not each.decided),
    )


def keep_verdict(verdict: Verdict) -> Path:
    """Write a verdict where `kept_verdict` finds it; raises UsageError if it cannot be written."""
    path = _folder() / f"{verdict.hash}.json"
    try:
        owned_folder(path.parent)
        write_owned(path, _VERDICT.dump_json(verdict, indent=2))
    except OSError as error:
        todo = "Set XDG_STATE_HOME to a folder that only you can write."
        raise UsageError(
            f"The verdict cannot be stored: {error.strerror}.", where=str(path), todo=todo
        ) from None
    return path


def kept_verdict(description: Description) -> Verdict | None:
    """Return the verdict of this version of the product on exactly this tool; None: there is none."""
    hash_now = content_hash(description)
    try:
        with os.fdopen(open_owned(_folder() / f"{hash_now}.json", os.O_RDONLY), "rb") as file:
            verdict = _VERDICT.validate_json(file.read(_LONGEST_BYTES))
    except (OSError, ValidationError):
        return None
    return verdict if (verdict.hash, verdict.version) == (hash_now, product_version()) else None


def _folder() -> Path:
    """Return the folder of the verdicts, below ``$XDG_STATE_HOME``, else ``~/.local/state``."""
    state = os.environ.get("XDG_STATE_HOME") or os.path.expanduser("~/.local/state")
    return Path(state) / "end-effector-hal" / "verdicts"
