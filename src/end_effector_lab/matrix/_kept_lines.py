"""What was played, a line of JSON each, in a folder that belongs to one tool and one version."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import product_version


def kept_file(
    folder: Path, header: str, kept: str, description: Description, what: str, **more: object
) -> Path:
    """The file of what was played in a folder, which is made if there is none.

    Args:
        folder: of a matrix or a campaign.
        header: name of the file that says what the folder belongs to.
        kept: name of the file with the lines.
        description: the tool.
        what: a noun, such as ``matrix``.
        more: what must be the same besides the tool and the version.

    Raises:
        UsageError: the folder cannot be used, or belongs to something else.
    """
    mark = {"tool": description.name, "description": description.fingerprint(), "version": product_version()}
    marked, path = mark | more, folder / header
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if path.exists() and json.loads(path.read_text(encoding="utf-8")) != marked:
            others = "".join(f", or of another {name}" for name in more)
            raise UsageError(
                f"This folder has the {what} of another tool, or of another version of its description{others}.",
                where=str(folder), todo="Name another folder.",
            )  # fmt: skip
        path.write_text(json.dumps(marked) + "\n", encoding="utf-8")
        (folder / kept).touch()
    except (OSError, ValueError) as error:
        raise UsageError(f"The folder cannot be used: {error}.", where=str(folder)) from None
    return folder / kept


def read_kept(kept: Path) -> list[Mapping[str, Any]]:
    """The lines, without a last one that was cut off by a kill, which goes; raises UsageError."""
    try:
        text = kept.read_text(encoding="utf-8")
        whole, _, torn = text.rpartition("\n")
        if torn:
            kept.write_text(whole + "\n" if whole else "", encoding="utf-8")
        return [json.loads(line) for line in whole.splitlines()]
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(
            f"What was played cannot be read: {error}.", where=str(kept), todo="Name another folder."
        ) from None
