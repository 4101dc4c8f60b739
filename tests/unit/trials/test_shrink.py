"""Delta debugging: the smallest case, within its number of runs."""

from __future__ import annotations

from random import Random

from end_effector_lab.trials import Case, Happening, shrunk_by

NOISE = tuple(Happening(at * 100_003, f"scenario leak:{at},flips") for at in range(40))
CULPRITS = (Happening(1_234_567, "kill hal"), Happening(2_345_678, "start hal"))


def whole() -> Case:
    return Case(9, ()).with_((*NOISE, *CULPRITS))


def test_what_does_not_matter_is_left_out_and_the_rest_is_made_simple() -> None:
    def fails(case: Case) -> bool:
        at = {each.what: each.at for each in case.happenings}
        return "kill hal" in at and at.get("start hal", 0) - at["kill hal"] >= 700_000

    found = shrunk_by(whole(), fails)
    assert found == Case(0, (Happening(0, "kill hal"), Happening(1_000_000, "start hal")))


def test_a_fault_of_two_is_left_out() -> None:
    case = Case(0, (Happening(0, "scenario leak:4, silent-after:0"),))
    assert shrunk_by(case, lambda tried: "silent" in tried.words).words == "scenario silent-after:0"


def test_what_fails_by_itself_needs_nothing() -> None:
    assert shrunk_by(whole(), lambda _: True) == Case(0, ())


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
