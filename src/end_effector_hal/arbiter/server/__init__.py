"""The arbiter's process: its socket, its connections, and what it replies."""

from ._serve import serve
from ._server import ArbiterServer

__all__ = ["ArbiterServer", "serve"]
