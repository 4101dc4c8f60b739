"""What happens to a tool, as text and as a file."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_lab.trials import Case, Happening, case_from_json, case_from_words, read_case, shrunk_by

SHIPPED = load(profile_path())
WORDS = "scenario leak:top_vacuum:4,flips:0.001; grip; wait 12.250001; kill hal; wait 1; start hal; power"


def test_words_and_json_are_the_same_case() -> None:
    case = case_from_words(WORDS, SHIPPED, seed=7)
    assert case.happenings[2] == Happening(12_250_001, "kill hal")
    assert case.words == WORDS
    assert case_from_json(json.loads(json.dumps(case.as_json())), SHIPPED) == case


def test_a_file_has_json_or_words(tmp_path: Path) -> None:
    (tmp_path / "case.json").write_text(json.dumps(case_from_words(WORDS, SHIPPED).as_json()))
    (tmp_path / "case.txt").write_text(WORDS.replace("; ", "\n"))
    assert read_case(tmp_path / "case.json", SHIPPED) == read_case(tmp_path / "case.txt", SHIPPED)


def test_happenings_are_put_in_order() -> None:
    found = case_from_json({"seed": 0, "happenings": [[2, "drop"], [1, "grip"]]}, SHIPPED)
    assert found == Case(0, (Happening(1_000_000, "grip"), Happening(2_000_000, "drop")))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("gripp", "Nothing is named 'gripp'"),
        ("kill nobody", "Nothing is named 'kill nobody'"),
        ("disk journal broken", "Nothing is named 'disk journal broken'"),
        ("scenario leak:nothing", "no actuator is named 'nothing'"),
        ("wait long; grip", "expected is 'wait SECONDS'"),
        ("wait inf; grip", "wait SECONDS"),
        ("wait nan; grip", "wait SECONDS"),
        ("wait -1; grip", "not a case of a campaign"),
        ("; ".join(["grip"] * 501), "not a case of a campaign"),
        ('{"seed": true, "happenings": []}', "not a case of a campaign"),
        ('{"seed": 0, "happenings": [[0]]}', "not a case of a campaign"),
        ('{"seed": 0}', "not a case of a campaign"),
        ('{"seed": 0', "cannot be read"),
        ("[" * 10 + "{" * 100_000, "Nothing is named"),
        ('{"a":' * 100_000, "cannot be read"),
        ("x" * 1_000_001, "more than 1000000 bytes"),
    ],
)
def test_a_file_that_is_no_case_is_refused(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "case"
    path.write_text(text)
    with pytest.raises(UsageError, match=says):
        read_case(path, SHIPPED)


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "case"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(UsageError, match="cannot be read"):
        read_case(path, SHIPPED)


NOISE = tuple(Happening(at * 100_003, f"scenario leak:{at},flips") for at in range(40))
CULPRITS = (Happening(1_234_567, "kill hal"), Happening(2_345_678, "start hal"))


def whole() -> Case:
    return Case(9, ()).with_((*NOISE, *CULPRITS))


def test_what_does_not_matter_is_left_out() -> None:
    def fails(case: Case) -> bool:
        at = {each.what: each.at for each in case.happenings}
        return "kill hal" in at and at.get("start hal", 0) - at["kill hal"] >= 700_000

    found = shrunk_by(whole(), fails)
    assert found == Case(9, CULPRITS)


def test_what_fails_by_itself_needs_nothing() -> None:
    assert shrunk_by(whole(), lambda _: True) == Case(9, ())


def test_it_fails_still_and_the_number_of_runs_is_bounded() -> None:
    asked: list[Case] = []

    def fails(case: Case) -> bool:
        asked.append(case)
        return len(case.happenings) % 3 == 0 and len(case.happenings) > 20

    found = shrunk_by(whole(), fails, most=25)
    assert len(asked) <= 25
    assert len(set(asked)) == len(asked)
    assert len(found.happenings) % 3 == 0


def test_the_order_of_the_happenings_stays() -> None:
    random = Random(1)
    wanted = [each.what for each in random.sample(NOISE, 3)]
    wanted.sort(key=[each.what for each in NOISE].index)
    found = shrunk_by(whole(), lambda tried: [w for w in wanted if w in tried.words] == wanted)
    assert [each.what for each in found.happenings] == wanted or len(found.happenings) == len(wanted)
