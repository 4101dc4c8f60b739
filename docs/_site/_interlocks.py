"""Each interlock: where it is proven, enforced and tested; its rule, what it says, its keys."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from end_effector_hal.description import load, profile_path, schema
from end_effector_hal.page.view._interlocks import RULES
from end_effector_hal.verification.lemmas import BUS_FILE, COILS_FILE, DEATHS_FILE
from end_effector_hal.verification.proof import requirements_of
from timed_automata import load_network

from ._markdown import ROOT, link, plain, strings, table, tests_with

SOURCE = ROOT / "src" / "end_effector_hal"
PLACES = {
    "the line arbiter": ("arbiter",),
    "the program": ("runtime",),
    "`eehal check`": ("description/rules",),
}
"""Packages of what enforces an interlock, beside the automata."""
NOT_PROVEN = {"IL-12": "maintenance is in no network: tested only"}
"""Why no requirement speaks of an interlock."""


def interlocks() -> str:
    """All of them, in their order."""
    stanzas = schema()["$defs"]
    rows = [(name, proven_by(name), enforced_in(name), ", ".join(tested_in(name))) for name in RULES]
    where = "## Where each is proven, enforced and tested"
    parts = [where, table(("Interlock", "Proven by", "Enforced by", "Tested in"), rows)]
    parts += [part for name, rule in RULES.items() for part in _interlock(name, rule, stanzas)]
    tests = "## Tests\n\n`grep -rn IL-09 tests` finds those of one; the site lists them here."
    return "\n\n".join((*parts, tests, "<!-- written by docs/_site: interlock-tests -->"))


@cache
def required() -> dict[str, str]:
    """The requirements of all networks: sentences by id."""
    files = (load(profile_path()).automata_path, COILS_FILE, BUS_FILE, DEATHS_FILE)
    return {each.id: each.sentence for file in files for each in requirements_of(load_network(file))}


def proven_by(name: str) -> str:
    """The requirements whose sentences name an interlock; raises LookupError if it has neither one nor a reason."""
    found = [id_ for id_, sentence in required().items() if re.search(rf"{name}\b", sentence)]
    if bool(found) is (name in NOT_PROVEN):
        raise LookupError(f"{name}: proven by {found}, and NOT_PROVEN says {NOT_PROVEN.get(name)!r}")
    return ", ".join(f"`{each}`" for each in found) or f"none: {NOT_PROVEN[name]}"


def enforced_in(name: str) -> str:
    """The automata, where their code names an interlock, and the files of `PLACES` that do."""
    named = re.compile(rf"{name}\b|il_{name[3:]}\b|{name.replace('-', '_')}\b", re.IGNORECASE)
    code = re.sub(
        r"<queries>.*</queries>", "", load(profile_path()).automata_path.read_text(), flags=re.DOTALL
    )
    found = ["the automata"] if named.search(code) else []
    for place, packages in PLACES.items():
        files = [file for package in packages for file in sorted((SOURCE / package).rglob("*.py"))]
        links = [link(file) for file in files if named.search(file.read_text(encoding="utf-8"))]
        found += [f"{place} ({', '.join(links)})"] if links else []
    return "; ".join(found)


def tested_in(name: str) -> list[str]:
    """Tests that have an interlock in their name, and the doors through which the acceptance tests violate it."""
    doors = (ROOT / "tests/acceptance/interlocks/doors.py").read_text(encoding="utf-8")
    tried = re.findall(rf'^@cell\(\s*"{name}", "(\w+)"', doors, re.MULTILINE)
    found = [f"the table of the doors ({', '.join(dict.fromkeys(tried))})"] if tried else []
    wanted = re.compile(rf"^def (test_\w*{name.lower().replace('-', '_')}\w*)", re.MULTILINE)
    for file in tests_with(wanted):
        names = wanted.findall(file.read_text(encoding="utf-8"))
        found += [f"`{file.relative_to(ROOT / 'tests').as_posix()}::{each}`" for each in names]
    return found


def interlock_tests() -> str:
    """Of each interlock the tests that speak of it; they change too often to be committed."""
    found = {name: sorted(tests_with(re.compile(rf"{name}\b"))) for name in RULES}
    return "\n".join(
        f"- {name}: {', '.join(map(link, tests)) or 'none by its name'}" for name, tests in found.items()
    )


def _interlock(name: str, rule: str, stanzas: Mapping[str, Any]) -> Iterator[str]:
    yield f"## {name}: {rule[0].lower()}{rule[1:]}"
    yield (
        f"It can be switched off in the description: `interlocks: {{{name}: false}}`."
        if name in stanzas["Interlocks"]["properties"]
        else "It cannot be switched off."
    )
    keys = _keys(name, stanzas)
    said = sorted({text for _, text in strings("src") if text.startswith(f"{name}: ")} - set(keys.values()))
    if said:
        yield "It says:"
        yield "\n".join(f"- {plain(each)}" for each in said)
    if keys:
        yield "Keys of it, in [the description](keys.md):"
        yield "\n".join(
            f"- `{key}`: {plain(text.removeprefix(f'{name}: '))}" for key, text in sorted(keys.items())
        )


def _keys(name: str, stanzas: Mapping[str, Any]) -> dict[str, str]:
    return {
        f"{stanza}.{key}".removeprefix("Interlocks."): each["description"]
        for stanza, part in stanzas.items()
        for key, each in part.get("properties", {}).items()
        if each.get("description", "").startswith(f"{name}: ")
    }
