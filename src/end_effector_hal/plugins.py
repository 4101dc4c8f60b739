"""Plug-ins that other distributions add by an entry point: found by name, and never trusted."""

from __future__ import annotations

import importlib
import sys
import threading
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from end_effector_hal._extras import missing_extra
from end_effector_hal.errors import MissingExtraError, UsageError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoints

FOLDER = Path(sys.prefix) / "plugins"
"""What `eehal plugin add` has put into this environment, a folder for each."""
LONGEST = 200
Plugin = TypeVar("Plugin")


def added_folders() -> tuple[Path, ...]:
    """Return the folder of each plug-in that `eehal plugin add` has added; from then on they are in `sys.path`."""
    found = tuple(sorted(each for each in FOLDER.glob("[!.]*") if each.is_dir()))
    # last: they hide nothing
    sys.path += [str(each) for each in found if str(each) not in sys.path]
    return found


class Plugins(Generic[Plugin]):
    """Plug-ins of one sort, by name.

    Args:
        group: the group of the entry points.
        noun: the name of one plug-in in a sentence, such as ``codec``.
        own: the plug-ins of this product, which pyproject.toml also lists. They are found without reading any
            metadata, because that takes longer than everything else; each is imported when it is needed.
        check: converts the object that a foreign entry point names into a plug-in; raises UsageError if it is not one.
        make: whether an entry point may name a class, which is then instantiated.
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

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all installed plug-ins, those of this product first."""
        return (*self._own, *sorted(self._added().names - set(self._own)))

    def get(self, name: str) -> Plugin:
        """Return the plug-in of this name; it is created once.

        Raises:
            MissingExtraError: the plug-in needs a package of an extra that is not installed.
            UsageError: no plug-in has this name (the error lists the known names), or it cannot be loaded.
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
                    self._made[known] = self._check(self._wanted(entry.load()))
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

    def _missing_extra(self, name: str, error: BaseException) -> MissingExtraError | None:
        if isinstance(error, ModuleNotFoundError):
            return missing_extra(f"The {self._noun} {name} needs", error)
        return None

    def _wanted(self, loaded: Any) -> Any:
        return loaded() if self._make and isinstance(loaded, type) else loaded

    def _added(self) -> EntryPoints:
        added_folders()
        found: EntryPoints = importlib.import_module("importlib.metadata").entry_points(group=self._group)
        return found


class PluginError(UsageError):
    """A class of another distribution raised an exception, or returned a value that is not allowed."""


T = TypeVar("T")


def attempt(what: str, function: Callable[[], T]) -> T:
    """Call into a plug-in; raise its exceptions as PluginError, whose message begins with ``what``."""
    try:
        return function()
    except BaseException as error:  # SystemExit as well: it would end a thread in silence
        if isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread():
            raise
        raise PluginError(
            f"{what} failed with {named(error)}.", todo="Report it to the author of that class."
        ) from error


def named(error: BaseException) -> str:
    """Return an exception of a plug-in as one line: its type and its message, cut to 200 characters."""
    try:
        text = "".join(each if each.isprintable() else " " for each in str(error))[:LONGEST].strip()
    except BaseException:  # noqa: BLE001 its author's code as well
        text = ""
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
