"""Makes the same tool without hardware: a copy of its description on virtual lines and a pty, for the testbench."""

from __future__ import annotations

from pathlib import Path

from ruamel.yaml import YAML

from end_effector_hal.description import Description
from end_effector_hal.errors import os_errors
from end_effector_hal.owned import owned_folder
from end_effector_lab.testbench.inputs import VirtualInputs

from ._places import open_inputs

NAME = "end_effector.yaml"


def write_virtual_copy(description: Description, folder: Path) -> Path:
    """Write the copy and make its virtual chip in ``folder``, which will also contain the port and the socket.

    Returns:
        The path of the copy.

    Raises:
        UsageError: the copy cannot be written.
    """
    folder = folder.absolute()
    with os_errors("Cannot be made", folder):
        owned_folder(folder)
    virtual = description.with_virtual(folder / "chip", str(folder / "uart"), folder / "arbiter.sock")
    write_description(virtual, folder / NAME, "the same tool on virtual lines and a pty")
    chip = open_inputs(None, virtual)
    assert isinstance(chip, VirtualInputs)
    chip.make_chip()
    return folder / NAME


def write_description(description: Description, path: Path, what: str) -> None:
    """Write a description that this program made; the path of its automata is kept. Raises UsageError.

    Args:
        description: the description.
        path: path of the file.
        what: text for its first line.
    """
    content = description.model_dump(mode="json", by_alias=True, exclude_unset=True)
    content["automata"] = {**content.get("automata", {}), "file": str(description.automata_path)}
    with os_errors("Cannot be written", path), path.open("w", encoding="utf-8") as file:
        file.write(f"# Written by eehal: {what}.\n")
        YAML(typ="safe", pure=True).dump(content, file)
