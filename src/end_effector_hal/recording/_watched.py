"""What a violated requirement speaks of, over the run that violates it: stands in ``run.json`` of a counterexample."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from pydantic import FiniteFloat, TypeAdapter, ValidationError


@dataclass(frozen=True, slots=True)
class Watched:
    """A variable, the location of a process, or a clock.

    Attributes:
        name: ``evidence[cups]``, ``Gripper``, ``Observer.x``.
        wrong: whether it is in the part that does not hold at the end.
        values: from when on, s, it is what, in words; none of a clock.
        points: of a clock: (s, s), joined by lines.
        limits: of a clock: what it is compared with, in words and s.
        deadline_s: of a clock: when it passed the limit that does not hold; None: it has passed none.
    """

    name: str
    wrong: bool = False
    values: tuple[tuple[FiniteFloat, str], ...] = ()
    points: tuple[tuple[FiniteFloat, FiniteFloat], ...] = ()
    limits: tuple[tuple[str, FiniteFloat], ...] = ()
    deadline_s: FiniteFloat | None = None

    def document(self) -> dict[str, object]:
        """As JSON; what is empty is left out."""
        return {key: value for key, value in asdict(self).items() if value not in ((), None)}


_WATCHED = TypeAdapter(Watched)


def read_watched(content: object) -> Watched | None:
    """From JSON; None: it is something else, or holds no value at all."""
    try:
        found = _WATCHED.validate_python(content)
    except ValidationError:
        return None
    return found if found.values or found.points else None
