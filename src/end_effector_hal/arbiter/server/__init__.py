"""The arbiter's process: its socket, its connections, and what it replies."""

from ._server import ArbiterServer, serve
