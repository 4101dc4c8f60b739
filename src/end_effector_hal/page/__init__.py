"""The page of a tool in a browser: the state of its HAL, or a recording of it.

Packages: ``view`` computes the view from records; ``link`` has the sockets of the HAL and of a testbench;
``recorded`` makes the same view of a recording; ``web`` is the server with its access rules, and alone needs the extra
``page``; ``static`` has the browser's files.
"""

from ._html import page_html, static_file
