"""What ``make check`` asks of the source beside the linters: class names, and imports of private modules.

A public class name stands once within an import package. A private module (``_name``) is imported only by its own
package and by sub-packages of that. Exceptions stand in the two sets below; one that is not needed any more is a
fault, too.
"""

from __future__ import annotations

import ast
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"
REPEATED: set[str] = set()
"""``package.ClassName`` that may stand more than once for now."""
PRIVATE: set[str] = set()
"""``importing.module -> private.module`` that may stay for now."""


def main() -> int:
    """Print every fault; 1 if there is one."""
    modules = {_module(path): ast.parse(path.read_bytes()) for path in sorted(SOURCE.rglob("*.py"))}
    faults = list(_faults(dict(_repeated(modules)), REPEATED, "stands more than once: rename all but one"))
    faults += _faults(dict(_private(modules)), PRIVATE, "imports a private module: use the public name")
    sys.stdout.write("".join(f"{fault}\n" for fault in faults))
    return bool(faults)


def _faults(found: dict[str, str], excepted: set[str], what: str) -> Iterator[str]:
    for name, where in found.items():
        if name not in excepted:
            yield f"{where}: {name} {what}"
    for name in sorted(excepted - found.keys()):
        yield f"{Path(__file__).name}: {name} is an exception that is not needed any more: remove it"


def _module(path: Path) -> tuple[str, bool]:
    """The dotted name, and whether it is a package."""
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
                owner = _owner(imported)
                if owner and not f"{package}.".startswith(f"{owner}."):
                    yield f"{module} -> {imported}", module


def _imported(node: ast.AST, package: str) -> Iterator[str]:
    """What a statement imports from this repository, as dotted names."""
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
    ours = {path.name for path in SOURCE.iterdir()}
    yield from (name for name in names if name.partition(".")[0] in ours)


def _owner(imported: str) -> str:
    """The package that owns the first private part of a name; empty: all of it is public."""
    parts = imported.split(".")
    private = (n for n, part in enumerate(parts) if part.startswith("_") and not part.startswith("__"))
    return ".".join(parts[: next(private, 0)])


if __name__ == "__main__":
    sys.exit(main())
