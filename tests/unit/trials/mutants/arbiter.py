"""Wrong line arbiters, and records of theirs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.arbiter import LineArbiter
from end_effector_hal.arbiter.records import Journal
from end_effector_hal.arbiter.rules import Session
from end_effector_hal.arbiter.rules._interlocks import LineInterlocks
from end_effector_hal.arbiter.rules._lines import OutputLines
from end_effector_hal.arbiter.rules._predicates import SensorPredicates

from .wrong_product import WrongProduct


def _death_is_not_noticed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(
        LineArbiter,
        "declare_dead",
        lambda arbiter, session, why, at: arbiter._end_session(session, (), why, at),
    )


def _latch_is_forgotten(patch: pytest.MonkeyPatch) -> None:
    real = SensorPredicates.__init__

    def begins(predicates: Any, needs: Any, valid_us: int, faults: Any, *more: Any) -> None:
        real(predicates, needs, valid_us, {}, *more)

    patch.setattr(SensorPredicates, "__init__", begins)


def _stale_proof_is_believed(patch: pytest.MonkeyPatch) -> None:
    real = SensorPredicates.__init__

    def begins(predicates: Any, needs: Any, valid_us: int, *more: Any) -> None:
        real(predicates, needs, 1 << 62, *more)

    patch.setattr(SensorPredicates, "__init__", begins)


def _last_will_is_forgotten(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter._restore
    patch.setattr(
        LineArbiter, "_restore", lambda arbiter, record, at: real(arbiter, record._replace(will=()), at)
    )


def _bye_holds(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter.bye
    patch.setattr(LineArbiter, "bye", lambda arbiter, session, _, at: real(arbiter, session, (), at))


def _last_will_at_once(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter._end_session

    def ends(arbiter: LineArbiter, session: Session, will: Any, why: str, at: int) -> None:
        real(arbiter, session, tuple(step._replace(after_us=0) for step in will), why, at)

    patch.setattr(LineArbiter, "_end_session", ends)


def _only_the_living_are_recorded(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter.state.fget
    assert real

    def state(arbiter: LineArbiter) -> Any:
        whole = real(arbiter)
        return replace(whole, clients=tuple(each for each in whole.clients if not each.ended))

    patch.setattr(LineArbiter, "state", property(state))


def _who_is_absent_stays(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter.expire

    def expire(arbiter: LineArbiter, at: int) -> Any:
        for session in arbiter.sessions:
            session.lease_until = 1 << 62 if session.absent else session.lease_until
        return real(arbiter, at)

    patch.setattr(LineArbiter, "expire", expire)


def _journal_is_not_written(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Journal, "keep", lambda *_, **__: None)


def _any_token_will_do(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter.hello

    def hello(arbiter: LineArbiter, client: str, token: str, *more: Any, **named: Any) -> Session:
        for session in arbiter.sessions:
            session.token = token if session.absent and session.client == client else session.token
        return real(arbiter, client, token, *more, **named)

    patch.setattr(LineArbiter, "hello", hello)


def _last_will_alone_is_ignored(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter.write

    def write(arbiter: LineArbiter, session: Session, levels: Any, will: Any, at: int, **named: Any) -> int:
        return real(arbiter, session, levels, will if levels else None, at, **named)

    patch.setattr(LineArbiter, "write", write)


def _nobody_waits_for_a_last_will(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter.hello

    def hello(arbiter: LineArbiter, *given: Any, **named: Any) -> Session:
        ended = [each for each in arbiter.sessions if each.ended]
        arbiter.sessions = [each for each in arbiter.sessions if not each.ended]
        try:
            return real(arbiter, *given, **named)
        finally:
            arbiter.sessions += ended

    patch.setattr(LineArbiter, "hello", hello)


def _the_dead_are_removed(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter.advance

    def advance(arbiter: LineArbiter, at: int) -> None:
        real(arbiter, at)
        arbiter.sessions = [each for each in arbiter.sessions if not each.ended]

    patch.setattr(LineArbiter, "advance", advance)


def _last_step_is_lost(patch: pytest.MonkeyPatch) -> None:
    def applies(arbiter: LineArbiter, session: Session, at: int) -> None:
        while session.queue and arbiter._lines.last_ready_at([session.queue[0]]) <= at:
            arbiter._lines.set(session.queue.popleft().levels, at)
            if session.ended and len(session.queue) == 1:
                session.queue.clear()

    patch.setattr(LineArbiter, "_apply_due", applies)


ARBITER: Mapping[str, WrongProduct] = {
    "a death that the line arbiter does not notice": WrongProduct(
        _death_is_not_noticed, "arbiter/rules/_arbiter.py: LineArbiter.declare_dead", "grip; kill hal", "unwound",
        cell="nominal @ grip top_vacuum on, between + kill hal",
    ),
    "a last will of all at once": WrongProduct(
        _last_will_at_once, "arbiter/rules/_arbiter.py: LineArbiter._end_session", "grip; wait 1.2; kill hal", "order"
    ),
    "an orderly end whose last will is not executed": WrongProduct(
        _bye_holds, "arbiter/rules/_arbiter.py: LineArbiter.bye", "grip; wait 0.5; end hal", "unwound"
    ),
    "a last will that is left alone, and not kept": WrongProduct(
        _last_will_alone_is_ignored, "arbiter/rules/_arbiter.py: LineArbiter.write", "grip; wait 1.5; kill hal", "held",
        cell="nominal @ grip GRIPPED, between + kill hal",
    ),
    "a last will that dies with the line arbiter": WrongProduct(
        _last_will_is_forgotten, "arbiter/rules/_arbiter.py: LineArbiter._restore",
        "grip; wait 0.5; kill all; wait 0.1; start all", "unwound",
        cell="nominal @ grip top_vacuum on, between + kill both",
    ),
    "a last will that is not continued by the next arbiter": WrongProduct(
        _only_the_living_are_recorded, "arbiter/rules/_arbiter.py: LineArbiter.state",
        "grip; wait 0.9; kill hal; kill arbiter; start arbiter", "unwound",
        cell="nominal @ grip top_vacuum on, between + kill both",
    ),
    "a session that is removed before its last will is done": WrongProduct(
        _the_dead_are_removed, "arbiter/rules/_arbiter.py: LineArbiter.advance", "grip; wait 0.9; kill hal", "unwound",
        cell="nominal @ grip top_vacuum on, between + kill hal",
    ),
    "a program that is waited for without an end": WrongProduct(
        _who_is_absent_stays, "arbiter/rules/_arbiter.py: LineArbiter.expire",
        "grip; wait 0.5; kill arbiter; kill hal; start arbiter", "unwound",
    ),
    "a program that is taken for the one before it": WrongProduct(
        _any_token_will_do, "arbiter/rules/_arbiter.py: LineArbiter.hello",
        "grip; wait 0.5; kill arbiter; kill hal; wait 0.1; start all", "unwound",
    ),
    "a program that begins while a last will is executed": WrongProduct(
        _nobody_waits_for_a_last_will, "arbiter/rules/_arbiter.py: LineArbiter.hello",
        "grip; wait 0.9; kill hal; start hal", "held",
        cell="nominal @ grip top_vacuum on, between + kill hal",
    ),
    "a last step that is lost": WrongProduct(
        _last_step_is_lost, "arbiter/rules/_arbiter.py: LineArbiter._apply_due", "grip; wait 0.9; kill hal", "unwound",
        cell="nominal @ grip top_vacuum on, between + kill hal",
    ),
    "no interlocks": WrongProduct(
        lambda patch: patch.setattr(LineInterlocks, "check", lambda *_: None),
        "arbiter/rules/_interlocks.py: LineInterlocks.check",
        "grip; wait 0.2; scenario silent-after:0",
        "activation",
        cell="locked-shows:tool_changer:0 @ grip bottom_vacuum on + none",
    ),
    "a proof that never expires": WrongProduct(
        _stale_proof_is_believed, "arbiter/rules/_predicates.py: SensorPredicates.__init__",
        "grip; wait 0.2; scenario silent-after:0", "activation",
    ),
    "a latch that is forgotten at a restart": WrongProduct(
        _latch_is_forgotten, "arbiter/rules/_predicates.py: SensorPredicates.__init__",
        "scenario locked-shows:tool_changer:0; wait 5; kill arbiter", "latched",
    ),
    "a fault of a client that is not latched": WrongProduct(
        lambda patch: patch.setattr(LineArbiter, "latch", lambda *_: None),
        "arbiter/rules/_arbiter.py: LineArbiter.latch",
        "scenario locked-shows:tool_changer:0; wait 5; scenario nominal; wait 2; kill hal; start hal",
        "latched",
    ),
    "a refused reset that clears the fault all the same": WrongProduct(
        lambda patch: patch.setattr(LineArbiter, "_latched_by", lambda _: {}),
        "arbiter/rules/_arbiter.py: LineArbiter._latched_by",
        "scenario unlocked-shows:tool_changer:1; wait 8; reset; end hal", "latched",
    ),
    "lines that are switched without a pause": WrongProduct(
        lambda patch: patch.setattr(OutputLines, "last_ready_at", lambda *_: 0),
        "arbiter/rules/_lines.py: OutputLines.last_ready_at", "grip; kill all", "switching",
    ),
    "a journal that is not written": WrongProduct(
        _journal_is_not_written, "arbiter/records/_journal.py: Journal.keep",
        "scenario locked-shows:tool_changer:0; wait 5; power", "latched",
    ),
}  # fmt: skip
