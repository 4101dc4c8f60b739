"""Folders of results: of one computation, which goes on there where it was stopped, or replaced as a whole."""

from ._folder import ResultsFolder, ResultsLayout
from ._mark import mark_of, source_checksum
from ._replaced import replaced_folder
