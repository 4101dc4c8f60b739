"""``eehal check``: finds all faults of a description and prints them with their places."""

from ._check import check
