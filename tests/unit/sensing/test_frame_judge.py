"""A frame is judged once, and each of those who look at it decides as if it were alone."""

from __future__ import annotations

from random import Random

import pytest

from end_effector_hal.codecs import codec_of
from end_effector_hal.control import Controller, Status, model_constants
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.sensing import FrameJudge, Predicates
from end_effector_hal.sensing._link_rules import Judged, LinkRules
from end_effector_hal.sensing._sensor_state import SensorState
from end_effector_hal.signals import Frame, Value, clone, memory_of, same_memory
from timed_automata import Network, load_network

PERIOD = 20_000
QUIET: dict[str, Value] = {
    "bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000, "cylinder_extended": False, "cylinder_retracted": True,
    "locked": True, "unlocked": False, "tool_present": True, "in_stand": True, "estop_ok": True,
}  # fmt: skip
PRESSURES = ("bottom", "cylinder", "top", "supply")


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


@pytest.fixture(scope="module")
def network(description: Description) -> Network:
    return load_network(description.automata_path, model_constants(description))


class Process:
    """All who look at the frames of one process; ``judge`` None: each has its own."""

    def __init__(self, description: Description, network: Network, judge: FrameJudge | None) -> None:
        self.predicates = Predicates(description, codec_of(description), judge)
        self.controller = Controller(description, network, judge=judge)
        self.at, self.number = 1_000_000, 0
        self.seen: list[dict[str, bool] | Status] = []
        self.controller.start({}, self.at)

    def frame(self, after_us: int = PERIOD, **values: Value) -> None:
        self.at, self.number = self.at + after_us, self.number + 1
        noise, shown = self.number % 4, QUIET | values
        shown |= {name: value + noise for name in PRESSURES if (value := shown[name]) is not None}
        frame = Frame(self.at, self.number, self.number * 20, shown)
        self.seen.append(self.predicates.frame(frame))
        self.seen += self.controller.frame(frame)

    def frames(self, count: int, **values: Value) -> None:
        for _ in range(count):
            self.frame(**values)


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The time of each frame, once for each time that it was judged."""
    times: list[int] = []
    judge = LinkRules.judge

    def counted(rules: LinkRules, frame: Frame) -> Judged:
        times.append(frame.at)
        return judge(rules, frame)

    monkeypatch.setattr(LinkRules, "judge", counted)
    return times


def test_a_frame_is_judged_once_in_a_process(
    description: Description, network: Network, judged: list[int]
) -> None:
    process = Process(description, network, FrameJudge())
    process.frame()  # from here on all are in the same state
    judged.clear()
    process.frames(100)
    assert len(judged) == 100
    answer, _ = process.controller.command("grip", process.at)
    assert answer.accepted
    judged.clear()
    process.frames(20, bottom=-40_000)
    process.frames(20, bottom=-80_000)
    assert len(judged) == len(set(judged)) == 40


def test_each_for_itself_judges_every_frame(
    description: Description, network: Network, judged: list[int]
) -> None:
    Process(description, network, None).frames(10)
    assert len(judged) == 20


def test_who_has_looked_at_another_time_joins_the_others_with_the_next_frame(
    description: Description, network: Network, judged: list[int]
) -> None:
    process = Process(description, network, FrameJudge())
    process.frames(60)
    controller, others = process.controller, process.predicates._senses
    controller.command("grip", process.at)
    process.frames(249, bottom=-20_000)  # up to the time-out of the first attempt
    controller.advance(process.at + PERIOD)
    own = controller._senses.now
    assert own is not others.now
    judged.clear()
    process.frame(bottom=-20_000)
    assert len(judged) <= 2
    assert controller._senses.now is others.now is not own
    process.frames(10, bottom=-20_000)
    assert len(judged) <= 12


@pytest.mark.parametrize("seed", range(4))
def test_shared_or_not_all_is_decided_the_same(description: Description, network: Network, seed: int) -> None:
    """With silences, reboots, invalid values and time-outs of the controller between the frames."""

    def run(judge: FrameJudge | None) -> list[dict[str, bool] | Status]:
        random, process = Random(seed), Process(description, network, judge)
        process.frames(60)
        for _ in range(150):
            match random.randrange(12):
                case 0:
                    word = random.choice(("grip", "drop", "cancel"))
                    process.seen += process.controller.command(word, process.at)[1]
                case 1:
                    process.seen += process.controller.advance(process.at + random.randrange(PERIOD))
                case 2:
                    process.frame(random.choice((PERIOD, 149_000, 150_000, 151_000, 2_000_000)))
                case 3:
                    process.number = random.randrange(3)
                    process.frame(**{random.choice(list(QUIET)): None})
                case _:
                    for _ in range(random.randrange(8)):
                        process.frame(bottom=random.choice((0, -40_000, -80_000)), supply=600_000)
        return process.seen

    assert run(FrameJudge()) == run(None)


def test_a_clone_goes_its_own_way(description: Description) -> None:
    state = SensorState(description, codec_of(description))
    memory, other = memory_of(state), clone(state)
    assert same_memory(state, other)
    (after,) = other.after(Frame(1_000, 1, 20, QUIET))
    assert memory_of(state) == memory_of(other) == memory
    assert not same_memory(after, other)
    (again,) = state.after(Frame(1_000, 1, 20, QUIET))
    assert again is not after
    assert same_memory(again, after)


def test_after_a_silence_all_still_share_what_they_judge(
    description: Description, network: Network, judged: list[int]
) -> None:
    process = Process(description, network, FrameJudge())
    process.frames(60)
    process.frame(2_000_000)
    judged.clear()
    process.frames(50)
    assert len(judged) == 50
    assert process.controller._senses.now is process.predicates._senses.now


def test_after_a_silence_nothing_is_proven_by_what_was_so_before_it(
    description: Description, network: Network
) -> None:
    process = Process(description, network, FrameJudge())
    process.frames(60)
    assert process.predicates.holding["nothing_gripped"]
    assert process.predicates.holding["locked"]
    process.frame(2_000_000)
    assert not process.predicates.holding["nothing_gripped"]  # not vented for 0.5 s yet
    assert not process.predicates.holding["locked"]
    process.frames(30)
    assert process.predicates.holding["nothing_gripped"]
    assert process.predicates.holding["locked"]
