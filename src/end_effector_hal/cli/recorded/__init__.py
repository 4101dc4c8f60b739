"""The commands ``eehal replay`` and ``eehal page``, and functions with which other commands open a recording."""

from ._recordings import open_recordings, part_of, recording_options, runs_in
