"""The mutants of a file, what is kept of judged ones, and the command that judges them."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.control import load_automata
from end_effector_hal.description import load, profile_path
from end_effector_hal.verification import mutation
from end_effector_hal.verification.mutation import kept_record
from end_effector_hal.verification.proof import CHECKS, requirements_of
from tests.unit.timed_automata.explore.models import document
from timed_automata import Network, Template, make_network, read_document
from timed_automata.errors import ModelError, UsageError
from tools.mutants import Mutant, MutantOutcome, MutantVerdict, document_of, mutants, mutation_record, text_of
from tools.mutants.__main__ import command

DOOR = """Door: own: clock t; void leave() { if (n > 2) n = 0; } | Open: t <= HOLD
    Shut -> Open; guard: t >= 3 && !locked; sync: push?; do: n++, t = 0
    Open -> Shut; guard: t == HOLD; do: t = 0, leave()"""
SOURCE = document(
    "typedef int[0, 99] ms_t; const ms_t HOLD = 9; int[0, 5] n; bool locked; chan push, knock;",
    DOOR,
    "World: w -> w; sync: push! | w -> v; sync: knock!",
)


def found(*templates: str) -> list[Mutant]:
    return list(mutants(read_document(SOURCE, "door.xml"), templates or None))


def told(mutant: Mutant) -> str:
    return f"{mutant.element}: {mutant.operator}, {mutant.old} -> {mutant.new}"


def test_each_part_is_edited() -> None:
    every = [told(mutant) for mutant in found("Door")]
    assert every == [
        "declaration of HOLD: constant, 9 -> 10",
        "declaration of HOLD: constant, 9 -> 8",
        "declaration of n: constant,  -> = 1",
        "declaration of locked: constant,  -> = true",
        "function leave: assignment dropped, if (n > 2) n = 0; -> ;",
        "function leave: condition dropped, n > 2 -> true",
        "function leave: comparison, > -> >=",
        "function leave: comparison, > -> <=",
        "function leave: constant, 2 -> 3",
        "function leave: constant, 2 -> 1",
        "function leave: assignment dropped, n = 0; -> ;",
        "function leave: constant, 0 -> 1",
        "function leave: constant, 0 -> -1",
        "location Shut: committed, ordinary -> committed",
        "location Shut: urgent, ordinary -> urgent",
        "invariant of Open: condition dropped, t <= HOLD -> true",
        "invariant of Open: comparison, <= -> <",
        "invariant of Open: comparison, <= -> >",
        "invariant of Open: constant, HOLD -> (HOLD + 1)",
        "invariant of Open: constant, HOLD -> (HOLD - 1)",
        "location Open: committed, ordinary -> committed",
        "location Open: urgent, ordinary -> urgent",
        "Shut -> Open: edge deleted, Shut -> Open -> ",
        "Shut -> Open: target, Shut -> Open -> Shut -> Shut",
        "Shut -> Open, guard: condition dropped, t >= 3 && !locked -> true",
        "Shut -> Open, guard: connective, && -> ||",
        "Shut -> Open, guard: condition dropped, t >= 3 && !locked -> !locked",
        "Shut -> Open, guard: condition dropped, t >= 3 && !locked -> t >= 3",
        "Shut -> Open, guard: comparison, >= -> >",
        "Shut -> Open, guard: comparison, >= -> <",
        "Shut -> Open, guard: constant, 3 -> 4",
        "Shut -> Open, guard: constant, 3 -> 2",
        "Shut -> Open, guard: negation, !locked -> (locked)",
        "Shut -> Open, synchronisation: synchronisation, push? -> ",
        "Shut -> Open, synchronisation: synchronisation, push? -> push!",
        "Shut -> Open, assignment: assignment dropped, n++, t = 0 -> t = 0",
        "Shut -> Open, assignment: constant, ++ -> --",
        "Shut -> Open, assignment: assignment dropped, n++, t = 0 -> n++",
        "Shut -> Open, assignment: constant, 0 -> 1",
        "Shut -> Open, assignment: constant, 0 -> -1",
        "Open -> Shut: edge deleted, Open -> Shut -> ",
        "Open -> Shut: target, Open -> Shut -> Open -> Open",
        "Open -> Shut, guard: condition dropped, t == HOLD -> true",
        "Open -> Shut, guard: comparison, == -> !=",
        "Open -> Shut, guard: constant, HOLD -> (HOLD + 1)",
        "Open -> Shut, guard: constant, HOLD -> (HOLD - 1)",
        "Open -> Shut, assignment: assignment dropped, t = 0, leave() -> leave()",
        "Open -> Shut, assignment: constant, 0 -> 1",
        "Open -> Shut, assignment: constant, 0 -> -1",
        "Open -> Shut, assignment: assignment dropped, t = 0, leave() -> t = 0",
    ]


def test_a_channel_becomes_another_one_of_the_same_direction() -> None:
    edits = [told(mutant) for mutant in found("World") if mutant.operator == "synchronisation"]
    assert "w -> w, synchronisation: synchronisation, push -> knock" in edits
    assert "w -> v, synchronisation: synchronisation, knock -> push" in edits


def test_all_templates_without_a_name_each_in_its_own_and_what_is_global() -> None:
    assert Counter(mutant.template for mutant in found()) == {"": 4, "Door": 46, "World": 14}


def test_an_edit_changes_its_template_or_the_declarations_alone_and_most_are_models() -> None:
    true = read_document(SOURCE, "door.xml")
    valid = 0
    for mutant in mutants(true, ["Door"]):
        assert mutant.document.templates[1] is true.templates[1]
        shared = mutant.document.declarations is true.declarations
        assert shared == (mutant.template == "Door")
        assert (mutant.document.templates[0] is true.templates[0]) == (mutant.template == "")
        try:
            make_network(mutant.document)
        except ModelError:
            continue
        valid += 1
    assert valid == 48  # the others have clocks in a disjunction


@pytest.mark.parametrize(
    ("updates", "swaps"),
    [("n = 1, m = 2", 0), ("n = 1, m = n", 1), ("m = n, n = 1", 1), ("n = 1, n = 2", 1), ("n = 1, set()", 1)],
)
def test_two_assignments_are_swapped_where_their_order_means_something(updates: str, swaps: int) -> None:
    source = document("int n, m; void set() { m = n; }", f"P: a -> b; do: {updates}")
    edits = [each.operator for each in mutants(read_document(source, "p.xml"))]
    assert edits.count("assignments swapped") == swaps


def test_an_unknown_template_is_named() -> None:
    with pytest.raises(UsageError, match=r"no template 'Dor'.*Did you mean 'Door'"):
        found("Dor")


# What is kept of judged mutants: of which edges it speaks, and that it is of the shipped automata.


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


# ``python -m tools.mutants``: a table, JSON, and the survivors by their place.


def run(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(command, list(words), catch_exceptions=False)
    return result.exit_code, result.stdout


@pytest.mark.thinned
@pytest.mark.timeout(300)
def test_a_sample_is_judged_and_the_table_adds_up() -> None:
    code, told = run("--template", "Arming", "--sample", "3", "--jobs", "1")
    assert (
        code == 0
    )  # the shipped tool has sensors of its stand: what is armed is judged with one that has none
    assert told.splitlines()[-3].split() == ["all", "3", "0", "0", "0", "0", "0"]


@pytest.mark.thinned
@pytest.mark.timeout(300)
def test_json_has_each_mutant_and_the_same_seed_the_same_ones() -> None:
    words = ("--template", "Actuator", "--sample", "3", "--seed", "4", "--jobs", "2", "--json")
    code, told = run(*words)
    document = json.loads(told)
    assert next(iter(document.items())) == ("schema_version", 1)
    assert len(document["mutants"]) == sum(document["outcomes"].values()) == 3
    assert {each["template"] for each in document["mutants"]} <= {"Actuator", ""}  # and what it uses
    caught = [each for each in document["mutants"] if each["outcome"] == "caught"]
    assert caught
    assert all(each["caught_by"] for each in caught)
    assert (code, json.loads(run(*words)[1])) == (0, document)


@pytest.mark.thinned
@pytest.mark.timeout(300)
def test_what_was_found_is_written(tmp_path: Path) -> None:
    path = tmp_path / "record.json"
    words = ("--template", "Arming", "--sample", "3", "--seed", "9", "--jobs", "1")
    code, _ = run(*words, "--record", str(path))
    record = json.loads(path.read_text(encoding="utf-8"))
    assert (code, record["judged"]) == (0, 3)
    assert record["of"] > 100
    assert record["edges"]


@pytest.mark.thinned
@pytest.mark.timeout(300)
def test_only_what_is_executed_is_edited() -> None:
    with pytest.raises(
        UsageError, match=r"executes a template 'Sensors'.*Gripper, Actuator, Changer, Arming"
    ):
        run("--template", "Sensors")
