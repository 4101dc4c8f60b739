"""What a Modbus device may do to those who ask it, what is known of a cup then, and what it does in silence."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import PolledDecoder, asks, carrier_of, codec_of, load_tool
from end_effector_hal.codecs.modbus import ModbusMaster, RegisterWrite, write_request
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.sensing import SensorSet
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Evidence
from end_effector_lab.testbench import Bench, CommandedRegisters, SensorBoard, parse_scenario
from tests.support.places import ROOT

S = 1_000_000
WIRE_US = 1_000


@pytest.fixture(scope="module")
def tool() -> Description:
    return load_tool(ROOT / "examples/tools/two_links/end_effector.yaml")


class Bus:
    """The master and the device of a tool, in virtual time; an answer may come after the next request."""

    def __init__(self, tool: Description, scenario: str) -> None:
        self.codec = codec_of(tool, "cups")
        self.bench = Bench(tool, scenario, levels={"GPIO5": True})
        self.board = SensorBoard(tool, self.bench, 0, "cups")
        decoder = self.codec.decoder()
        assert asks(decoder)
        self.decoder: PolledDecoder = decoder
        self.senses = SensorSet(tool, carrier_of(tool))
        self.wire: list[tuple[int, bytes]] = []
        self.seen: list[Frame] = []
        self.at = 0

    def run(self, seconds: float) -> list[Evidence]:
        levels, until = [], self.at + round(seconds * S)
        while self.at < until:
            coming = [at for at, _ in self.wire]
            self.at = max(self.at, min([self.decoder.due, *coming]))
            for at, data in [each for each in self.wire if each[0] <= self.at]:
                self.wire.remove((at, data))
                self.take(self.decoder.feed(data, self.at))
            polled = self.decoder.poll(self.at)
            self.take(list(polled.frames))
            if polled.data and (sent := self.board.answer(polled.data, self.at)) and sent.data:
                self.wire.append((self.at + WIRE_US + sent.late_us, sent.data))
            self.senses.advance(self.at)
            levels.append(self.senses.now.evidence[0])
        return levels

    def take(self, frames: list[Frame]) -> None:
        for frame in frames:
            self.seen.append(frame)
            self.senses.frame(frame)


def test_without_a_fault_the_cup_is_confirmed(tool: Description) -> None:
    bus = Bus(tool, "nominal")
    assert bus.run(1.0)[-1] is Evidence.CONFIRMED
    assert not any(bus.decoder.errors.values())


def test_an_answer_within_its_time_is_as_good(tool: Description) -> None:
    bus = Bus(tool, "late-answers:cups:20")
    assert bus.run(1.0)[-1] is Evidence.CONFIRMED


def test_answers_that_come_too_late_prove_nothing(tool: Description) -> None:
    bus = Bus(tool, "late-answers:33")  # after its time-out, in the silence before the next request
    assert set(bus.run(1.0)) == {Evidence.UNKNOWN}
    assert bus.seen == []
    assert bus.decoder.errors["timeout"] > 10
    assert bus.decoder.errors["noise"] > 0
    bus.bench.choose("nominal", bus.at)
    assert bus.run(1.0)[-1] is Evidence.CONFIRMED


def test_a_device_that_does_not_answer_is_unknown_and_asked_again(tool: Description) -> None:
    bus = Bus(tool, "nominal")
    bus.run(1.0)
    bus.bench.choose("no-answers:1", bus.at)
    assert bus.run(1.0)[-1] is Evidence.UNKNOWN
    assert bus.decoder.errors["timeout"] == bus.decoder.lost == pytest.approx(25, abs=1)
    bus.bench.choose("no-answers:cups:0.3", bus.at)
    assert bus.run(1.0)[-1] is Evidence.CONFIRMED  # one in three is left out: none is stale


def test_an_answer_that_comes_twice_counts_once(tool: Description) -> None:
    bus = Bus(tool, "twice-answers:1")
    assert bus.run(1.0)[-1] is Evidence.CONFIRMED
    assert len(bus.seen) == pytest.approx(25, abs=1)


def test_the_answer_of_another_device_is_none(tool: Description) -> None:
    bus = Bus(tool, "wrong-answers:cups:1")
    assert set(bus.run(1.0)) == {Evidence.UNKNOWN}
    assert bus.seen == []
    assert bus.decoder.errors["timeout"] > 10


@pytest.mark.parametrize(
    ("scenario", "sentence"),
    [
        (
            "late-answers:jaws:20",
            "'late-answers:jaws:20' is a fault of a polled link, and jaws is not polled.",
        ),
        ("noise:cup:0.1", "'noise:cup:0.1': no link is named 'cup'. Did you mean 'cups'?"),
        ("no-answers:cups:2", "'no-answers:cups:2': rate must be a number from 0 to 1."),
        ("leak:cups", "'leak:cups': no actuator is named 'cups'. Did you mean 'cup'?"),
        (
            "noise:cups:0.1,noise:cups:0.2",
            "'noise:cups:0.2' contradicts 'noise:cups:0.1'. Remove one of them.",
        ),
    ],
)
def test_what_no_link_can_have_is_one_sentence(tool: Description, scenario: str, sentence: str) -> None:
    with pytest.raises(UsageError) as refused:
        parse_scenario(scenario, tool)
    assert sentence in str(refused.value)


def test_a_link_has_faults_of_its_own_and_those_of_all(tool: Description) -> None:
    scenario = parse_scenario("silent-after:3,noise:cups:0.5,reboot-after:jaws:1", tool)
    assert [scenario.on_link(name).noise for name in ("cups", "jaws", None)] == [0.5, 0, 0]
    assert {scenario.on_link(name).silent_after_us for name in ("cups", "jaws", None)} == {3 * S}
    bench = Bench(tool, scenario)
    assert (bench.booted(2 * S, "cups"), bench.booted(2 * S, "jaws")) == (0, 1_300_000)


def test_a_tool_whose_link_does_not_ask_refuses_them(verdin: Description) -> None:
    with pytest.raises(UsageError, match=r"is a fault of a polled link, and verdin_gripper is not polled\."):
        parse_scenario("no-answers:0.5", verdin)
    with pytest.raises(UsageError, match="the links of this tool have no names"):
        parse_scenario("noise:left:0.5", verdin)


EPICK = load_tool(ROOT / "examples/tools/epick_commanded/end_effector.yaml")
((NAME, OUTPUT),) = EPICK.register_outputs.items()
MASTER = codec_of(EPICK, "").decoder()
assert isinstance(MASTER, ModbusMaster)
READ = MASTER.poll(0).data


def commanded(**changed: object) -> tuple[CommandedRegisters, list[tuple[str, bool]]]:
    obeyed: list[tuple[str, bool]] = []
    output = OUTPUT.model_copy(update=changed)
    registers = CommandedRegisters({NAME: output}, lambda name, level: obeyed.append((name, level)))
    registers.start({NAME: True}, 0)
    return registers, obeyed


def test_an_activation_with_an_address_of_its_own_is_one() -> None:
    activation = OUTPUT.activation
    assert activation
    activation = activation.model_copy(update={"address": 0x0100})
    registers, obeyed = commanded(activation=activation)
    registers.start({}, 0)
    on = write_request(RegisterWrite(OUTPUT.unit, OUTPUT.address, OUTPUT.command_on))
    registers.answer(on)
    assert obeyed == [], "it is not activated"
    for row in activation.write:
        assert registers.answer(write_request(RegisterWrite(OUTPUT.unit, 0x0100, row)))
    registers.answer(on)
    assert obeyed == [(NAME, False), (NAME, True)], "an activation moves it"


def test_a_release_whose_activation_bit_rises_activates_a_device_that_lost_its_power() -> None:
    registers, obeyed = commanded()
    registers.start({}, 0)
    registers.answer(write_request(RegisterWrite(OUTPUT.unit, OUTPUT.address, OUTPUT.command_off)))
    assert registers.values["cup_activated"] is True
    assert obeyed == [(NAME, False)] * 2


def test_what_is_heard_keeps_it_alive() -> None:
    registers, obeyed = commanded()
    for at in range(0, 5 * S, S // 2):
        registers.hear(READ, at)
        registers.advance(at)
    assert obeyed == []
    assert registers.due == 4 * S + S // 2 + S
    registers.advance(registers.due - 1)
    assert obeyed == []
    registers.advance(registers.due)
    assert obeyed == [(NAME, False)]
    assert registers.due is None
    assert registers.values["cup_told_to_grip"] is False


def test_a_request_to_another_unit_is_not_heard() -> None:
    registers, obeyed = commanded()
    registers.hear(write_request(RegisterWrite(8, OUTPUT.address, OUTPUT.command_on)), S // 2)
    registers.advance(S)
    assert obeyed == [(NAME, False)]


def test_what_holds_without_a_link_or_has_no_time_stays() -> None:
    for changed in ({"on_link_loss": "hold"}, {"on_link_loss": "undefined"}, {"keep_alive_ms": None}):
        registers, obeyed = commanded(**changed)
        assert registers.due is None
        registers.advance(3600 * S)
        assert obeyed == []
