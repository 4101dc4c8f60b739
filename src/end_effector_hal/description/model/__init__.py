"""What an end-effector is made of: frozen, typed stanzas."""

from ._description import Description, camel_case, socket_path
from ._stanzas import EStop, Link, ToolChanger

__all__ = ["Description", "EStop", "Link", "ToolChanger", "camel_case", "socket_path"]
