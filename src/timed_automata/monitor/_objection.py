"""What a monitor has to say against a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

ObjectionKind = Literal["no run", "missed", "requirement"]


@dataclass(frozen=True, slots=True)
class Objection:
    """One finding about a run.

    Attributes:
        at: when, in the time of the run.
        kind: ``no run``: the network does not allow it; ``missed``: a reaction bound was exceeded, as
            recorded; ``requirement``: a query ``A[]`` of the file did not hold.
        what: in words.
    """

    at: int
    kind: ObjectionKind
    what: str
