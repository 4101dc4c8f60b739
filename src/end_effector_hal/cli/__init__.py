"""The command line ``eehal``: a thin face; each command is a module of its own, loaded when it is used."""

from ._main import main

__all__ = ["main"]
