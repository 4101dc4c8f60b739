"""Commands that open a recording: ``eehal replay`` and ``page``; and how others open one."""

from ._recordings import open_recordings, part_of, recording_options, runs_in
