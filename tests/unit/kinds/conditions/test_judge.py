"""Conditions are three-valued, and last only as long as samples show it."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from end_effector_hal.kinds.conditions import ConditionJudge
from end_effector_hal.kinds.stanza import Condition
from end_effector_hal.signals import Value, clone, memory_of, recall
from tests.support.nightly import examples

from .samples import Samples

T, F, U = True, False, None
PERIOD = 20_000


def holds(condition: dict[str, Any], **values: Value) -> bool | None:
    return ConditionJudge(Condition.model_validate(condition)).sample(Samples(values), 0)


@pytest.mark.parametrize(
    ("a", "b", "both", "either"),
    [
        (T, T, T, T), (T, F, F, T), (T, U, U, T), (F, T, F, T), (F, F, F, F), (F, U, F, U), (U, T, U, T), (U, F, F, U),
        (U, U, U, U),
    ],
)  # fmt: skip
def test_one_that_decides_decides_whatever_is_unknown(a: Value, b: Value, both: Value, either: Value) -> None:
    parts = [{"on": "a"}, {"on": "b"}]
    assert holds({"all": parts}, a=a, b=b) is both
    assert holds({"any": parts}, a=a, b=b) is either
    opposite = {T: F, F: T, U: U}
    assert holds({"not": {"all": parts}}, a=a, b=b) is opposite[both]
    # de Morgan
    assert holds({"any": [{"not": each} for each in parts]}, a=a, b=b) is opposite[both]


@pytest.mark.parametrize(
    ("threshold", "held", "missed"),
    [
        ({"below_kpa": -55}, -55_001, -55_000),
        ({"above_kpa": -10}, -9_999, -10_000),
        ({"between_kpa": [-80, -55]}, -55_000, -54_999),
        ({"between_kpa": [-80, -55]}, -80_000, -80_001),
        ({"above_kpa": 0}, 1, 0),
    ],
)
def test_thresholds_are_gauge_kpa(threshold: dict[str, Any], held: int, missed: int) -> None:
    condition = {"channel": "cup", **threshold}
    assert holds(condition, cup=held) is True
    assert holds(condition, cup=missed) is False
    assert holds(condition, cup=None) is None
    assert holds(condition, cup=True) is None


def run(condition: dict[str, Any], *shown: Value) -> list[bool | None]:
    judge = ConditionJudge(Condition.model_validate(condition))
    return [judge.sample(Samples({"a": each}), i * PERIOD) for i, each in enumerate(shown)]


def test_what_must_last_is_seen_by_the_samples_at_its_ends() -> None:
    assert run({"on": "a", "for_ms": 40}, F, T, T, T, T, F, T) == [F, F, F, T, T, F, F]
    assert run({"on": "a", "samples": 3}, T, T, F, T, T, T) == [F, F, F, F, F, T]
    assert run({"on": "a", "for_ms": 40}, T, T, U, T, T, T) == [F, F, U, F, F, T]
    assert run({"not": {"on": "a", "for_ms": 40}}, T, T, T, U) == [T, T, F, U]


def test_time_alone_makes_nothing_hold() -> None:
    judge = ConditionJudge(Condition.model_validate({"on": "a", "for_ms": 40}))
    assert judge.sample(Samples({"a": T}), 0) is False
    assert judge.sample(Samples({"a": T}, arrived=False), 100_000) is False
    assert judge.sample(Samples({"a": T}), 100_000) is True
    assert judge.sample(Samples({"a": T}, arrived=False), 120_000) is True
    assert judge.sample(Samples({"a": U}, arrived=False), 140_000) is None


def test_a_look_without_a_frame_is_no_sample() -> None:
    judge = ConditionJudge(Condition.model_validate({"on": "a", "samples": 3}))
    looks = [
        judge.sample(Samples({"a": T}, arrived=new), 0) for new in (True, False, False, True, False, True)
    ]
    assert looks == [F, F, F, F, F, T]


LEAVES = st.sampled_from([{"on": "a"}, {"on": "b"}, {"on": "c"}])


def lasting(inner: st.SearchStrategy[dict[str, Any]]) -> st.SearchStrategy[dict[str, Any]]:
    return st.builds(
        lambda each, ms, count: {**each, "for_ms": ms, "samples": count},
        inner,
        st.sampled_from([0, 20, 50]),
        st.sampled_from([1, 2, 3]),
    )


CONDITIONS = st.recursive(
    lasting(LEAVES),
    lambda inside: lasting(
        st.one_of(
            st.builds(lambda parts: {"all": parts}, st.lists(inside, min_size=1, max_size=3)),
            st.builds(lambda parts: {"any": parts}, st.lists(inside, min_size=1, max_size=3)),
            st.builds(lambda part: {"not": part}, inside),
        )
    ),
    max_leaves=6,
)
FRAMES = st.lists(st.tuples(*[st.sampled_from([T, F, U])] * 3), min_size=1, max_size=12)


def slowly(condition: dict[str, Any], frames: list[tuple[Value, ...]], now: int) -> bool | None:
    """What holds at frame ``now``, worked out of the whole past again: without any memory."""
    match condition:
        case {"on": name}:
            instant = frames[now]["abc".index(str(name))]
        case {"not": part}:
            inner = slowly(part, frames, now)
            instant = None if inner is None else not inner
        case {"all": parts}:
            values = [slowly(each, frames, now) for each in parts]
            instant = False if False in values else None if None in values else True
        case {"any": parts}:
            values = [slowly(each, frames, now) for each in parts]
            instant = True if True in values else None if None in values else False
    ms, count = condition["for_ms"], condition["samples"]
    bare = {**condition, "for_ms": 0, "samples": 1}
    if (ms, count) == (0, 1) or instant is None:
        return instant
    first = now + 1
    while first > 0 and slowly(bare, frames, first - 1) is True:
        first -= 1
    length = now + 1 - first
    return length >= count and length > 0 and (now - first) * PERIOD >= ms * 1000


@settings(max_examples=examples(25, 3000), deadline=None)
@given(CONDITIONS, FRAMES)
def test_it_agrees_with_a_judge_that_has_no_memory(
    condition: dict[str, Any], frames: list[tuple[Value, ...]]
) -> None:
    try:
        judge = ConditionJudge(Condition.model_validate(condition))
    except ValueError:  # too deep
        return
    for now, frame in enumerate(frames):
        values = dict(zip("abc", frame, strict=True))
        readings = Samples(values, arrived=True)
        assert judge.sample(readings, now * PERIOD) is slowly(condition, frames, now)


def test_it_can_be_recorded_recalled_and_copied() -> None:
    condition = Condition.model_validate({"all": [{"on": "a", "for_ms": 40}, {"on": "b", "samples": 2}]})
    one, other = ConditionJudge(condition), ConditionJudge(condition)
    one.sample(Samples({"a": T, "b": T}), 0)
    recall(other, memory_of(one))
    third = clone(one)
    for each in (one, other, third):
        assert each.sample(Samples({"a": T, "b": T}), 40_000) is True
