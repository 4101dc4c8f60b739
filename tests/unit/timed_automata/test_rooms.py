"""How the library is built: rooms that use each other by their public names, and no name for two things."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

import timed_automata

ROOT = Path(timed_automata.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
ROOMS = sorted(path.parent for path in FILES if path.name == "__init__.py" and path.parent != ROOT)


def imports(path: Path) -> Iterator[tuple[str, str]]:
    """Module and name of each import from this library."""
    package = ["timed_automata", *path.parent.relative_to(ROOT).parts]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            module = ".".join([*package, node.module] if node.level and node.module else [node.module or ""])
            if node.level or module.startswith("timed_automata"):
                yield from ((module, name.name) for name in node.names)


def room_of(path: Path) -> str:
    return ".".join(["timed_automata", *path.parent.relative_to(ROOT).parts])


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_private_modules_are_used_in_their_own_room_and_below(path: Path) -> None:
    for module, name in imports(path):
        *parents, last = module.split(".")
        if last.startswith("_"):
            room = ".".join(parents[:2])  # with all of its folders
            assert f"{room_of(path)}.".startswith(f"{room}."), f"{path} imports {name} from {module}"


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: str(room.relative_to(ROOT)))
def test_a_room_says_in_one_sentence_what_it_is_for_and_lists_its_names(room: Path) -> None:
    tree = ast.parse((room / "__init__.py").read_text(encoding="utf-8"))
    sentence = ast.get_docstring(tree)
    assert sentence.endswith(".")
    assert "\n" not in sentence
    assert all(isinstance(node, ast.ImportFrom | ast.Assign) for node in tree.body[1:])
    assert len(list(room.glob("*.py"))) <= 12


def test_no_class_has_the_name_of_another_one() -> None:
    names = Counter(
        node.name
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
    )
    assert [name for name, count in names.items() if count > 1] == []


def test_the_monitor_computes_for_itself_when_an_edge_can_be_taken() -> None:
    used = {name for path in (ROOT / "monitor").glob("*.py") for _, name in imports(path)}
    assert used.isdisjoint({"ClockInstants", "Schedule", "Successor", "SuccessorCache"})


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_import_is_for_the_type_checker_only(path: Path) -> None:
    """Except those of the front, which imports its rooms at first use."""
    assert path == ROOT / "__init__.py" or "TYPE_CHECKING" not in path.read_text(encoding="utf-8")


def test_the_front_has_every_name_that_it_lists_and_no_other() -> None:
    assert all(hasattr(timed_automata, name) for name in timed_automata.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'Explorer'"):
        timed_automata.Explorer  # noqa: B018 it is looked up
