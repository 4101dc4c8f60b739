"""Writing a UPPAAL file: what was read, byte for byte, with single texts replaced."""

from __future__ import annotations

from collections.abc import Iterable
from xml.sax.saxutils import escape

from timed_automata.document._document import Document
from timed_automata.document._text import Span


def write_document(document: Document, replaced: Iterable[tuple[Span, str]] = ()) -> bytes:
    """The file's bytes with the given parts of its texts replaced; all else is as it was.

    Args:
        document: what was read.
        replaced: parts of its texts, which do not overlap, and what stands there instead.
    """
    result, position = [], 0
    for span, new in sorted(replaced, key=lambda item: item[0].text.byte(item[0].start)):
        start, end = span.text.byte(span.start), span.text.byte(span.end)
        result += [
            document.source[position:start],
            escape(new).encode(span.text.encoding, "xmlcharrefreplace"),
        ]
        position = end
    result.append(document.source[position:])
    return b"".join(result)
