"""What is kept of judged mutants: of which edges it speaks, and that it is of the shipped automata."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from end_effector_hal.control import load_automata
from end_effector_hal.description import load, profile_path
from end_effector_hal.verification import mutation
from end_effector_hal.verification.mutation import kept_record
from end_effector_hal.verification.proof import CHECKS, requirements_of
from timed_automata import Network, Template
from tools.mutants import Mutant, MutantOutcome, MutantVerdict, document_of, mutants, mutation_record, text_of


@pytest.fixture(scope="module")
def network() -> Network:
    return load_automata(load(profile_path()))


def template_of(network: Network, name: str) -> Template:
    return next(each for each in network.document.templates if each.name.content.strip() == name)


def of_arming(network: Network) -> list[Mutant]:
    return [each for each in mutants(network.document, ["Arming"]) if each.edge == 1]


def test_an_edge_is_needed_by_what_noticed_an_edit_of_it(
    network: Network, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, two, three, four = of_arming(network)[:4]
    verdicts = [
        MutantVerdict(one, MutantOutcome.CAUGHT, ("arm-stays", "time")),
        MutantVerdict(two, MutantOutcome.CAUGHT, ("arm-stays",)),
        MutantVerdict(three, MutantOutcome.INVALID),
        MutantVerdict(four, MutantOutcome.SURVIVES),
    ]
    record = mutation_record(network.document, verdicts, of=57, seed=3)
    (tmp_path / "kept.json").write_text(text_of(record), encoding="utf-8")
    monkeypatch.setattr(mutation, "KEPT_FILE", tmp_path / "kept.json")
    assert mutation.kept_record.__wrapped__() == record
    assert json.loads(text_of(record)) == json.loads(json.dumps(document_of(record)))
    assert (record.judged, record.of, record.survivors) == (4, 57, (str(four),))
    needs = record.of_edge(template_of(network, "Arming"), 1)
    assert needs == (3, {"arm-stays": 2, "time": 1})
    assert record.of_edge(template_of(network, "Arming"), 0) is None


def test_of_an_edge_that_was_edited_since_nothing_is_known(network: Network) -> None:
    edit = of_arming(network)[0]
    record = mutation_record(
        network.document, [MutantVerdict(edit, MutantOutcome.CAUGHT, ("arm-stays",))], of=1, seed=0
    )
    template = template_of(network, "Arming")
    edge = template.edges[1]
    moved = replace(template, edges=(template.edges[0], replace(edge, nails=()), *template.edges[2:]))
    assert record.of_edge(moved, 1) is not None
    edited = replace(template, edges=(template.edges[0], replace(edge, labels={}), *template.edges[2:]))
    assert record.of_edge(edited, 1) is None


def test_what_is_kept_is_of_the_shipped_automata(network: Network) -> None:
    """An edge may have been edited since; most are those of the file."""
    record = kept_record()
    tool = load(profile_path())
    templates = [template_of(network, name) for name in tool.automata.executed]
    known = [each for each in templates for number in range(len(each.edges)) if record.of_edge(each, number)]
    assert len(known) > 0.8 * len(record.edges)
    ids = {each.id for each in requirements_of(network)} | CHECKS.keys()
    assert {id_ for each in record.edges.values() for id_ in each.needed_by} <= ids
    assert sum(sum(counts.values()) for counts in record.outcomes.values()) == record.judged
