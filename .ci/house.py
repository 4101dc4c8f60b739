"""Checks of ``make check`` beside the linters: class names, private modules, and the names that packages export.

A public class name is unique within an import package. A room is a package directly below an import package, with all
its sub-packages. Only code in the same room imports a private module (``_name``). A package exports what its
``__init__`` imports: other code must import every such name from there, and no package exports it a second time. Names
that the Python API describes or a plug-in imports are in ``__all__``, which is then the list of exports. The sets below
hold exceptions; an exception that is no longer needed is also a fault.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"
OURS = {path.name for path in SOURCE.iterdir()}
READERS = ("tests", "tools", "examples", "benchmarks", "docs")
"""Folders whose files also import the packages."""
LONGEST_NAME = 100
"""Largest number of characters of a string that may name a module and a class, such as a launcher's target."""
REPEATED: set[str] = set()
"""Exceptions: ``package.ClassName`` that may occur more than once for now."""
PRIVATE: set[str] = set()
"""Exceptions: ``importing.module -> private.module``, allowed for now."""
OFFERED: set[str] = set()
"""Exceptions: ``package.name`` that a package may export without an import elsewhere."""


def main() -> int:
    """Print every fault; return 1 if there is one."""
    modules = {_module(path): ast.parse(path.read_bytes()) for path in sorted(SOURCE.rglob("*.py"))}
    faults = list(_faults(dict(_repeated(modules)), REPEATED, "stands more than once: rename all but one"))
    faults += _faults(dict(_private(modules)), PRIVATE, "imports a private module: use the public name")
    faults += _faults(
        dict(_offered(modules)), OFFERED, "is not what its package offers: see the head of this file"
    )
    sys.stdout.write("".join(f"{fault}\n" for fault in faults))
    return bool(faults)


def _faults(found: dict[str, str], excepted: set[str], what: str) -> Iterator[str]:
    for name, where in found.items():
        if name not in excepted:
            yield f"{where}: {name} {what}"
    for name in sorted(excepted - found.keys()):
        yield f"{Path(__file__).name}: {name} is an exception that is not needed any more: remove it"


def _module(path: Path) -> tuple[str, bool]:
    """Return the dotted name, and whether it is a package."""
    parts = path.relative_to(SOURCE).with_suffix("").parts
    package = parts[-1] == "__init__"
    return ".".join(parts[:-1] if package else parts), package


def _repeated(modules: dict[tuple[str, bool], ast.Module]) -> Iterator[tuple[str, str]]:
    places: dict[str, list[str]] = defaultdict(list)
    for (module, _), tree in modules.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[f"{module.partition('.')[0]}.{node.name}"].append(module)
    return ((name, ", ".join(where)) for name, where in places.items() if len(where) > 1)


def _private(modules: dict[tuple[str, bool], ast.Module]) -> Iterator[tuple[str, str]]:
    for (module, is_package), tree in modules.items():
        package = module if is_package else module.rpartition(".")[0]
        for node in ast.walk(tree):
            for imported in _imported(node, package):
                room = ".".join(_owner(imported).split(".")[:2])
                if room and not f"{package}.".startswith(f"{room}."):
                    yield f"{module} -> {imported}", module


def _offered(modules: dict[tuple[str, bool], ast.Module]) -> Iterator[tuple[str, str]]:
    """Yield exports that nothing imports, and names imported from a package that has them from elsewhere."""
    imported, named = _uses(modules)
    for (module, is_package), tree in modules.items():
        if not is_package:
            continue
        listed = _listed(tree)
        own = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        for node in tree.body:
            if not isinstance(node, ast.ImportFrom) or node.module == "__future__":
                continue
            for alias in node.names:
                name = alias.asname or alias.name
                taken = f"{module}.{name}" in imported
                if node.level:
                    fault = name not in listed if listed else not taken and name not in named
                    fault &= name not in own
                else:
                    fault = taken and name not in listed
                if fault:
                    yield f"{module}.{name}", module


def _listed(tree: ast.Module) -> set[str]:
    """Return the names in ``__all__``."""
    targets = (
        node
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    )
    return {name for node in targets for name in ast.literal_eval(node.value)}


def _uses(modules: dict[tuple[str, bool], ast.Module]) -> tuple[set[str], set[str]]:
    """Return dotted names that the source imports or uses through a module; words of other folders and strings."""
    imported: set[str] = set()
    named = set(re.findall(r":(\w+)\"", (SOURCE.parent / "pyproject.toml").read_text(encoding="utf-8")))
    for folder in READERS:
        for path in (SOURCE.parent / folder).rglob("*.py"):
            named.update(re.findall(r"\w+", path.read_text(encoding="utf-8")))
    for (module, is_package), tree in modules.items():
        names: dict[str, str] = {}
        through: list[tuple[str, str]] = []
        for node in ast.walk(tree):
            if isinstance(node, ast.Import | ast.ImportFrom):
                found = list(_imported(node, module if is_package else module.rpartition(".")[0]))
                imported.update(found)
                names |= {
                    each.asname or each.name: full for each, full in zip(node.names, found, strict=False)
                }
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                through.append((node.value.id, node.attr))
            elif (
                isinstance(node, ast.Constant)
                and isinstance(node.value, str)
                and len(node.value) < LONGEST_NAME
            ):
                named.update(re.findall(r"\w+", node.value))
        imported.update(f"{names[first]}.{name}" for first, name in through if first in names)
    return imported, named


def _imported(node: ast.AST, package: str) -> Iterator[str]:
    """Yield the names that a statement imports from this repository, as dotted names."""
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            parts = package.split(".")
            base = ".".join([*parts[: len(parts) - node.level + 1], *([base] if base else [])])
        names = [f"{base}.{alias.name}" for alias in node.names]
    else:
        return
    yield from (name for name in names if name.partition(".")[0] in OURS)


def _owner(imported: str) -> str:
    """Return the package that owns the first private part of a name; empty if all of it is public."""
    parts = imported.split(".")
    private = (n for n, part in enumerate(parts) if part.startswith("_") and not part.startswith("__"))
    return ".".join(parts[: next(private, 0)])


if __name__ == "__main__":
    sys.exit(main())
