"""What other distributions add by an entry point: found by name, and distrusted."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from end_effector_hal._extras import missing_extra
from end_effector_hal.errors import MissingExtraError, UsageError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

LONGEST = 200
LOAD_S = 15.0
"""The longest that the import of a plug-in of another distribution may take."""
Plugin = TypeVar("Plugin")


class Plugins(Generic[Plugin]):
    """Plug-ins of one sort, by name.

    Args:
        group: of the entry points.
        noun: what one of them is called in a sentence, such as ``codec``.
        own: those of this product, as pyproject.toml has them too: they are known without reading any metadata,
            which takes longer than all of the rest; each is imported when it is wanted.
        check: makes a plug-in of what another distribution's entry point names; raises UsageError for what is none.
        make: whether an entry point may name a class of which an object is wanted.
    """

    def __init__(
        self,
        group: str,
        noun: str,
        own: Mapping[str, str],
        check: Callable[[Any], Plugin],
        *,
        make: bool = True,
    ) -> None:
        self._group, self._noun, self._own, self._check, self._make = group, noun, dict(own), check, make
        self._made: dict[str, Plugin] = {}
        self._begun: dict[str, list[Any]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """All that are installed, our own first."""
        return (*self._own, *sorted(self._added().names - set(self._own)))

    def get(self, name: str) -> Plugin:
        """The plug-in of that name, which is made once.

        Raises:
            MissingExtraError: it needs a package of an extra that is not installed.
            UsageError: there is none of that name (with the names that there are), or it cannot be loaded.
        """
        if name in self._own:
            if name not in self._made:
                module, _, attribute = self._own[name].partition(":")
                try:
                    self._made[name] = self._wanted(getattr(importlib.import_module(module), attribute))
                except ModuleNotFoundError as error:
                    raise self._missing_extra(name, error) or error from None
            return self._made[name]
        for entry in self._added().select(name=name):
            try:
                # loaded once: a program that restarts needs it again
                if (known := f"{name}={entry.value}") not in self._made:
                    self._made[known] = self._check(self._load(known, entry))
                return self._made[known]
            except UsageError as error:
                what = f"the {self._noun} {name}: {error.what}"
                raise UsageError(what, where=entry.value, todo=error.todo) from error
            except (Exception, SystemExit, GeneratorExit) as error:  # a plug-in may raise anything
                raise self._missing_extra(name, error) or UsageError(
                    f"the {self._noun} {name} cannot be loaded: {named(error)}",
                    where=entry.value,
                    todo="Repair or remove the distribution that provides it.",
                ) from error
        close = get_close_matches(name, self.names, n=1)
        hint = f"Did you mean {close[0]}? " if close else ""
        raise UsageError(
            f"there is no {self._noun} {name!r}.", todo=f"{hint}There are: {', '.join(self.names)}."
        )

    def _load(self, known: str, entry: EntryPoint) -> Any:
        """What an entry point names; a thread imports what is not ours, and is left behind if that does not end."""

        def load() -> None:
            try:
                done.append(self._wanted(entry.load()))
            except BaseException as error:  # noqa: BLE001 it is raised where the plug-in is wanted
                done.append(error)

        if entry.value.startswith(("end_effector_hal.", "end_effector_lab.")):
            return self._wanted(entry.load())
        if (done := self._begun.get(known, [])) or known not in self._begun:
            done = self._begun[known] = []
            (thread := threading.Thread(target=load, daemon=True)).start()
            thread.join(LOAD_S)
        if not done:
            todo = "Repair or remove the distribution that provides it."
            raise UsageError(f"its import did not end within {LOAD_S:g} s.", todo=todo)
        if isinstance(done[0], BaseException):
            raise done[0]
        return done[0]

    def _missing_extra(self, name: str, error: BaseException) -> MissingExtraError | None:
        if isinstance(error, ModuleNotFoundError):
            return missing_extra(f"The {self._noun} {name} needs", error)
        return None

    def _wanted(self, loaded: Any) -> Any:
        return loaded() if self._make and isinstance(loaded, type) else loaded

    def _added(self) -> EntryPoints:
        found: EntryPoints = importlib.import_module("importlib.metadata").entry_points(group=self._group)
        return found


class PluginError(UsageError):
    """A class of another distribution raised an exception, or returned what it may not."""


T = TypeVar("T")


def attempt(what: str, function: Callable[[], T]) -> T:
    """Call into a plug-in; raises PluginError for whatever it raises, with ``what`` as its subject."""
    try:
        return function()
    except BaseException as error:  # SystemExit as well: it would end a thread in silence
        if isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread():
            raise
        raise PluginError(
            f"{what} failed with {named(error)}.", todo="Report it to the author of that class."
        ) from error


def named(error: BaseException) -> str:
    """An exception of a plug-in in words: its type, and what it says in one line of at most 200 characters."""
    try:
        text = "".join(each if each.isprintable() else " " for each in str(error))[:LONGEST].strip()
    except BaseException:  # noqa: BLE001 its author's code as well
        text = ""
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
