"""A path on the command line: never an empty one."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click


class PathName(click.Path):
    """Becomes a `Path`; an empty text, as an unset variable of a shell leaves it, is not the current folder."""

    def __init__(self, **options: Any) -> None:
        super().__init__(path_type=Path, **options)

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> str | bytes | os.PathLike[str]:
        """The path; ends in a usage error when it is empty."""
        if value == "":
            self.fail("It is empty. Write '.' for the current folder.", param, ctx)
        return super().convert(value, param, ctx)
