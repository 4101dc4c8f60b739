"""Reads a file as YAML 1.2: plain values with the place of every key and value; finds all structural faults.

Errors of the YAML reader become faults with helpful messages.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from end_effector_hal.description._fault import Fault, Keys, Place, Places, did_you_mean
from end_effector_hal.vocabulary import escaped

# (pattern of the reader's words, what, expected, whether to point at the start of the construct)
SENTENCES = (
    (r"character '\\t'", "a tab", "spaces to indent", False),
    (r"character '%'", "a text begins with '%'", "quotes around it", False),
    (r"character '[@`]'", "a text begins with a reserved character", "quotes around it", False),
    (r"mapping values are not allowed", "a ':' too many", "quotes around a text with ': ' in it", False),
    (r"could not find expected ':'", "a line without ':'", "key: value", True),
    (
        r"expected <block end>",
        "the indentation fits no line above",
        "the keys of a stanza in one column",
        False,
    ),
    (r"unexpected (end of stream|document sep)", "a quote is not closed", "the closing quote", True),
    (r"expected ',' or '\]'", "a bracket is not closed, or a comma is missing", "[a, b, c]", True),
    (r"expected ',' or '\}'", "a brace is not closed, or a comma is missing", "{key: value, …}", True),
    (r"<stream end>", "the file ends too early", "the rest of it", False),
    (r"undefined alias", "an alias that no anchor defines", "an &anchor above it", False),
    (r"another document", "a second document", "one; '---' stands at the top only", False),
    (r"unknown escape character", "an unknown escape in a quoted text", "single quotes", False),
    (r"maximum depth", "nested too deep", "a few levels", False),
)


def syntax_fault(error: MarkedYAMLError | ReaderError, text: str) -> Fault:
    """Return the fault that stopped the reader."""
    if isinstance(error, ReaderError):
        line, column = position(text, error.position)
        found = f"U+{error.character:04X}" if isinstance(error.character, int) else ""
        return Fault(line, column, "EE-202", "not YAML: a character that cannot be printed", found, "text")
    mark, what, expected = error.problem_mark or error.context_mark, shorten(str(error.problem), 80), ""
    for pattern, sentence, better, at_start in SENTENCES:
        if re.search(pattern, what):
            what, expected = sentence, better
            mark = error.context_mark if at_start and error.context_mark else mark
            break
    index = min(getattr(mark, "index", 0), len(text))
    found = text[text.rfind("\n", 0, index) + 1 :].split("\n", 1)[0]
    line, column = position(text, index)
    return Fault(line, column, "EE-202", f"not YAML: {what}", shorten(found) or "end of the file", expected)


class LineStarts:
    """Converts indexes of one text to positions without reading the text again each time."""

    def __init__(self, text: str) -> None:
        self._starts = [0, *(match.end() for match in re.finditer("\n", text))]

    def position(self, index: int) -> tuple[int, int]:
        """Return the line and the column of an index, both counted from 1."""
        line = bisect_right(self._starts, index)
        return line, index - self._starts[line - 1] + 1


def position(text: str, index: int) -> tuple[int, int]:
    """Return the line and the column of an index, both counted from 1."""
    return text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index)


def shorten(text: str, width: int = 40) -> str:
    """Return the first line of a text, printable and not longer than ``width``."""
    lines = text.strip().splitlines() or [""]
    line = escaped(lines[0].rstrip())
    return line if len(line) <= width and len(lines) == 1 else line[: width - 1].rstrip() + "…"


_WORDS: dict[str, object] = {
    **dict.fromkeys(["", "~", "null", "Null", "NULL"], None),
    **dict.fromkeys(["true", "True", "TRUE"], True),
    **dict.fromkeys(["false", "False", "FALSE"], False),
}
_INTEGER = re.compile(r"[-+]?[0-9]{1,300}|0o[0-7]{1,300}|0x[0-9a-fA-F]{1,300}")
_FLOAT = re.compile(
    r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"
)


def plain(text: str) -> object:
    """Return the value of a scalar that is not quoted."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))
    if _FLOAT.fullmatch(text):
        return float(re.sub(r"\.(?=[a-zA-Z])", "", text))
    return text


DEPTH = 20
"""Largest number of nested lists and mappings."""
NODES = 10_000
"""Largest number of keys and values of a file, after its aliases are expanded."""


class TooManyValuesError(Exception):
    """The text has more values than `NODES`; the first surplus one is at ``index``."""

    def __init__(self, index: int) -> None:
        super().__init__(index)
        self.index = index


class CountingComposer(Composer):
    """Stops reading as soon as there are too many values, before the rest is parsed."""

    count = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose one more key, value or alias."""
        self.count += 1
        if self.count > NODES:
            raise TooManyValuesError(self.parser.peek_event().start_mark.index)
        return super().compose_node(parent, index)


def _composed(text: str) -> Node | None:
    """Return the nodes of a text; None: it has none."""
    yaml = YAML(typ="safe", pure=True)
    yaml.max_depth = DEPTH
    yaml.Composer = CountingComposer
    yaml.composer.warn_double_anchors = False
    root: Node | None = yaml.compose(text)
    return root


TAGS = {f"tag:yaml.org,2002:{name}" for name in ("map", "seq", "str", "int", "float", "bool", "null")}
SHOWN = 400
"""Largest number of characters of a value that are read to display it."""
# What the reader resolves by itself although YAML 1.2 does not know it: text here.
TEXTS = {f"tag:yaml.org,2002:{name}" for name in ("timestamp", "merge", "value", "binary")}


class Reader:
    """Reads one text and fills ``places`` and ``faults`` while it does."""

    def __init__(self, text: str, places: Places) -> None:
        self.text, self.places = text, places
        self.faults: list[Fault] = []
        self.refused: set[Keys] = set()
        self._lines = LineStarts(text)
        self._inside: list[int] = []
        self._count = 0

    def read(self) -> object:
        """Return the value of the whole text; if there are ``faults``, only the part that could be read."""
        if fault := _version(self.text):
            self.faults.append(fault)
        root = self._compose()
        return None if root is None else self._value(root, ())

    def _compose(self) -> Node | None:
        try:
            return _composed(self.text)
        except TooManyValuesError as error:
            place = Place(*self._lines.position(error.index))
            self.faults.append(
                Fault.at(place, "EE-203", "the file holds too much", expected=f"at most {NODES} values")
            )
        except (MarkedYAMLError, ReaderError) as error:
            self.faults.append(syntax_fault(error, self.text))
        except (YAMLError, RecursionError):
            self.faults.append(Fault(1, 1, "EE-202", "not YAML: nested too deep", "", "a few levels"))
        return None

    def _value(self, node: Node, path: Keys) -> object:
        self._count += 1
        self.places.values[path] = self._place(node)
        if id(node) in self._inside:
            self._refuse(node, "an alias is inside of what it names", "a copy of the stanza", path)
            return None
        if self._count > NODES:
            if self._count == NODES + 1:
                self._refuse(node, "the aliases unfold to too much", f"at most {NODES} values", path)
            self.refused.add(path)
            return None
        if node.tag not in TAGS and not (isinstance(node, ScalarNode) and node.tag in TEXTS):
            self._refuse(node, "tags mean nothing here", "a plain value", path)
            return None
        if isinstance(node, ScalarNode):
            text = str(node.value)
            if _is_broken(text):
                self._refuse(node, "an escape that is only half of a character", "text", path)
                return None
            return text if node.style or str(node.tag).endswith(":str") else plain(text)
        self._inside.append(id(node))
        value = self._mapping(node, path) if isinstance(node, MappingNode) else self._sequence(node, path)
        self._inside.pop()
        return value

    def _sequence(self, node: Node, path: Keys) -> list[object]:
        elements = node.value if isinstance(node, SequenceNode) else ()
        return [self._value(each, (*path, index)) for index, each in enumerate(elements)]

    def _mapping(self, node: MappingNode, path: Keys) -> dict[str, object]:
        mapping: dict[str, object] = {}
        for key_node, value_node in node.value:
            key = str(key_node.value)
            if not isinstance(key_node, ScalarNode) or _is_broken(key):
                self._refuse(key_node, "a key is not a word", "key: value", (*path, key))
            elif key == "<<" and not key_node.style:
                self._refuse(
                    key_node, "merge keys are not part of YAML 1.2", "the keys themselves", (*path, key)
                )
            elif key in mapping:
                first = self.places.keys[(*path, key)].line
                once = f"it once; the first is in line {first}"
                self.faults.append(
                    Fault.at(self._place(key_node), "EE-204", f"key {key!r} stands twice", expected=once)
                )
            else:
                self.places.keys[(*path, key)] = self._place(key_node)
                mapping[key] = self._value(value_node, (*path, key))
                if value_node.start_mark.index == value_node.end_mark.index:
                    # The reader notices only at the next key that there was no value.
                    self.places.values[(*path, key)] = self._place(key_node)
        return mapping

    def _place(self, node: Node) -> Place:
        start, end = node.start_mark.index, node.end_mark.index
        text = self.text[start : min(end, start + SHOWN)]
        return Place(*self._lines.position(start), shorten(text), len(text.split("\n", 1)[0].rstrip()) or 1)

    def _refuse(self, node: Node, what: str, expected: str, path: Keys) -> None:
        self.refused.add(path)
        self.faults.append(Fault.at(self._place(node), "EE-203", what, expected=expected))


def _is_broken(text: str) -> bool:
    """Return whether escapes left half of a surrogate pair, which cannot be written anywhere."""
    return any("\ud800" <= each <= "\udfff" for each in text)


def _version(text: str) -> Fault | None:
    """Return a fault for a directive such as ``%YAML 1.1``, whose booleans and numbers are different."""
    for number, line in enumerate(text.split("\n"), start=1):
        if line.startswith("%YAML") and not re.fullmatch(r"%YAML\s+1\.2\s*(#.*)?", line):
            return Fault(number, 1, "EE-203", "another version of YAML", shorten(line), "%YAML 1.2")
        if line.strip() and not line.startswith(("%", "#")):
            return None
    return None


LIMIT = 256 * 1024
NAME = "end_effector.yaml"


def read_text(path: Path) -> str | Fault:
    """Return the text of a file, or a fault if it cannot be read."""
    try:
        if path.is_fifo() and not str(path).startswith(
            ("/dev/", "/proc/")
        ):  # there a shell has put it, with a writer
            return _unread("this is a named pipe, not a file", "the path of a description")
        with path.open("rb") as stream:
            data = stream.read(LIMIT + 1)
    except FileNotFoundError:
        return _unread("there is no such file", "the path of a description", _neighbours(path))
    except IsADirectoryError:
        inside = f"write {path / NAME}" if (path / NAME).is_file() else ""
        return _unread("this is a directory", "the path of a description", inside)
    except PermissionError:
        return _unread("the file may not be read", "read permission for this user")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        return _unread(f"the file cannot be read: {reason}", "the path of a description")
    if len(data) > LIMIT:
        return _unread("the file is too large", f"a description of at most {LIMIT // 1024} KiB")
    return _decode(data)


def _decode(data: bytes) -> str | Fault:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8-sig", "replace")
        line, column = position(before, len(before))
        found = f"byte 0x{data[error.start]:02X}"
        return Fault(line, column, "EE-201", "this is not text", found, "YAML in UTF-8")
    return text


def _unread(what: str, expected: str, hint: str = "") -> Fault:
    return Fault(0, 0, "EE-201", what, "", expected, hint)


def _neighbours(path: Path) -> str:
    try:
        return did_you_mean(path.name, [each.name for each in path.parent.iterdir() if each.is_file()])
    except OSError:
        return ""
