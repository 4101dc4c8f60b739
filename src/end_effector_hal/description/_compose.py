"""Limits on what is read at all: the reader is slow, and nobody needs so much to describe a tool."""

from __future__ import annotations

from typing import Any

from ruamel.yaml.composer import Composer

DEPTH = 20
"""Levels of lists and mappings."""
NODES = 5_000
"""Keys and values of a file, and of what its aliases unfold to."""


class TooManyValuesError(Exception):
    """There is one more than `NODES`, at ``index`` of the text."""

    def __init__(self, index: int) -> None:
        super().__init__(index)
        self.index = index


class CountingComposer(Composer):
    """Stops reading as soon as there is too much, before the rest is looked at."""

    count = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """One more key, value or alias."""
        self.count += 1
        if self.count > NODES:
            raise TooManyValuesError(self.parser.peek_event().start_mark.index)
        return super().compose_node(parent, index)
