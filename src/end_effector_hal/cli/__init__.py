"""The command line ``eehal``: a thin face; each command is a module of its own, loaded when it is used."""

from ._figures import figures
from ._main import main
from ._options import PathName, end_in_order

__all__ = ["PathName", "end_in_order", "figures", "main"]
