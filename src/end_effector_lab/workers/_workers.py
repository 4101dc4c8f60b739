"""What every kind of workers can do.

Rule 1: A result comes once, as soon as it is there, with its item; the order is that of the ends.
Rule 2: Few items wait in front of the workers, so that a million of them need no memory.
Rule 3: The items of a worker that dies are done by others. An item with which workers die again and again is named by
    a WorkersError, after all others are done.
Rule 4: What a function raises ends the computation, and is raised here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, Self, TypeVar

from end_effector_hal.errors import WorkersError

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")


class Workers(Protocol):
    """Computes on many items; a context manager, which ends what it has started."""

    def each(self, function: Callable[[S, T], R], shared: S, items: Iterable[T]) -> Iterator[tuple[T, R]]:
        """Yield each item with ``function(shared, item)``.

        Args:
            function: of a module, so that other processes find it by its name.
            shared: the same for all items; a worker gets it once.
            items: taken one by one, as workers become free.

        Raises:
            WorkersError: a worker does not fit, all are gone, or some items could not be done.
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


MOST_NAMED = 5


def not_done(items: Iterable[object], died: str) -> WorkersError:
    """The error that names items.

    Args:
        items: that could not be done.
        died: how often their workers died, as a phrase.
    """
    names = [str(getattr(item, "id", item)) for item in items]
    named = "; ".join(names[:MOST_NAMED])
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return WorkersError(
        f"{len(names)} {'item is' if len(names) == 1 else 'items are'} not done, {died}: {named}{more}.",
        todo="All others are done. Is there memory enough for each process?",
    )
