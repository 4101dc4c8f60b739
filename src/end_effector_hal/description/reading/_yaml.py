"""Reads YAML 1.2 as plain values with the place of every key and value; finds all structural faults."""

from __future__ import annotations

import re
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from end_effector_hal.description._fault import Fault, Keys, Place, Places

from ._syntax import LineStarts, shorten, syntax_fault

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
