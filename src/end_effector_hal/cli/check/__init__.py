"""``eehal check``: everything that is wrong with a description, with its place."""

from ._check import check
