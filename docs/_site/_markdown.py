"""Pieces of Markdown, and where a word stands in the tests."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table; cells may hold any text."""
    names = list(head)
    lines = [names, ["---"] * len(names), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


def plain(text: str) -> str:
    """Text that means no markup: in names such as ``<name>`` and ``*``; between backticks it is left as it is."""
    parts = re.split(r"(`[^`]*`)", text)
    escaped = (part if part.startswith("`") else re.sub(r"([<>*_\[\]\\])", r"\\\1", part) for part in parts)
    return re.sub(r"^(\d+)\. ", r"\1\\. ", "".join(escaped))  # a number is no list


def link(path: Path, page: str = "docs/reference") -> str:
    """A link to a file of the repository, from a page of that folder."""
    up = "../" * len(Path(page).parts)
    name = path.relative_to(ROOT).as_posix()
    return f"[{name}]({up}{name})"


@cache
def trees(folder: str) -> tuple[tuple[Path, ast.Module], ...]:
    """Each Python file below a folder of the repository, parsed."""
    paths = sorted((ROOT / folder).rglob("*.py"))
    return tuple((path, ast.parse(path.read_text(encoding="utf-8"))) for path in paths)


@cache
def nodes(folder: str) -> tuple[tuple[Path, tuple[ast.AST, ...]], ...]:
    """Each Python file below a folder of the repository, with all that stands in it."""
    return tuple((path, tuple(ast.walk(tree))) for path, tree in trees(folder))


@cache
def strings(folder: str) -> tuple[tuple[Path, str], ...]:
    """Each text in the code below a folder, with its file; ``{…}`` stands for what is filled in."""
    found = []
    for path, inside in nodes(folder):
        parts = {id(part) for node in inside if isinstance(node, ast.JoinedStr) for part in node.values}
        found += [(path, text_of(node)) for node in inside if text_of(node) and id(node) not in parts]
    return tuple(found)


def text_of(node: ast.AST | None) -> str:
    """What a literal text says, joined over lines; empty if it is none."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=values):
            return "".join(text_of(value) if isinstance(value, ast.Constant) else "{…}" for value in values)
        case ast.BinOp(left=left, right=right):
            return text_of(left) and text_of(left) + (text_of(right) or "{…}")
    return ""


def tests_with(words: re.Pattern[str]) -> Iterator[Path]:
    """Tests in whose code or texts the words stand."""
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        if words.search(path.read_text(encoding="utf-8")):
            yield path
