"""Standard output, for people or for programs."""

from __future__ import annotations

import json
import os
import sys


class Voice:
    """Says a line at a time, at once; when nobody reads any more it goes on in silence.

    Args:
        as_json: each line is a JSON object.
    """

    def __init__(self, *, as_json: bool = False) -> None:
        self._as_json = as_json

    def say(self, text: str, **fields: object) -> None:
        """``text`` for people, ``fields`` for programs."""
        line = json.dumps(fields, separators=(",", ":")) if self._as_json else text
        self._write(line, 1)

    def refuse(self, text: str) -> None:
        """To standard error (with JSON: ``{"refused": …}`` to standard output)."""
        if self._as_json:
            self._write(json.dumps({"refused": text}), 1)
        else:
            self._write(f"refused: {text}", 2)

    def _write(self, line: str, fd: int) -> None:
        stream = sys.stdout if fd == 1 else sys.stderr
        if stream is None:  # it was closed when the program was started
            return
        try:
            stream.write(line + "\n")
            stream.flush()
        except OSError:  # the buffer keeps its content: let it go where it does no harm
            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, fd)
            os.close(silence)
