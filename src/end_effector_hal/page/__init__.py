"""The page of a tool: what its programs say of themselves, or what they have recorded, in a browser.

Rooms: ``view``, what is shown, computed from records; ``link``, the sockets of the programs and of a testbench;
``recorded``, the same view of a recording; ``web``, the server and who may use it, which alone needs the extra
``page``; ``static``, what the browser runs.
"""

from ._html import page_html, static_file
