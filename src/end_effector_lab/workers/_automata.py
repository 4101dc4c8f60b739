"""The UPPAAL file of a tool, for machines that have it not."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from pathlib import Path

from end_effector_hal.description import Description


class ShippedAutomata:
    """Travels with what is shared; a worker that has another file, or none, gets this one.

    Args:
        description: whose file is read.

    Raises:
        OSError: it cannot be read.
    """

    def __init__(self, description: Description) -> None:
        self._content = description.automata_path.read_bytes()
        self._here: Path | None = None

    def of(self, description: Description) -> Description:
        """The description with these automata, on this machine."""
        if self._here is None:
            self._here = self._found(description.automata_path)
        return (
            description if self._here == description.automata_path else description.with_automata(self._here)
        )

    def _found(self, path: Path) -> Path:
        if path.is_file() and path.read_bytes() == self._content:
            return path
        folder = Path(tempfile.mkdtemp(prefix="end-effector-hal-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        file = folder / "end_effector.xml"
        file.write_bytes(self._content)
        return file

    def __getstate__(self) -> bytes:
        return self._content

    def __setstate__(self, content: bytes) -> None:
        self._content, self._here = content, None
