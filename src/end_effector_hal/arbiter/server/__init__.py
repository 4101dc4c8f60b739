"""The process of the line arbiter: its socket, its connections and its replies."""

from ._server import ArbiterServer, serve
