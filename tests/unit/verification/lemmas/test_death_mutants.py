"""Systematic edits of the network of deaths: a requirement notices each, but for those that stand here with a reason.

Three of four edits are of what may happen (who dies when, what a program asks for): with fewer or more of it nothing
falls either. A requirement cannot see those that reach the same states, and need not see a program that may do more.
"""

from __future__ import annotations

from collections.abc import Collection
from random import Random

import pytest

from end_effector_hal.verification.lemmas import DEATHS_FILE
from tests.support.nightly import NIGHTLY, first_of
from tests.unit.arbiter.death_runs import model_text
from tests.unit.arbiter.test_death_template import played
from timed_automata import Document, Network, load_document, make_network
from timed_automata.explore.search import Search, without_collector
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits
from tools.mutants import Baseline, Mutant, MutantOutcome, judge, mutants

pytestmark = pytest.mark.thinned  # long

TEMPLATES = ("Program", "Arbiter", "Line")
SAMPLE, SEED = 40, 2026
NO_RUN_OF_THE_CODE = {
    "Arbiter, Idle -> Ready: target, 'Idle -> Ready' -> 'Idle -> Refusing'": 0,
    "Arbiter, Down -> Ready, synchronisation: synchronisation, 'starts' -> 'falls'": 0,
}
"""It cannot do what the line arbiter does: the number of a run of the code that it has not."""
SAME_STATES = {
    # it leaves in order with the last will "hold": so it does where it dies, and its session is over
    "Program, Up -> Gone, guard: condition dropped, 'ee == GRIPPING || w == 0' -> 'ee == GRIPPING'": (),
    # three times that keep time from standing still, or that somebody waits: how long says no requirement
    "Program, Calling -> Lost, assignment: assignment dropped, 'calls = false, r = 0' -> 'calls = false'": (),
    "Arbiter, Down -> Ready, guard: constant, '1' -> '2'": (),
    "Line, Settled -> Settling, assignment: constant, '0' -> '1'": (),
    # a record that is lost becomes one that is outdated: neither is believed
    "Arbiter, function mark: condition dropped, 'record == WHOLE' -> 'true'": ("record",),
}
"""It reaches the same discrete states, but for the values of these variables."""
UNNOTICED = {*NO_RUN_OF_THE_CODE, *SAME_STATES}

NOTICED = [
    ("keep: assignment dropped, 'kept_line[i] = line[i];' -> ';'", "record-lines"),
    ("whole_will: constant, 'will' -> '(will - 1)'", "record-waits"),
    ("adopt: condition dropped, 'in_doubt() || session == NONE' -> 'in_doubt()'", "will-owned"),
    ("Ready -> Down: target, 'Ready -> Down' -> 'Ready -> Working'", "due"),
    ("Calling -> Up: target, 'Calling -> Up' -> 'Calling -> Gone'", "gone"),
    ("assignment: assignment dropped, 'take(m), listens = false' -> 'take(m)'", "listens"),
    ("Holding -> Lost: edge deleted", "unread"),
    ("Asking -> Up, synchronisation: synchronisation, 'accepted?' -> ''", "program-told"),
    ("Holding -> Lost: target, 'Holding -> Lost' -> 'Holding -> Asking'", "program-told"),
    ("Ready -> Ready, guard: comparison, '!=' -> '=='", "record-lines"),
    ("Ready -> Ready: target, 'Ready -> Ready' -> 'Ready -> Working'", "answered"),
    ("put: comparison, '==' -> '!='", "as-asked"),
]
"""Edits that nothing noticed before this was required; those of several edges that are alike have the same words."""


@pytest.fixture(scope="module")
def document() -> Document:
    return load_document(DEATHS_FILE)


@pytest.fixture(scope="module")
def baseline(document: Document) -> Baseline:
    return Baseline(make_network(document), {}, ())


def drawn(document: Document) -> dict[int, Mutant]:
    """The sample of edits of templates, by their numbers; what only watches a write, for `as-asked`, is left out."""
    every, lines = list(mutants(document, TEMPLATES)), DEATHS_FILE.read_text(encoding="utf-8").splitlines()
    edits = [n for n, each in enumerate(every) if each.template]
    order = [n for n in edits if "strayed" not in lines[int(every[n].place.split(":")[-2]) - 1]]
    assert len(order) == len(edits) - 7
    Random(SEED).shuffle(order)
    return {number: every[number] for number in order[:SAMPLE]}


def numbered(document: Document, words: str) -> int:
    (number,) = (number for number, each in drawn(document).items() if words in str(each))
    return number


def reached(network: Network, but: Collection[str]) -> set[object]:
    """All discrete states, but for the values of some variables."""
    left_out = [network.offsets[name] for name in but]
    space, found = SymbolicSpace(DiscreteSpace(network), Limits(network)), set[object]()
    with without_collector():
        for node in Search(space).nodes():
            locations, values = node.record.discrete.state
            found.add((locations, tuple(0 if at in left_out else each for at, each in enumerate(values))))
    return found


@pytest.mark.parametrize("noticed", first_of(NOTICED, 2, 0), ids=lambda each: each[1])
def test_a_requirement_notices_it(document: Document, baseline: Baseline, noticed: tuple[str, str]) -> None:
    words, by = noticed
    edits = [each for each in mutants(document, TEMPLATES) if words in str(each)]
    assert by in {id_ for each in edits for id_ in judge(each, baseline).caught_by}


@pytest.mark.skipif(not NIGHTLY, reason="takes minutes: `make nightly` judges the sample")
@pytest.mark.timeout(3600)
def test_what_no_requirement_notices_stands_here(document: Document, baseline: Baseline) -> None:
    found = [judge(each, baseline) for each in drawn(document).values()]
    open_ = (MutantOutcome.SURVIVES, MutantOutcome.OPEN)
    assert {str(each.mutant) for each in found if each.outcome in open_} == UNNOTICED


@pytest.mark.parametrize("name", first_of(NO_RUN_OF_THE_CODE, thinned=0))
def test_the_code_does_what_it_cannot(document: Document, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    number, run = numbered(document, name), played(NO_RUN_OF_THE_CODE[name], monkeypatch)

    def edited(seen: Document) -> Document:
        return list(mutants(seen, TEMPLATES))[number].document

    assert not run.is_one_of(model_text(), edited)


@pytest.mark.parametrize("name", first_of(SAME_STATES, 2, 0))
def test_it_reaches_the_same_states(document: Document, name: str) -> None:
    edited, but = drawn(document)[numbered(document, name)].document, SAME_STATES[name]
    assert reached(make_network(edited), but) == reached(make_network(document), but)
