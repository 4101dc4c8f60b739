"""The shipped automata, and mutants of them, as parameters of tests."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import RangeError
from end_effector_hal.verification.proof import requirements_of
from timed_automata import Network, make_network, read_document
from timed_automata.explore import Explorer, Overview, ReactionBound, overview

_TRANSITION = re.compile(r"\t*<transition\b.*?</transition>\n", re.DOTALL)
_LOCATION = re.compile(r'<location id="([^"]+)"[^>]*>\s*<name[^>]*>(\w+)</name>.*?</location>', re.DOTALL)
_LABEL = re.compile(r"(?<=>)[^<>]*(?=</(?:label|declaration)>)")

REACTION = ReactionBound(("Gripper", "Actuator", "Changer", "Arming"), 50)
_CHECKS = {
    "locations": lambda found: bool(found.coverage.locations),
    "edges": lambda found: bool(found.coverage.edges),
    "channels": lambda found: bool(found.open_channels),
    "names": lambda found: bool(found.equal_names),
    "room": lambda found: bool(found.late),
}
"""What no query says: whether it fails, by id."""


@dataclass(frozen=True)
class Shipped:
    """The UPPAAL file, and the constants of the description."""

    text: str
    constants: dict

    def network(self, mutant: dict | None = None) -> Network:
        text = mutated(self.text, mutant) if mutant else self.text
        return self._network(text, mutant or {})

    def original(self, mutant: dict) -> Network:
        """The network that a mutant is one of, with its constants, and with what its program forgets."""
        forgets = mutant.get("forgets")
        return self._network(mutated(self.text, forgets) if forgets else self.text, mutant)

    def _network(self, text: str, mutant: dict) -> Network:
        return _compiled(text, json.dumps(self.constants | mutant.get("constants", {})))

    def catches(self, mutant: dict) -> bool:
        """Whether the requirement that is named does not hold of a mutant."""
        return _fails(self.network(mutant), mutant["caught_by"])

    def failing_checks(self, found: Overview) -> list[str]:
        failing = [id_ for id_, fails in _CHECKS.items() if fails(found)]
        return [*failing, "time"] if found.stopped or found.zeno else failing


@lru_cache(maxsize=4)
def _compiled(text: str, constants: str) -> Network:
    return make_network(read_document(text.encode(), "mutant.xml"), json.loads(constants))


@pytest.fixture(scope="session")
def shipped() -> Shipped:
    description = load(profile_path())
    return Shipped(description.automata_path.read_text(encoding="utf-8"), model_constants(description))


def _fails(network: Network, by: str) -> bool:
    """Whether one requirement, or check, does not hold; looked for alone. What one look leaves in doubt is looked for
    once more, so that nothing is caught by a fault of the search."""
    if by == "ranges":
        try:
            overview(network, [])
        except RangeError:
            return True
        return False
    if by == "time":
        found, explorer = overview(network, []), Explorer(network)
        return (found.stopped and not explorer.timelock().holds) or (found.zeno and not explorer.zeno().holds)
    if by in _CHECKS:
        return _CHECKS[by](overview(network, [], reaction=REACTION))
    query = {requirement.id: requirement.query for requirement in requirements_of(network)}[by]
    if overview(network, [query], stop=True).answers[0]:
        return False
    doubtful = query.kind == "-->" or "deadlock" in str(query)
    return not doubtful or not Explorer(network).check(query).holds


def mutated(text: str, mutant: dict) -> str:
    """The file with one edit, after the one of what the program forgets, if there is one."""
    if forgets := mutant.get("forgets"):
        text = mutated(text, forgets)
    start, end = _template(text, mutant.get("template"))
    part = text[start:end]
    if mutant.get("code"):
        head = part.index("<declaration>")
        at = head, part.index("</declaration>") + len("</declaration>")
        new = _replaced(part[slice(*at)], mutant)
    elif "location" in mutant:
        found = [m for m in _LOCATION.finditer(part) if m[2] == mutant["location"]]
        at, drawn = found[0].span(), found[0][0]
        new = drawn.replace("<committed/>", "<urgent/>") if mutant.get("urgent") else _replaced(drawn, mutant)
        assert new != drawn
    else:
        edge = _edge(part, mutant)
        at, new = edge.span(), _edited(part, edge[0], mutant)
    return text[:start] + part[: at[0]] + new + part[at[1] :] + text[end:]


def _template(text: str, name: str | None) -> tuple[int, int]:
    if name is None:
        return 0, text.index("<template>")
    start = text.rindex("<template>", 0, re.search(rf"<name[^>]*>{name}</name>", text).start())
    return start, text.index("</template>", start)


def _ids(part: str) -> dict[str, str]:
    return {match[2]: match[1] for match in _LOCATION.finditer(part)}


def _edge(part: str, mutant: dict) -> re.Match[str]:
    ids = _ids(part)
    source, target = (ids[name] for name in mutant["edge"].split(" -> "))
    found = [
        match
        for match in _TRANSITION.finditer(part)
        if f'<source ref="{source}"/>' in match[0]
        and f'<target ref="{target}"/>' in match[0]
        and escape(mutant.get("has", "")) in match[0]
    ]
    assert len(found) == 1, f"{len(found)} edges {mutant['edge']}"
    return found[0]


def _edited(part: str, edge: str, mutant: dict) -> str:
    if mutant.get("remove"):
        return ""
    if "target" in mutant:
        return re.sub(r'(?<=<target ref=")[^"]+', _ids(part)[mutant["target"]], edge)
    return _replaced(edge, mutant)


def _replaced(element: str, mutant: dict) -> str:
    """In the text of one label or of the declarations; the rest of the file is not touched."""
    old, new = escape(mutant["old"]), escape(mutant["new"])
    found = [match for match in _LABEL.finditer(element) if old in match[0]]
    assert len(found) == 1, f"{len(found)} texts with {mutant['old']!r}"
    assert found[0][0].count(old) == 1
    start, end = found[0].span()
    return element[:start] + found[0][0].replace(old, new) + element[end:]


# The mutants of the file beside this one, as parameters of tests.


Mutant = dict[str, Any]
MUTANTS: list[Mutant] = tomllib.loads(Path(__file__).with_name("mutants.toml").read_text(encoding="utf-8"))[
    "mutant"
]


def first_of_each(mutants: Sequence[Mutant], key: str, thinned: str | None = None) -> pytest.MarkDecorator:
    """Parametrizes ``mutant``: an ordinary run takes the first one with each value of ``key``, the night all.

    ``thinned``: `make test-thinned` takes the first one with each value of this other key.
    """
    seen = set[object]()
    parameters = []
    for mutant in mutants:
        if new := mutant[key] not in seen:
            marks = []
        else:
            new = thinned is not None and (thinned, mutant[thinned]) not in seen
            marks = [pytest.mark.thinned if new else pytest.mark.nightly]
        seen |= {mutant[key], (thinned, mutant.get(thinned))}
        parameters.append(pytest.param(mutant, id=f"{mutant['name']} [{mutant[key]}]", marks=marks))
    return pytest.mark.parametrize("mutant", parameters)
