"""The largest tool passes the check, and its messages pass the line arbiter; a larger one fails the check."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.arbiter import HAL, OUTPUTS, LineArbiter, arbiter_policy, client_lines
from end_effector_hal.arbiter.protocol import SENSORS, make_token, read_message, read_request, write_message
from end_effector_hal.cli import _check
from end_effector_hal.cli._main import eehal
from end_effector_hal.codecs import load_tool
from end_effector_hal.vocabulary import LONGEST_MESSAGE, LastWillStep
from end_effector_hal.wires.lines import VirtualChip, VirtualLines

WIDE = "\N{SMOKING SYMBOL}\N{PENGUIN}"
HEAD = "schema: 2\nname: large\nlines: {backend: virtual, path: chip}\nsupply: {channel: none}\n"


def long_name(number: int, what: str = "c") -> str:
    return f"{what}{number:02d}.{30 * WIDE}"


def through_the_protocol(message: dict[str, object]) -> object:
    line = write_message(message)
    assert len(line) <= LONGEST_MESSAGE
    return read_request(read_message(line))


def greeted(path: Path) -> None:
    """The arbiter of a tool takes the hello of each client, a set of all its lines and its last will."""
    tool = load_tool(path)
    policy = arbiter_policy(tool)
    chip = path.parent / "chip"
    VirtualChip.create(chip, policy.lines)
    arbiter = LineArbiter(VirtualLines(chip), policy, 0)
    for client in (HAL, OUTPUTS):
        if lines := client_lines(tool, client):
            will = [LastWillStep(line).as_json() for line in lines]
            hello = {"op": "hello", "client": client, "token": make_token(), "lines": lines, "will": will}
            through_the_protocol({"id": 1, "op": "set", "levels": dict.fromkeys(lines, False), "will": will})
            request = through_the_protocol(hello)
            arbiter.hello(client, request.token, request.lines, request.will, 0)
    needed = {need.predicate: False for needs in policy.needs.values() for need in needs}
    if needed:
        through_the_protocol({"op": "tell", "predicates": needed, "at_us": 10**17})
        through_the_protocol({"op": "hello", "role": SENSORS, "client": "x" * 64, "token": make_token()})


@pytest.mark.thinned
@pytest.mark.parametrize("link", ["modbus", "text", "binary", "none"])
def test_64_grippers_of_three_switches_each_and_a_tool_changer(
    link: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    actuators = ",".join(f"g{n}:gripper" for n in range(64))
    options = ["--actuators", actuators, "--link", link, "--tool-changer", "--virtual"]
    made = CliRunner().invoke(eehal, ["init", "large", *options], catch_exceptions=False)
    assert made.exit_code == 0, made.output
    path = tmp_path / "large/end_effector.yaml"
    assert _check.check(path).faults == ()
    greeted(path)


@pytest.mark.thinned  # long
def test_64_vacuums_that_blow_off_with_64_outputs_and_names_of_the_longest_kind(tmp_path: Path) -> None:
    path = tmp_path / "end_effector.yaml"
    cups = "".join(
        f"  c{n}: {{kind: vacuum, channel: c{n}, line: {long_name(n)}, "
        f"blow_off: {{line: {long_name(n, 'b')}, duration_s: 0.2}}}}\n"
        for n in range(64)
    )
    pressures = "".join(f"  c{n}: {{text: {{field: {n + 1}}}, unit: kPa}}\n" for n in range(64))
    alarms = "".join(
        f"  {f'a{n}_':x<40}: {{text: {{field: {n + 65}}}, alarm: "
        "[{code: 1, text: hot, latches: true}, {code: 2, text: cold, latches: false}]}\n"
        for n in range(198)
    )
    lamps = "".join(f"  l{n}: {{line: {long_name(n, 'l')}}}\n" for n in range(64))
    path.write_text(
        f"{HEAD}link: {{port: uart, baudrate: 921600, period_ms: 50, frame: {{text: {{}}}}}}\n"
        f"channels:\n{pressures}{alarms}"
        f"sequence: [{', '.join(f'c{n}' for n in range(64))}]\nactuators:\n{cups}outputs:\n{lamps}"
    )
    assert _check.check(path).faults == ()
    greeted(path)


@pytest.mark.parametrize("stanza", ["actuators", "outputs", "channels"])
def test_one_more_of_anything_is_refused_by_the_check(stanza: str, tmp_path: Path) -> None:
    number = {"actuators": 65, "outputs": 1, "channels": 65} | (
        {} if stanza == "actuators" else {"actuators": 2}
    )
    number |= {"outputs": 65} if stanza == "outputs" else {"channels": 263} if stanza == "channels" else {}
    path = tmp_path / "end_effector.yaml"
    cups = range(number["actuators"])
    path.write_text(
        f"{HEAD}channels:\n"
        + "".join(f"  p{n}: {{digital: {{line: I{n}}}}}\n" for n in range(number["channels"]))
        + f"sequence: [{', '.join(f'c{n}' for n in cups)}]\nactuators:\n"
        + "".join(f"  c{n}: {{kind: magnet, line: A{n}, part_bit: p{n}}}\n" for n in cups)
        + "outputs:\n"
        + "".join(f"  l{n}: {{line: L{n}}}\n" for n in range(number["outputs"]))
    )
    most = {"actuators": 64, "outputs": 64, "channels": 262}[stanza]
    assert [each.message for each in _check.check(path).faults] == [
        f"too many {stanza} ({most + 1}), expected at most {most}"
    ]
