"""What another description would have made of a recording, in the place of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from end_effector_hal.control import model_constants
from end_effector_hal.description import Description
from end_effector_hal.recording import content_hash
from end_effector_hal.verification.replay import Entry
from end_effector_hal.verification.whatif import NAME, ApartSpan, OtherRun, changes

from ._files import RecordingFiles


class OtherFiles:
    """A recorded run as another controller would have had it (`RecordingFiles`).

    Args:
        files: the recording.
        description: the other tool.

    Attributes:
        spans: from when to when it is a guess; known once `entries` has ended.
    """

    def __init__(self, files: RecordingFiles, description: Description) -> None:
        self._files, self.description = files, description
        self.path: Path = files.path
        typed = description.source.name == NAME
        self.name = "what if" if typed else f"what if: {description.source.name}"
        self.begin, self.end, self.whole = files.begin, files.end, files.whole
        self.spans: tuple[ApartSpan, ...] = ()
        self.notes: list[str] = []
        self.header = replace(
            files.header,
            description=description.name,
            hash=content_hash(description),
            constants=model_constants(description),
            source=str(description.source),
        )

    @property
    def grown(self) -> bool:
        """Whether the files are others than those that were read."""
        return self._files.grown

    def again(self) -> OtherFiles:
        """The same with the recording as it is now."""
        return OtherFiles(self._files.again(), self.description)

    def known(self, view: dict[str, Any]) -> dict[str, Any]:
        """What is shown: a run that is played has everything."""
        return view

    def entries(self) -> Iterator[Entry]:
        """Every record that the other controller would have made, in the order of time."""
        run = OtherRun(self.description, self._files.description)
        yield from run.play(self._files.entries())
        other = changes(self._files.description, self.description)
        self.spans = tuple(run.spans)
        self.notes = [f"Other values than recorded: {'; '.join(other) or 'none'}.", *run.notes]
        if run.spans:
            first = (run.spans[0].since - self.begin) / 1e6
            self.notes.append(
                f"From {first:.3f} s on the story is a guess where the timeline is hatched: the recorded tool did not "
                "see the other outputs, and the readings answer its own."
            )
