"""Wrong controllers and line arbiters, each of which a campaign finds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import pytest

from end_effector_hal.arbiter import LineArbiter
from end_effector_hal.arbiter.rules._lines import OutputLines
from end_effector_hal.arbiter.rules._predicates import SensorPredicates
from end_effector_hal.control import Controller, GripLastWill
from end_effector_hal.kinds.vacuum._detector import VacuumDetector
from end_effector_hal.runtime.outputs import GripOutputs
from end_effector_hal.sensing import SensorSet
from end_effector_hal.vocabulary import EndEffectorState, Evidence


class WrongProduct(NamedTuple):
    """A mutant: how it is made, the smallest case that a campaign found, and the kind of its failure."""

    patch: Callable[[pytest.MonkeyPatch], None]
    words: str
    kind: str


def _no_last_will(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(GripOutputs, "last_will", lambda *_, **__: ())


def _last_will_drops(patch: pytest.MonkeyPatch) -> None:
    real = GripLastWill.of

    def drops(will: GripLastWill, status: Any, **on: Any) -> Any:
        return real(will, replace(status, held=False), **on)

    patch.setattr(GripLastWill, "of", drops)


def _last_will_in_wrong_order(patch: pytest.MonkeyPatch) -> None:
    real = GripLastWill.of

    def at_once(will: GripLastWill, status: Any, **on: Any) -> Any:
        return tuple(step._replace(after_us=0) for step in reversed(real(will, status, **on)))

    patch.setattr(GripLastWill, "of", at_once)


def _death_is_not_noticed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(
        LineArbiter, "declare_dead", lambda arbiter, session, _, at: arbiter._end_session(session, (), at)
    )


def _latch_is_forgotten(patch: pytest.MonkeyPatch) -> None:
    real = SensorPredicates.__init__

    def begins(predicates: Any, needs: Any, valid_us: int, faults: Any, *more: Any) -> None:
        real(predicates, needs, valid_us, {}, *more)

    patch.setattr(SensorPredicates, "__init__", begins)


def _switches_at_once(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(OutputLines, "last_ready_at", lambda *_: 0)


def _adopts_nothing(patch: pytest.MonkeyPatch) -> None:
    real = Controller._adopt

    def blind(controller: Controller, at: int) -> Any:
        controller._statuses.found = dict.fromkeys(controller._statuses.found, False)
        return real(controller, at)

    patch.setattr(Controller, "_adopt", blind)


def _releases_at_once(patch: pytest.MonkeyPatch) -> None:
    real = GripOutputs.levels

    def levels(outputs: GripOutputs, status: Any) -> dict[str, bool]:
        found = real(outputs, status)
        return dict.fromkeys(found, False) if status.ee == EndEffectorState.RELEASING else found

    patch.setattr(GripOutputs, "levels", levels)


def _partial_is_confirmed(patch: pytest.MonkeyPatch) -> None:
    real = VacuumDetector.sample

    def sample(detector: VacuumDetector, readings: Any, at: int) -> Evidence:
        if real(detector, readings, at) is Evidence.PARTIAL:
            detector.level = Evidence.CONFIRMED
        return detector.level

    patch.setattr(VacuumDetector, "sample", sample)


def _stale_proof_is_believed(patch: pytest.MonkeyPatch) -> None:
    real = SensorPredicates.objection

    def objection(predicates: SensorPredicates, need: Any, at: int) -> str:
        proof = predicates.proofs.get(need.predicate)
        return "" if proof and proof.holds else real(predicates, need, at)

    patch.setattr(SensorPredicates, "objection", objection)


def _no_interlocks(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(LineArbiter, "_check_activation", lambda *_: None)


def _last_will_is_forgotten(patch: pytest.MonkeyPatch) -> None:
    real = LineArbiter._restore
    patch.setattr(
        LineArbiter, "_restore", lambda arbiter, record, at: real(arbiter, record._replace(will=()), at)
    )


def _air_is_ignored(patch: pytest.MonkeyPatch) -> None:
    real = SensorSet.levels.fget
    assert real
    patch.setattr(SensorSet, "levels", property(lambda senses: {**real(senses), "supply_ok": 1}))


MUTANTS: Mapping[str, WrongProduct] = {
    "no last will": WrongProduct(_no_last_will, "grip; wait 0.5; kill hal", "unwound"),
    "a last will that drops what is held": WrongProduct(_last_will_drops, "grip; wait 1.5; end grip", "held"),
    "a last will in the wrong order": WrongProduct(
        _last_will_in_wrong_order, "grip; wait 0.5; kill hal", "order"
    ),
    "a death that the line arbiter does not notice": WrongProduct(
        _death_is_not_noticed, "grip; kill hal", "unwound"
    ),
    "a latch that is forgotten at a restart": WrongProduct(
        _latch_is_forgotten, "scenario locked-shows:tool_changer:0; wait 5; kill arbiter", "latched"
    ),
    "a proof that never expires": WrongProduct(
        _stale_proof_is_believed, "grip; wait 0.2; scenario silent-after:0", "activation"
    ),
    "no interlocks": WrongProduct(_no_interlocks, "grip; wait 0.2; scenario silent-after:0", "activation"),
    "a last will that dies with the line arbiter": WrongProduct(
        _last_will_is_forgotten, "grip; wait 0.5; kill all; wait 0.1; start all", "unwound"
    ),
    "air that does not count": WrongProduct(_air_is_ignored, "scenario supply:350; wait 3; grip", "refusals"),
    "lines that are switched without a pause": WrongProduct(_switches_at_once, "grip; kill all", "switching"),
    "a restart that adopts nothing": WrongProduct(_adopts_nothing, "grip; wait 1.5; end grip", "held"),
    "a release of all at once": WrongProduct(_releases_at_once, "", "order"),
    "a weak vacuum that counts as a grip": WrongProduct(_partial_is_confirmed, "", "evidence"),
}
