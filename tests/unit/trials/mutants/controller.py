"""Wrong programs: what controls the tool, reads its sensors and writes its lines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.control import Controller, GripLastWill, _network
from end_effector_hal.control._status_builder import StatusBuilder
from end_effector_hal.kinds.cylinder import CylinderDetector
from end_effector_hal.kinds.vacuum import VacuumDetector
from end_effector_hal.runtime.outputs import OutputMapping, Outputs
from end_effector_hal.runtime.programs._adoption import Adoption
from end_effector_hal.runtime.programs._program import Program
from end_effector_hal.runtime.programs._sensor_fault import SensorFault
from end_effector_hal.sensing import Predicates, SensorSet, _link_rules
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.sensing._sensor_state import SensorState
from end_effector_hal.sensing.detectors import ReleaseDetector, ToolDetector
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import EndEffectorState, Evidence, ToolEvidence

from .wrong_product import Patch, WrongProduct

GRIPPED, RELEASING = EndEffectorState.GRIPPED, EndEffectorState.RELEASING


def _replaced(owner: type, name: str, new: Callable[..., Any]) -> Patch:
    """A method that does something else; ``new`` gets the right one first."""
    real = getattr(owner, name)
    return lambda patch: patch.setattr(owner, name, lambda *given, **named: new(real, *given, **named))


def _constants(**wrong: Callable[[Any], Any]) -> Patch:
    """Constants that do not come from the description as they should."""

    def make(patch: pytest.MonkeyPatch) -> None:
        real = _network.model_constants
        patch.setattr(
            _network,
            "model_constants",
            lambda description: {
                name: wrong[name](value) if name in wrong else value
                for name, value in real(description).items()
            },
        )

    return make


def _edited(old: bytes, new: bytes) -> Patch:
    """Another UPPAAL file."""

    def make(patch: pytest.MonkeyPatch) -> None:
        real = _network.load_source

        def load(path: Any) -> bytes:
            source = real(path)
            assert source.count(old) == 1
            return source.replace(old, new)

        patch.setattr(_network, "load_source", load)

    return make


# control


def _drops(real: Any, will: GripLastWill, status: Any, **on: Any) -> Any:
    return real(will, replace(status, held=False), **on)


def _in_wrong_order(real: Any, will: GripLastWill, status: Any, **on: Any) -> Any:
    return tuple(step._replace(after_us=0) for step in reversed(real(will, status, **on)))


def _without_pauses(real: Any, will: GripLastWill, status: Any, **on: Any) -> Any:
    return tuple(step._replace(after_us=0) for step in real(will, status, **on))


def _release_stops(real: Any, will: GripLastWill, status: Any, **on: Any) -> Any:
    return () if status.ee == RELEASING else real(will, status, **on)


def _adopts_nothing(real: Any, controller: Controller, at: int) -> Any:
    controller._statuses.found = dict.fromkeys(controller._statuses.found, False)
    return real(controller, at)


def _only_gripped_is_held(real: Any, statuses: StatusBuilder, values: Mapping[str, int]) -> None:
    real(statuses, values)
    statuses.held = statuses.held and statuses.values["ee"] == GRIPPED


def _lift_whenever_gripped(real: Any, statuses: StatusBuilder, *given: Any) -> Any:
    status = real(statuses, *given)
    return replace(status, lift_allowed=status.ee == GRIPPED)


# runtime


def _releases_at_once(real: Any, outputs: OutputMapping, status: Any) -> dict[str, bool]:
    found: dict[str, bool] = real(outputs, status)
    return dict.fromkeys(found, False) if status.ee == RELEASING else found


def _leaves_as_it_is(real: Any, program: Program, _ending: str = "sigterm") -> None:
    patched = program._adoption.outputs.mapping
    patched.last_will = lambda *_, **__: ()  # type: ignore[method-assign]
    real(program)


def _writes_late(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Adoption, "look", lambda *_: None)
    patch.setattr(Program, "_give_up", lambda _: [])


def _forgets_deactivations(real: Any, outputs: Outputs, changes: Mapping[str, bool]) -> None:
    real(outputs, changes)
    outputs._undone = {}


# sensing


def _air_is_ignored(patch: pytest.MonkeyPatch) -> None:
    real = SensorSet.levels.fget
    assert real
    patch.setattr(SensorSet, "levels", property(lambda senses: {**real(senses), "supply_ok": 1}))


def _adopts_at_once(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(SensorSet, "conclusive", property(lambda _: True))


def _last_value(_: Any, readings: Readings, channel: str | None, at: int) -> Any:
    del at
    return readings._values.get(channel or "")


def _invalid_is_a_sample(real: Any, readings: Readings, frame: Frame, *doubted: Any) -> None:
    known = {
        channel: readings._values.get(channel) if value is None else value
        for channel, value in frame.values.items()
    }
    real(readings, replace(frame, values=known), *doubted)


def _one_bit_is_enough(real: Any, detector: ToolDetector, readings: Readings, at: int) -> ToolEvidence:
    level: ToolEvidence = real(detector, readings, at)
    if readings.fresh.get(detector._changer.locked_bit):
        level = detector.level = ToolEvidence.LOCKED
    return level


def _gone_is_enough(_: Any, detector: ReleaseDetector, readings: Any, evidence: Any, at: int) -> bool:
    del detector, readings, at
    return all(level is Evidence.GONE for level in evidence)


def _locked_unless_unlocked(real: Any, predicates: Predicates, at: int) -> dict[str, bool]:
    said: dict[str, bool] = real(predicates, at)
    return said | {"locked": predicates._senses.now.tool is not ToolEvidence.UNLOCKED}


# kinds


def _partial_is_confirmed(real: Any, detector: VacuumDetector, readings: Any, at: int) -> Evidence:
    if real(detector, readings, at) is Evidence.PARTIAL:
        detector.level = Evidence.CONFIRMED
    return detector.level


def _lost_at_once_only(real: Any, detector: VacuumDetector, readings: Any, at: int) -> Evidence:
    held = detector._held
    real(detector, readings, at)
    if held and detector.level is Evidence.PARTIAL:
        detector._held, detector.level = True, Evidence.CONFIRMED
    return detector.level


def _gone_when_lost(real: Any, detector: Any, readings: Any, at: int) -> Evidence:
    if real(detector, readings, at) is Evidence.PARTIAL:
        detector.level = Evidence.GONE
    return detector.level


def _share_of_any_air(detector: CylinderDetector, readings: Any) -> float:
    supply = readings.fresh[detector._supply.channel]
    return float(detector._actuator.extended_fraction * supply - 20_000)


CONTROLLER: Mapping[str, WrongProduct] = {
    "a last will that drops what is held": WrongProduct(
        _replaced(GripLastWill, "of", _drops), "control/_last_wills.py: GripLastWill.of",
        "grip; wait 1.5; end hal", "held",
        cell="nominal @ grip GRIPPED, between + kill hal",
    ),
    "a last will in the wrong order": WrongProduct(
        _replaced(GripLastWill, "of", _in_wrong_order), "control/_last_wills.py: GripLastWill.of",
        "grip; wait 0.5; kill hal", "order",
    ),
    "a last will that waits for nothing": WrongProduct(
        _replaced(GripLastWill, "of", _without_pauses), "control/_last_wills.py: GripLastWill.of",
        "grip; wait 1.2; kill hal", "order",
    ),
    "a release that nobody ends after a death": WrongProduct(
        _replaced(GripLastWill, "of", _release_stops), "control/_last_wills.py: GripLastWill.of",
        "grip; wait 2; drop; wait 0.1; kill hal", "unwound",
        cell="nominal @ release top_vacuum off, between + kill hal",
    ),
    "a restart that adopts nothing": WrongProduct(
        _replaced(Controller, "_adopt", _adopts_nothing), "control/_controller.py: Controller._adopt",
        "grip; wait 1.5; end hal", "held",
        cell="nominal @ grip GRIPPED, between + kill hal",
    ),
    "a lost grip that counts as not held": WrongProduct(
        _replaced(StatusBuilder, "know", _only_gripped_is_held), "control/_status_builder.py: StatusBuilder.know",
        "grip; wait 2; scenario lost-after:top_vacuum:0.1; wait 1; kill hal", "held",
    ),
    "a leave to lift without evidence": WrongProduct(
        _replaced(StatusBuilder, "status", _lift_whenever_gripped), "control/_status_builder.py: StatusBuilder.status",
        "grip; wait 2; scenario silent-after:0", "evidence",
    ),
    "an attempt too many": WrongProduct(
        _constants(ATTEMPTS=lambda each: [[number + 1 for number in part] for part in each]),
        "control/_constants.py: ATTEMPTS",
        "scenario never-confirms:bottom_vacuum; grip", "activation",
        cell="fails:cylinder:3 @ rest + none",
    ),
    "no pause between two attempts": WrongProduct(
        _constants(T_RESET=lambda each: [100 for _ in each]), "control/_constants.py: T_RESET",
        "scenario fails-once:bottom_vacuum; grip", "activation",
    ),
    "a release that waits for nothing": WrongProduct(
        _constants(T_GONE=lambda each: [60 for _ in each]), "control/_constants.py: T_GONE",
        "", "order",
        cell="never-confirms:cylinder @ rest + none",
    ),
    "automata that release when a part is lost": WrongProduct(
        _constants(LOSS_KEEPS=lambda each: [False for _ in each]), "the UPPAAL file: Gripped → Abort",
        "grip; wait 2; scenario lost-after:top_vacuum:0.1", "held",
        cell="lost-after:top_vacuum:0.1 @ grip GRIPPED, between + none",
    ),
    "automata that resume without evidence": WrongProduct(
        _edited(b"firm() &amp;&amp; fastened()</label>", b"fastened()</label>"),
        "the UPPAAL file: GripError → Resumed",
        "grip; wait 2; scenario lost-after:top_vacuum:0.1; wait 1; resume", "evidence",
    ),
    "automata that resume by themselves": WrongProduct(
        _edited(b"""<label kind="synchronisation" x="1275" y="224">resume?</label>""", b""),
        "the UPPAAL file: GripError → Resumed",
        "grip; wait 2; scenario shows:top_vacuum:-30; wait 0.5; scenario nominal", "evidence",
    ),
    "automata that leave out the last step of a drop": WrongProduct(
        _edited(b"t = 0, k = next_engaged()</label>", b"t = 0, k = next_engaged() + 1</label>"),
        "the UPPAAL file: Gripped → Unwind", "", "order",
        cell="nominal @ release top_vacuum off, between + kill hal",
    ),
    "no last will": WrongProduct(
        lambda patch: patch.setattr(OutputMapping, "last_will", lambda *_, **__: ()),
        "runtime/outputs/_output_mapping.py: OutputMapping.last_will", "grip; wait 0.5; kill hal", "unwound",
        cell="nominal @ grip top_vacuum on, between + kill hal",
    ),
    "a release of all at once": WrongProduct(
        _replaced(OutputMapping, "levels", _releases_at_once),
        "runtime/outputs/_output_mapping.py: OutputMapping.levels", "", "order",
    ),
    "an orderly end that leaves the lines as they are": WrongProduct(
        _replaced(Program, "leave", _leaves_as_it_is), "runtime/programs/_program.py: Program.leave",
        "grip; wait 0.5; end hal", "unwound",
    ),
    "deactivations that are forgotten with the line arbiter": WrongProduct(
        _replaced(Outputs, "_fail", _forgets_deactivations), "runtime/outputs/_outputs.py: Outputs._fail",
        "grip; wait 2; drop; wait 0.1; kill arbiter; wait 0.6; start arbiter", "order",
    ),
    "a drop that is written once the line arbiter is back": WrongProduct(
        _writes_late, "runtime/programs/_program.py: Program._give_up",
        "grip; wait 2; kill arbiter; drop; wait 9; start arbiter", "late",
    ),
    "a sensor fault that a restart forgets": WrongProduct(
        lambda patch: patch.setattr(SensorFault, "found", lambda _: False),
        "runtime/programs/_sensor_fault.py: SensorFault.found",
        "scenario locked-shows:tool_changer:0; wait 5; scenario nominal; wait 2; kill hal; start hal",
        "latched",
    ),
    "air that does not count": WrongProduct(
        _air_is_ignored, "sensing/_sensor_set.py: SensorSet.levels", "scenario supply:350; wait 3; grip", "refusals",
        cell="supply:350 @ rest + none",
    ),
    "a restart that does not wait for the sensors": WrongProduct(
        _adopts_at_once, "sensing/_sensor_set.py: SensorSet.conclusive",
        "nominal @ grip GRIPPED, between + kill hal", "success",
    ),
    "a stale reading that counts as the last value": WrongProduct(
        _replaced(Readings, "get", _last_value), "sensing/_readings.py: Readings.get",
        "scenario silent-after:0; wait 2; grip", "refusals",
        cell="silent-after:0 @ rest + none",
    ),
    "an invalid value that counts as the last one": WrongProduct(
        _replaced(Readings, "take", _invalid_is_a_sample), "sensing/_readings.py: Readings.take",
        "invalid:top_vacuum @ rest + none", "effects",
    ),
    "a bit that is believed although the other one contradicts": WrongProduct(
        _replaced(ToolDetector, "sample", _one_bit_is_enough), "sensing/detectors.py: ToolDetector.sample",
        "unlocked-shows:tool_changer:1 @ rest + none", "effects",
    ),
    "an unlock that does not wait for the vacuum": WrongProduct(
        _replaced(ReleaseDetector, "sample", _gone_is_enough), "sensing/detectors.py: ReleaseDetector.sample",
        "grip; wait 2; drop; wait 1.5; unlock", "unlock",
    ),
    "a stand that nobody looks at": WrongProduct(
        lambda patch: patch.setattr(SensorState, "_is_in_stand", lambda *_: True),
        "sensing/_sensor_state.py: SensorState._is_in_stand",
        "scenario stand-shows:tool_changer:0; wait 2; unlock", "unlock",
    ),
    "locked, unless it is unlocked": WrongProduct(
        _replaced(Predicates, "said", _locked_unless_unlocked), "sensing/_predicates.py: Predicates.said",
        "locked-shows:tool_changer:0 @ grip bottom_vacuum on + none", "effects",
    ),
    "a frozen sensor that is believed": WrongProduct(
        lambda patch: patch.setattr(_link_rules, "frozen_after", lambda *_: {}),
        "sensing/_link_rules.py: frozen_after",
        "frozen-after:bottom_vacuum:0 @ grip GRIPPED, between + none", "effects",
    ),
    "a weak vacuum that counts as a grip": WrongProduct(
        _replaced(VacuumDetector, "sample", _partial_is_confirmed), "kinds/vacuum.py: VacuumDetector.sample",
        "", "evidence",
        cell="nominal @ grip GRIPPED, between + kill hal",
    ),
    "a loss that is noticed only below 20 kPa": WrongProduct(
        _replaced(VacuumDetector, "sample", _lost_at_once_only), "kinds/vacuum.py: VacuumDetector.sample",
        "grip; wait 2; scenario leak-grows:top_vacuum:2; wait 14; cancel", "evidence",
        cell="lost-after:top_vacuum:0.1 @ grip GRIPPED, between + none",
    ),
    "a vacuum that is gone as soon as it is lost": WrongProduct(
        _replaced(VacuumDetector, "sample", _gone_when_lost), "kinds/vacuum.py: VacuumDetector.sample",
        "", "evidence",
    ),
    "a cylinder that is retracted as soon as it moves": WrongProduct(
        _replaced(CylinderDetector, "sample", _gone_when_lost), "kinds/cylinder.py: CylinderDetector.sample",
        "grip; wait 0.6; cancel", "evidence",
    ),
    "a share of no air that counts as extended": WrongProduct(
        lambda patch: patch.setattr(CylinderDetector, "_threshold_pa", _share_of_any_air),
        "kinds/cylinder.py: CylinderDetector._threshold_pa", "supply:0 @ grip cylinder on + none",
        "evidence",
    ),
}  # fmt: skip
