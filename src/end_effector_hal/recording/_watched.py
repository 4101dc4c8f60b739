"""The values that a violated requirement names, over the run: part of ``run.json`` of a counterexample."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from pydantic import FiniteFloat, TypeAdapter, ValidationError


@dataclass(frozen=True, slots=True)
class Watched:
    """The course of a variable, of the location of a process, or of a clock.

    Attributes:
        name: ``evidence[cups]``, ``Gripper``, ``Observer.x``.
        wrong: whether it belongs to the part of the requirement that does not hold at the end.
        values: pairs of a start time, s, and the value from then on, in words; empty for a clock.
        points: for a clock: points (s, s), joined by lines.
        limits: for a clock: the limits with which it is compared, in words and s.
        deadline_s: for a clock: the time at which it passed the violated limit; None: it has not passed a limit.
    """

    name: str
    wrong: bool = False
    values: tuple[tuple[FiniteFloat, str], ...] = ()
    points: tuple[tuple[FiniteFloat, FiniteFloat], ...] = ()
    limits: tuple[tuple[str, FiniteFloat], ...] = ()
    deadline_s: FiniteFloat | None = None

    def document(self) -> dict[str, object]:
        """Return the fields as JSON, without the empty ones."""
        return {key: value for key, value in asdict(self).items() if value not in ((), None)}


_WATCHED = TypeAdapter(Watched)


def read_watched(content: object) -> Watched | None:
    """Return the object in JSON content; None: the content has another form, or no values."""
    try:
        found = _WATCHED.validate_python(content)
    except ValidationError:
        return None
    return found if found.values or found.points else None
