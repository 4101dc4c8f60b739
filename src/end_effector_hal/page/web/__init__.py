"""The page's server: who may see it, who commands, what goes out."""

from ._address import PageAddress
from ._control import ControlLease
from ._guard import Asked, Guard
from ._serve import serve_page

__all__ = ["Asked", "ControlLease", "Guard", "PageAddress", "serve_page"]
