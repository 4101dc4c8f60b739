"""What differs between devices stands in their kinds: no other file asks which kind a device is."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path("src")
ROOMS = ("end_effector_hal/kinds", "end_effector_lab/testbench/physics")
CHANNELS = {
    "end_effector_hal/codecs/_ees1.py",
    "end_effector_hal/codecs/modbus/_codec.py",
    "end_effector_hal/codecs/polled_conformance.py",
    "end_effector_lab/testbench/_places.py",
}
"""Codecs and a wiring whose channels have the names of kinds."""
NAMES = {"vacuum", "cylinder", "gripper", "magnet"}


def asked(tree: ast.AST) -> Iterator[str]:
    """Each place of a module that asks for a kind."""
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(text)) if text in NAMES:
                yield f"line {node.lineno}: the word {text!r}"
            case ast.ImportFrom(module=str(module)) if module.startswith("end_effector_hal.kinds."):
                if module.rpartition(".")[2] not in ("stanza", "conditions", "conformance"):
                    yield f"line {node.lineno}: imports {module}"
            case ast.Compare(
                left=ast.Attribute(value=ast.Name(id="part" | "actuator" | "each"), attr="kind")
            ):
                yield f"line {node.lineno}: compares a kind"
            case (
                ast.FunctionDef(name=str(name)) | ast.ClassDef(name=str(name)) | ast.Attribute(attr=str(name))
            ):
                if "vacuum" in name.lower():
                    yield f"line {node.lineno}: the name {name}"


def files() -> list[Path]:
    found = (
        path
        for package in ("end_effector_hal", "end_effector_lab")
        for path in SOURCE.glob(f"{package}/**/*.py")
    )
    names = {path.relative_to(SOURCE).as_posix(): path for path in found}
    return [path for name, path in names.items() if not name.startswith(ROOMS) and name not in CHANNELS]


def test_no_file_outside_of_the_kinds_asks_for_the_kind() -> None:
    found = [f"{path}, {each}" for path in files() for each in asked(ast.parse(path.read_text("utf-8")))]
    assert not found


@pytest.mark.parametrize(
    "text",
    [
        'if part.kind == "vacuum": pass',
        "if actuator.kind in KINDS: pass",
        "from end_effector_hal.kinds.vacuum import VacuumActuator",
        'blown = {"cylinder": 1}',
        "def vacuum_is_released(): pass",
    ],
)
def test_a_file_that_asks_is_found(text: str) -> None:
    assert list(asked(ast.parse(text)))
