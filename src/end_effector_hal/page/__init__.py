"""The live page: a process that follows the programs of a tool by their streams, and shows them in a browser.

Rooms: ``view``, what is shown, computed from records; ``link``, the programs' sockets; ``web``, the server and who may
use it; ``static``, what the browser runs.
"""

from .web import PageAddress, serve_page

__all__ = ["PageAddress", "serve_page"]
