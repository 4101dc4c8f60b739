"""``eehal init``: a folder with a description to start from."""

from ._new_tool import LINKS
