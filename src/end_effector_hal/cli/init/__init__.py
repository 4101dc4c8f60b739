"""``eehal init``: writes a folder with a description to start from."""

from ._init import LINKS
