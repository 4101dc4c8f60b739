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
        self.programs = [
            Controller(description, network, name, judge=judge) for name in ("grip", "tool_change")
        ]
        self.at, self.number = 1_000_000, 0
        self.seen: list[dict[str, bool] | Status] = []
        for program in self.programs:
            program.start({}, self.at)

    def frame(self, after_us: int = PERIOD, **values: Value) -> None:
        frame = self.next_frame(after_us, values)
        self.seen.append(self.predicates.frame(frame))
        for program in self.programs:
            self.seen += program.frame(frame)

    def next_frame(self, after_us: int, values: dict[str, Value]) -> Frame:
        self.at, self.number = self.at + after_us, self.number + 1
        noise, shown = self.number % 4, QUIET | values
        shown |= {name: value + noise for name in PRESSURES if (value := shown[name]) is not None}
        return Frame(self.at, self.number, self.number * 20, shown)

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
    answer, _ = process.programs[0].command("grip", process.at)
    assert answer.accepted
    judged.clear()
    process.frames(20, bottom=-40_000)
    process.frames(20, bottom=-80_000)
    assert len(judged) == len(set(judged)) == 40


def test_each_for_itself_judges_every_frame(
    description: Description, network: Network, judged: list[int]
) -> None:
    Process(description, network, None).frames(10)
    assert len(judged) == 30


def test_who_has_looked_at_another_time_joins_the_others_with_the_next_frame(
    description: Description, network: Network, judged: list[int]
) -> None:
    process = Process(description, network, FrameJudge())
    process.frames(60)
    grip, change = process.programs
    grip.command("grip", process.at)
    process.frames(249, bottom=-20_000)  # up to the time-out of the first attempt
    grip.advance(process.at + PERIOD)
    own = grip._senses.now
    assert own is not change._senses.now
    judged.clear()
    process.frame(bottom=-20_000)
    assert len(judged) <= 2
    assert grip._senses.now is change._senses.now is not own
    process.frames(10, bottom=-20_000)
    assert len(judged) <= 12


class PassingProcess(Process):
    """Its programs pass over what changes nothing."""

    def __init__(self, description: Description, network: Network, judge: FrameJudge) -> None:
        super().__init__(description, network, judge)
        self.judge, self.passed = judge, 0

    def frame(self, after_us: int = PERIOD, **values: Value) -> None:
        frame = self.next_frame(after_us, values)
        if self.passes(frame):
            self.passed += 1
            self.seen.append(self.predicates.holding)
            for program in self.programs:
                self.seen += program.pass_over(frame, judged=True)
            return
        self.seen.append(self.predicates.frame(frame))
        for program in self.programs:
            self.seen += program.frame(frame)

    def passes(self, frame: Frame) -> bool:
        dues = [program.deadline for program in self.programs]
        return all(due is None or due >= frame.at for due in dues) and self.judge.changes_nothing(frame)


@pytest.mark.parametrize("seed", range(4))
def test_shared_or_not_all_is_decided_the_same(description: Description, network: Network, seed: int) -> None:
    """With silences, reboots, invalid values and time-outs of one program between the frames."""

    def run(process: Process) -> list[dict[str, bool] | Status]:
        random = Random(seed)
        process.frames(60)
        for _ in range(150):
            grip, change = process.programs
            match random.randrange(12):
                case 0:
                    process.seen += grip.command(random.choice(("grip", "drop", "cancel")), process.at)[1]
                case 1:
                    process.seen += random.choice((grip, change)).advance(
                        process.at + random.randrange(PERIOD)
                    )
                case 2:
                    process.frame(random.choice((PERIOD, 149_000, 150_000, 151_000, 2_000_000)))
                case 3:
                    process.number = random.randrange(3)
                    process.frame(**{random.choice(list(QUIET)): None})
                case _:
                    for _ in range(random.randrange(8)):
                        process.frame(bottom=random.choice((0, -40_000, -80_000)), supply=600_000)
        return process.seen

    alone = run(Process(description, network, None))
    assert run(Process(description, network, FrameJudge())) == alone
    passing = PassingProcess(description, network, FrameJudge())
    assert run(passing) == alone
    assert passing.passed > 100


@pytest.mark.parametrize(
    ("shown", "passes"),
    [({}, True), ({"estop_ok": False}, False), ({"top": None}, False), ({"top": -2_000}, True)],
)
def test_what_is_known_from_one_bit_is_for_everybody(
    description: Description, network: Network, shown: dict[str, Value], passes: bool
) -> None:
    """No detector looks at the emergency stop, and a value that is missing proves nothing yet."""
    process = Process(description, network, judge := FrameJudge())
    process.frames(60)
    state = process.programs[0]._senses.now
    assert judge.changes_nothing(process.next_frame(PERIOD, shown)) is passes
    assert (state.readings.last_frame == process.at) is passes


def test_who_goes_on_alone_is_not_passed_over(description: Description, network: Network) -> None:
    process = Process(description, network, judge := FrameJudge())
    process.frames(60)
    Controller(description, network, "grip", judge=judge).start({}, process.at)  # it knows of no frame yet
    assert not judge.changes_nothing(process.next_frame(PERIOD, {}))
    process.frame()
    assert judge.changes_nothing(process.next_frame(PERIOD, {}))
    process.programs[0].advance(process.at + 5_000_000)
    assert not judge.changes_nothing(process.next_frame(PERIOD, {}))


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


def test_after_a_silence_the_programs_still_share_what_they_judge(
    description: Description, network: Network, judged: list[int]
) -> None:
    process = Process(description, network, FrameJudge())
    process.frames(60)
    process.frame(2_000_000)
    judged.clear()
    process.frames(50)
    assert len(judged) <= 100  # the predicates have counted on, the programs anew
    grip, change = process.programs
    assert grip._senses.now is change._senses.now
