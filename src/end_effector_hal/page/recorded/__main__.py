"""Answers requests of the live page about recordings, in a separate process so that a large one cannot block the page.

``list FOLDER``, ``history FOLDER DESCRIPTION``, ``show FOLDER DESCRIPTION ID``, ``judge FOLDER DESCRIPTION ID``: JSON
on stdout, progress on stderr; exit code 2 with an error message on stderr if nothing can be shown.
"""

from __future__ import annotations

import sys
from pathlib import Path

from pydantic_core import to_json

from end_effector_hal._extras import missing_extra
from end_effector_hal.codecs import load_tool
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import RunFile

from ._document import read_recording
from ._files import RecordingFiles
from ._folder import PROGRESS, has_links, list_recordings, recording_folders
from ._history import read_history
from ._summary import judge_recording
from ._tables import RecordedTables


def answer(word: str, folder: Path, description: str = "", id_: str = "") -> bytes:
    """Return the JSON to print; raises ReportedError."""
    if word == "list":
        return to_json(list_recordings(folder))
    folders = recording_folders(folder)
    if word == "history":
        own = [path for path in folders.values() if not has_links(path)]
        return to_json(read_history(load_tool(description), own).as_json())
    path = folders.get(id_)
    if path is None:
        raise UsageError("There is no such recording.")
    if has_links(path):
        raise UsageError("The recording contains symbolic links, which are not followed.")
    files: RecordingFiles | RecordedTables
    if any(path.glob("*.mcap")) or not (path / RunFile.STATES).exists():
        files = RecordingFiles(path)
    else:
        files = RecordedTables(path, load_tool(description))
    found = read_recording(files, progress=_tell).document if word == "show" else judge_recording(files)
    return to_json(found, fallback=dict)


def _tell(share: float) -> None:
    sys.stderr.write(f"{PROGRESS}{share:.2f}\n")


def _main() -> int:
    word, folder, *rest = sys.argv[1:]
    try:
        found = answer(word, Path(folder), *rest)
    except ReportedError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    except ModuleNotFoundError as error:
        if (missing := missing_extra("A trace needs", error)) is None:
            raise
        sys.stderr.write(f"{missing}\n")
        return 2
    except MemoryError:
        sys.stderr.write("The recording is too large to be shown.\n")
        return 2
    sys.stdout.buffer.write(found)
    return 0


if __name__ == "__main__":
    sys.exit(_main())
