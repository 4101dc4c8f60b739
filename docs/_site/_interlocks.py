"""Each interlock: its rule, whether it may be switched off, what it says, its keys, and (in the site) its tests."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from end_effector_hal.description import schema
from end_effector_hal.page.view import RULES

from ._markdown import link, plain, strings, tests_with


def interlocks() -> str:
    """All of them, in their order."""
    stanzas = schema()["$defs"]
    parts = [part for name, rule in RULES.items() for part in _interlock(name, rule, stanzas)]
    tests = "## Tests\n\n`grep -rn IL-09 tests` finds those of one; the site lists them here."
    return "\n\n".join((*parts, tests, "<!-- written by docs/_site: interlock-tests -->"))


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
        yield "Keys of it, in [the description](description.md):"
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
