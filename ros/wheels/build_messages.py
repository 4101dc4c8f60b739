"""Builds message packages for the ROS 2 of the wheels ``ros-*``: generators from the wheels, gcc, no CMake.

Usage: ``PYTHON build_messages.py PACKAGE …`` with the interpreter of the environment that has the wheels. Each PACKAGE
is a folder with ``package.xml`` and ``msg``, ``srv`` or ``action``; the result is installed into that environment. A
package that has not changed since its last build is left alone. Type hashes are those of a build with colcon.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

PREFIX = Path(sys.prefix)
SITE = Path(sysconfig.get_path("purelib"))
SUPPORT, FASTRTPS = "rosidl_typesupport_c", "rosidl_typesupport_fastrtps_c"
INTROSPECTION = "rosidl_typesupport_introspection_c"
FLAGS = ("-O0", "-fPIC")


def main(folders: Iterable[Path]) -> None:
    """Build what has changed."""
    os.environ["AMENT_PREFIX_PATH"] = str(PREFIX)
    for folder in folders:
        stamp = PREFIX / "share" / folder.name / ".built"
        state = _state_of(folder)
        if stamp.is_file() and stamp.read_text(encoding="utf-8") == state:
            continue
        print(f"building {folder.name} for ROS 2 into {PREFIX}", file=sys.stderr)  # noqa: T201
        with tempfile.TemporaryDirectory() as space:
            _build(folder, Path(space))
        stamp.write_text(state, encoding="utf-8")


def _definitions(folder: Path) -> list[Path]:
    return [path for kind in ("msg", "srv", "action") for path in sorted((folder / kind).glob(f"*.{kind}"))]


def _state_of(folder: Path) -> str:
    content = b"".join(path.name.encode() + path.read_bytes() for path in _definitions(folder))
    return hashlib.sha256(content + Path(__file__).read_bytes()).hexdigest()


def _build(folder: Path, space: Path) -> None:
    package, files = folder.name, [f"{folder}:{path.relative_to(folder)}" for path in _definitions(folder)]
    generated = space / package
    _generate(package, files, generated)
    share = PREFIX / "share" / package
    shutil.rmtree(share, ignore_errors=True)
    for idl in sorted((generated / "tmp").rglob("*.idl")):
        _copy(idl, share / idl.relative_to(generated / "tmp"))
    for definition in (*_definitions(folder), *sorted(generated.rglob("*.json"))):
        _copy(definition, share / definition.parent.name / definition.name)
    _compile(folder, space)
    python = SITE / package
    shutil.rmtree(python, ignore_errors=True)
    for module in sorted(generated.rglob("*.py")):
        _copy(module, python / module.relative_to(generated))
    (python / "__init__.py").touch()
    for library in space.glob("*.so"):
        _copy(library, (python if library.name.startswith(f"{package}_s") else PREFIX / "lib") / library.name)


def _generate(package: str, files: list[str], generated: Path) -> None:
    # only in this environment
    from rosidl_generator_c import cli as generator_c
    from rosidl_generator_c.cli import GenerateC
    from rosidl_generator_py.cli import GeneratePython
    from rosidl_typesupport_c.cli import GenerateCTypesupport
    from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
    from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

    # theirs takes a message for the action of its name
    generator_c.build_type_description_tuples = _type_descriptions
    share = [str(PREFIX / "share")]
    for generator in (
        GenerateC("c"),
        GenerateFastRTPSCTypesupport("fastrtps_c"),
        GenerateIntrospectionCTypesupport("introspection_c"),
        GenerateCTypesupport("c", typesupport_implementations=[FASTRTPS, INTROSPECTION]),
        GeneratePython("py", typesupport_implementations=[SUPPORT]),
    ):
        # they print a line for each file
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            # a type support of its own has a file of the same name
            apart = isinstance(generator, GenerateIntrospectionCTypesupport)
            root = generated.parent / "introspection" if apart else generated.parent
            generator.generate(package, files, share, output_path=root / package)
        # translated by the first of them
        files = [
            f"{generated / 'tmp'}:{path.relative_to(generated / 'tmp')}"
            for path in (generated / "tmp").rglob("*.idl")
        ]


def _type_descriptions(idls: Iterable[str], descriptions: Iterable[Path]) -> list[str]:
    """The type description of each definition, as ``msg/Name.idl:path``."""
    paths = {(path.parent.name, path.stem): path for path in map(Path, descriptions)}
    names = [Path(str(idl).rpartition(":")[2]) for idl in idls]
    return [f"{name}:{paths[name.parent.name, name.stem]}" for name in names]


def _others(folder: Path) -> list[str]:
    """The message packages that this one uses: by its package.xml, and those of every service and action."""
    named = re.findall(r"<depend[^>]*>([^<]+)</depend>", (folder / "package.xml").read_text(encoding="utf-8"))
    return sorted({*named, "action_msgs", "builtin_interfaces", "service_msgs", "unique_identifier_msgs"})


def _compile(folder: Path, space: Path) -> None:
    package = folder.name
    generated = space / package
    include = [
        f"-I{space}",
        f"-I{space / 'introspection'}",
        f"-I{PREFIX / 'include'}",
        *(f"-I{path}" for path in sorted((PREFIX / "include").iterdir())),
    ]
    link = [f"-L{space}", f"-L{PREFIX / 'lib'}", *(f"-L{path}" for path in sorted(SITE.glob("ros_*.libs")))]
    others = [name for name in _others(folder) if (PREFIX / "lib" / f"lib{name}__{SUPPORT}.so").is_file()]

    def library(name: str, sources: Iterable[Path], *options: str) -> None:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(lambda source: _object(source, include), objects := sorted(sources)))
        made = [str(source.with_suffix(source.suffix + ".o")) for source in objects]
        _run("g++", *FLAGS, "-shared", "-o", str(space / name), *made, *link, *options)

    def of(pattern: str, root: Path = generated) -> list[Path]:
        return [path for kind in ("msg", "srv", "action") for path in (root / kind).glob(pattern)]

    runtime = ("-lrosidl_runtime_c",)
    structures = f"-l{package}__rosidl_generator_c"

    def of_others(role: str) -> list[str]:
        return [f"-l{name}__{role}" for name in others]

    library(
        f"lib{package}__rosidl_generator_c.so", of("detail/*.c"), *of_others("rosidl_generator_c"), *runtime
    )
    fast = (
        *of_others(FASTRTPS),
        "-lrosidl_typesupport_fastrtps_c",
        "-lrosidl_typesupport_fastrtps_cpp",
        "-lfastcdr",
    )
    library(f"lib{package}__{FASTRTPS}.so", of("detail/*type_support_c.cpp"), structures, *fast, *runtime)
    library(
        f"lib{package}__{INTROSPECTION}.so",
        of("detail/*.c", space / "introspection" / package),
        structures,
        *of_others(INTROSPECTION),
        f"-l{INTROSPECTION}",
        *runtime,
    )
    library(
        f"lib{package}__{SUPPORT}.so",
        of("*.cpp"),
        structures,
        *of_others(SUPPORT),
        "-lrosidl_typesupport_c",
        *runtime,
    )
    library(
        f"lib{package}__rosidl_generator_py.so",
        of("_*_s.c"),
        structures,
        *of_others("rosidl_generator_py"),
        *runtime,
    )
    entries = generated.glob(f"_{package}_s.ep.{SUPPORT}.c")
    needed = (
        f"-l{package}__rosidl_generator_py",
        structures,
        f"-l{package}__{SUPPORT}",
        "-lrosidl_typesupport_c",
    )
    library(f"{package}_s__{SUPPORT}.so", entries, *needed, *runtime)


def _object(source: Path, include: list[str]) -> None:
    import numpy

    python = (f"-I{sysconfig.get_path('include')}", f"-I{numpy.get_include()}")
    compiler = ("g++", "-std=c++17") if source.suffix == ".cpp" else ("gcc",)
    _run(*compiler, *FLAGS, "-w", "-c", str(source), "-o", f"{source}.o", *include, *python)


def _run(*command: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{done.stderr[-3000:]}\n{' '.join(command[:6])} … failed.")


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(source, target)


if __name__ == "__main__":
    main(Path(each).resolve() for each in sys.argv[1:])
