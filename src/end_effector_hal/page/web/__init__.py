"""The page's server: access rules, control by one page, and the data sent to browsers."""

from ._guard import PageAddress
from ._serve import serve_page, serve_recordings
