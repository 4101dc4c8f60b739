"""Devices of the library: what `device: NAME` expands to, what precedes what, and which file a fault names."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from end_effector_hal.codecs import match_codec
from end_effector_hal.description import (
    Description,
    DeviceLibrary,
    LibraryDevice,
    examine,
    examine_text,
    load,
)
from tests.support.places import DOCS, ROOT, WRITTEN_OUT

SHORT = """\
name: tool
link: {port: /dev/ttyUSB0}
sequence: [fingers]
actuators:
  fingers: {device: robotiq-2f85}
supply: {channel: none}
"""
OWN = """\
title: My jaw
maker: me
confirmed: maker
documents: [{title: my notes}]
registers: [{address: 1, what: all of it}]
unit: 7
link: {baudrate: 19200, period_ms: 50, frame: {modbus: {timeout_ms: 40}}}
channels:
  part: {modbus: {address: 2}, on: [1]}
  opened: {modbus: {address: 3}, on: [1]}
  hot: {modbus: {address: 4}, alarm: [{code: 1, unproven: [self], text: it is hot}]}
actuator:
  kind: gripper
  modbus: {address: 1, command_on: [1], command_off: [0], on_link_loss: hold}
  part_bit: part
  open_bit: opened
  timeout_s: 3
"""


BOARD = """\
title: My board
maker: me
confirmed: maker
documents: [{title: my notes}]
registers: [{address: 1, count: 40, what: all of it, page: "1"}]
unit: 1
link: {baudrate: 19200, period_ms: 30, frame: {modbus: {timeout_ms: 40}}}
actuator: {modbus: {register_type: coil, command_on: [1], command_off: [0], verify: switched}}
outputs:
  do1: {channels: {switched: {modbus: {address: 10, register_type: coil}}}, actuator: {modbus: {address: 10}}}
  do2: {channels: {switched: {modbus: {address: 11, register_type: coil}}}, actuator: {modbus: {address: 11}}}
inputs:
  di1: {modbus: {address: 20, register_type: discrete_input}}
  di2: {modbus: {address: 21, register_type: discrete_input}}
"""


GAUGE = """\
title: My gauge
maker: me
confirmed: maker
documents: [{title: my notes}]
registers: []
link: {baudrate: 19200, period_ms: 50, frame: {text: {start: "$"}}}
channels:
  vacuum: {text: {key: P}, unit: kPa}
  ok: {text: {key: S}, on: [1]}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Is the working directory, and has `jaw.yaml`, `board.yaml` and `gauge.yaml` in `mine`."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    for name, text in (("jaw", OWN), ("board", BOARD), ("gauge", GAUGE)):
        (tmp_path / "mine" / f"{name}.yaml").write_text(text)
    return tmp_path


def lines_of(text: str) -> list[str]:
    Path("tool.yaml").write_text(text)
    return examine("tool.yaml").lines()


def lines_of_text(text: str) -> list[str]:
    return examine_text(text, "tool.yaml").lines()


def tool(text: str) -> Description:
    Path("tool.yaml").write_text(text)
    found = load("tool.yaml")
    assert match_codec(found).faults == ()
    return found


def mine(actuators: str, more: str = "", link: str = "link: {port: /dev/a}") -> str:
    names = [each.split(":")[0] for each in actuators.splitlines()]
    inside = "".join(f"  {each}\n" for each in actuators.splitlines())
    head = f"name: tool\ndevices: mine\n{link}\nsequence: [{', '.join(names)}]\nactuators:\n{inside}"
    return f"{head}supply: {{channel: none}}\n{more}"


@pytest.mark.parametrize("name", ["gripper_2f85", "epick_commanded"])
def test_an_example_is_what_it_was_when_its_registers_were_written_out(name: str) -> None:
    short = load(ROOT / "examples" / "tools" / name / "end_effector.yaml")
    long = load(WRITTEN_OUT / f"{name}.yaml")
    assert short.model_dump(mode="json", by_alias=True) == long.model_dump(mode="json", by_alias=True)
    assert short.fingerprint() == long.fingerprint()


def test_what_is_recorded_of_it_needs_no_library(folder: Path) -> None:
    found = tool(mine("jaw: {device: jaw}"))
    content = found.model_dump(mode="json", by_alias=True)
    assert "device" not in content["actuators"]["jaw"]
    assert "devices" not in content
    content["automata"].pop("file")  # beside the recording, which has it
    (folder / "kept.json").write_text(json.dumps(content))
    (folder / "mine" / "jaw.yaml").unlink()
    assert load("kept.json").fingerprint() == found.fingerprint()


def test_a_changed_device_changes_the_description(folder: Path) -> None:
    before = tool(mine("jaw: {device: jaw}")).fingerprint()
    (folder / "mine" / "jaw.yaml").write_text(OWN.replace("timeout_s: 3", "timeout_s: 4"))
    assert tool(mine("jaw: {device: jaw}")).fingerprint() != before


def test_its_channels_have_the_name_of_the_actuator_in_front(folder: Path) -> None:
    found = tool(mine("left: {device: jaw}\nright: {device: jaw, unit: 8}"))
    assert {*found.channels} == {
        f"{jaw}_{each}" for jaw in ("left", "right") for each in ("part", "opened", "hot")
    }
    assert [found.channels[each].modbus.unit for each in ("left_part", "right_part")] == [7, 8]  # type: ignore[union-attr]
    assert [each.unit for each in found.register_outputs.values()] == [7, 8]
    assert getattr(found.actuators["right"], "part_bit") == "right_part"  # noqa: B009 it is the kind's own key
    assert found.channels["right_hot"].alarm[0].unproven == ("right",)
    assert (found.link.baudrate, found.link.period_ms) == (19_200, 100), "their periods add up"


def test_a_word_that_is_a_choice_is_not_the_name_of_a_channel(folder: Path) -> None:
    own = OWN.replace("opened", "hold").replace("kind: gripper", "kind: gripper\n  on_power_loss: hold")
    (folder / "mine" / "jaw.yaml").write_text(own)
    found = tool(mine("jaw: {device: jaw}")).actuators["jaw"]
    assert found.on_power_loss == "hold"
    assert getattr(found, "open_bit") == "jaw_hold"  # noqa: B009 it is the kind's own key


def test_what_the_description_writes_precedes(folder: Path) -> None:
    more = "channels:\n  jaw_part: {on: [2, 3]}\n"
    found = tool(mine("jaw: {device: jaw, timeout_s: 9, modbus: {command_on: [5]}}", more))
    output = found.actuators["jaw"].modbus
    assert (output.command_on, output.command_off, output.on_link_loss) == ((5,), (0,), "hold")
    assert found.actuators["jaw"].timeout_s == 9
    assert found.channels["jaw_part"].on == (2, 3)
    assert found.channels["jaw_part"].modbus is not None
    assert {*found.used_devices["jaw"].overridden} == {
        "actuators.jaw.timeout_s", "actuators.jaw.modbus.command_on", "channels.jaw_part.on"
    }  # fmt: skip


def test_one_output_of_several_is_named_and_each_input_is_a_channel(folder: Path) -> None:
    inputs = "channels:\n  seen: {device: board, input: di2, invert: true, modbus: {unit: 4}}\n"
    found = tool(mine("cup: {device: board, output: do2, unit: 4, kind: vacuum, channel: seen}", inputs))
    output = found.actuators["cup"].modbus
    assert (output.unit, output.address, output.register_type, output.verify) == (
        4, 11, "coil", "cup_switched",
    )  # fmt: skip
    assert {*found.channels} == {"seen", "cup_switched"}
    register = found.channels["seen"].modbus
    assert (register.unit, register.address, found.channels["seen"].invert) == (4, 21, True)
    assert found.link.period_ms == 30, "one board is read once"
    assert {*found.used_devices} == {"cup", "channel seen"}


@pytest.mark.parametrize(
    ("use", "said"),
    [
        (
            "cup: {device: board, kind: vacuum, channel: none}",
            "board has more than one output (board), expected output: do1 or do2",
        ),
        (
            "cup: {device: board, output: x, kind: vacuum, channel: none}",
            "board has no such output (x), expected output: do1 or do2",
        ),
        ("cup: {device: jaw, output: x}", "jaw has no such output (x), expected a device without output"),
    ],
)
def test_an_output_that_is_not_there_is_refused(folder: Path, use: str, said: str) -> None:
    (line,) = lines_of(mine(use))
    assert said in line


def test_an_input_that_is_not_there_is_refused(folder: Path) -> None:
    (line,) = lines_of(mine("jaw: {device: jaw}", "channels:\n  seen: {device: board, input: di3}\n"))
    assert line.startswith("tool.yaml:9:32: board has no such input (di3), expected input: di1 or di2")


def test_the_link_keeps_what_is_written_there(folder: Path) -> None:
    link = "link: {port: /dev/a, baudrate: 9600, frame: {modbus: {timeout_ms: 99}}}"
    found = tool(mine("jaw: {device: jaw}", link=link)).link
    assert (found.baudrate, found.period_ms, found.frame.modbus.timeout_ms) == (9600, 50, 99)


def test_a_network_has_no_baud_rate(folder: Path) -> None:
    Path("tool.yaml").write_text(mine("jaw: {device: jaw}", link="link: {port: 'tcp://10.0.0.2'}"))
    likely = examine("tool.yaml").likely
    assert (likely.link.baudrate, likely.link.period_ms) == (None, 50)


def test_a_device_may_be_on_one_of_several_links(folder: Path) -> None:
    link = "links: {one: {port: /dev/a}, two: {port: /dev/b}}"
    found = tool(mine("left: {device: jaw, link: one}\nright: {device: jaw, link: two}", link=link))
    assert {*found.buses} == {"one", "two"}
    assert {name: each.link for name, each in found.channels.items() if "part" in name} == {
        "left_part": "one", "right_part": "two"
    }  # fmt: skip
    assert [found.links[each].baudrate for each in ("one", "two")] == [19_200, 19_200]


def test_a_sensor_or_a_line_of_ones_own_takes_the_place_of_the_devices(folder: Path) -> None:
    more = "channels:\n  jaw_part: {digital: {line: IN_1}}\n"
    found = tool(mine("jaw: {device: jaw, line: OUT_1}", more))
    assert found.channels["jaw_part"].source == "digital"
    assert (found.actuators["jaw"].line, found.actuators["jaw"].modbus) == ("OUT_1", None)


def test_a_condition_of_an_evidence_is_replaced_as_a_whole(folder: Path) -> None:
    own = OWN.replace(
        "  timeout_s: 3",
        "  evidence: {confirmed: {on: part, for_ms: 50}, gone: {on: opened}, lost: {not: {on: part}}}",
    )
    (folder / "mine" / "jaw.yaml").write_text(own)
    plain = tool(mine("jaw: {device: jaw}")).actuators["jaw"].evidence
    assert plain.confirmed.on == "jaw_part"
    (changed,) = tool(mine("jaw: {device: jaw, evidence: {gone: {not: {on: jaw_part}}}}")).actuators.values()
    assert changed.evidence.gone.on is None


def test_an_unknown_device_is_refused_with_the_nearest_names() -> None:
    (line,) = lines_of_text(SHORT.replace("2f85", "2f58"))
    assert line.startswith(
        "tool.yaml:5:21: there is no such device in the library (robotiq-2f58), expected a name "
    )
    assert line.endswith("; did you mean 'robotiq-2f85' or 'robotiq-2f140' or 'robotiq-epick'? [EE-230]")


def test_a_fault_of_the_device_names_its_file_and_the_place_that_uses_it(folder: Path) -> None:
    (folder / "mine" / "jaw.yaml").write_text(OWN.replace("timeout_s: 3", "timeout_s: 9999"))
    (line,) = lines_of(mine("jaw: {device: jaw}"))
    assert line.startswith("mine/jaw.yaml:17:14: 'timeout_s' is out of range (9999)")
    assert line.endswith("; used at tool.yaml:6:17 [EE-208]")


def test_a_fault_of_what_is_written_instead_names_the_description(folder: Path) -> None:
    (line,) = lines_of(mine("jaw: {device: jaw, timeout_s: 9999, unit: 7}"))
    assert line.startswith("tool.yaml:6:33: 'timeout_s' is out of range (9999)")
    (line,) = lines_of(mine("jaw: {device: jaw, unit: text}"))
    assert line.startswith("tool.yaml:6:28: 'unit' is of the wrong type (text)")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("confirmed: maker", "confirmed: maybe"), "mine/jaw.yaml:3:12: confirmed: input should be"),
        (("maker: me\n", ""), "mine/jaw.yaml:1:1: maker: field required"),
        (("actuator:\n", "actuator: [\n"), "mine/jaw.yaml:12:11: not YAML"),
        (("maker: me", "titel: x\nmaker: me"), "mine/jaw.yaml:2:8: titel: extra inputs are not permitted"),
    ],
)
def test_a_file_that_is_no_device_is_refused(folder: Path, change: tuple[str, str], said: str) -> None:
    (folder / "mine" / "jaw.yaml").write_text(OWN.replace(*change))
    lines = lines_of(mine("jaw: {device: jaw}"))
    assert lines[0].startswith(said), lines
    assert len(lines) == 1


ONE, TWO = "link: {port: /dev/a}", "links: {one: {port: /dev/a}, two: {port: /dev/b}}"


@pytest.mark.parametrize(
    ("actuators", "link", "said"),
    [
        ("jaw: {device: jaw}", "schema: 2", "tool.yaml:1:1: key 'link' is missing"),
        ("jaw: {device: jaw}", TWO, "tool.yaml:6:17: jaw needs the name of a link (jaw), expected link: one or two"),
        ("jaw: {device: jaw, link: x}", TWO, "tool.yaml:6:28: there is no such link (x), expected link: one or two"),
        ("jaw: {device: jaw, link: x}", ONE, "tool.yaml:6:28: there is no such link (x), expected no name"),
        ("a: {device: jaw}\nb: {device: jaw}", ONE, "tool.yaml:7:15: this unit of the link has jaw already (jaw)"),
        ("a: {device: jaw}\nb: {device: jaw, unit: 7}", ONE, "tool.yaml:7:26: this unit of the link has jaw already"),
        ("a: {device: jaw}\nb: {device: robotiq-2f85, unit: 7}", ONE, "tool.yaml:7:35: this unit of the link has jaw"),
    ],
)  # fmt: skip
def test_a_device_without_a_place_on_a_link_is_one_fault(
    folder: Path, actuators: str, link: str, said: str
) -> None:
    (line,) = lines_of(mine(actuators, link=link))
    assert line.startswith(said)


def test_two_devices_that_cannot_share_a_link_are_refused_unless_the_link_says_it(folder: Path) -> None:
    (folder / "mine" / "other.yaml").write_text(OWN.replace("19200", "9600"))
    both = "left: {device: jaw}\nright: {device: other, unit: 8}"
    (line,) = lines_of(mine(both))
    assert line.startswith("tool.yaml:7:19: jaw needs baudrate: 19200, and other on the same link 9600")
    assert tool(mine(both, link="link: {port: /dev/a, baudrate: 9600}")).register_outputs


def test_a_folder_that_is_not_there_is_refused() -> None:
    lines = lines_of_text("devices: nowhere\n" + SHORT)
    assert [each for each in lines if "there is no such folder of devices (nowhere)" in each]
    lines = lines_of_text(f"devices: {'a' * 300}\n{SHORT}")
    assert [each for each in lines if "there is no such folder of devices" in each]


def test_a_device_on_a_link_with_another_format_is_refused(folder: Path) -> None:
    lines = lines_of(mine("jaw: {device: jaw}", link="link: {port: /dev/a, frame: {text: {}}}"))
    assert lines
    assert all("EE-22" in each for each in lines)


def test_ones_own_device_precedes_a_shipped_one_of_its_name(folder: Path) -> None:
    (folder / "mine" / "robotiq-2f85.yaml").write_text(OWN)
    found = tool(mine("jaw: {device: robotiq-2f85}"))
    assert found.used_devices["jaw"].title == "My jaw"
    assert found.files[2:] == (folder / "mine" / "robotiq-2f85.yaml",)


def test_another_distribution_adds_devices_and_its_package_is_not_imported(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package, info = folder / "acme_devices", folder / "acme-1.0.dist-info"
    for each in (package, info):
        each.mkdir()
    (package / "__init__.py").write_text("raise SystemExit('it was imported')\n")
    (package / "acme-jaw.yaml").write_text(OWN)
    (package / "robotiq-2f85.yaml").write_text(OWN)
    (info / "METADATA").write_text("Name: acme\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[end_effector_hal.devices]\nacme = acme_devices\n")
    monkeypatch.syspath_prepend(str(folder))
    device = DeviceLibrary().get("acme-jaw")
    assert isinstance(device, LibraryDevice)
    assert device.origin == "package acme_devices"
    shipped = DeviceLibrary().get("robotiq-2f85")
    assert isinstance(shipped, LibraryDevice)
    assert shipped.origin == "shipped", "a name of this product is not replaced"


WRONG = ["5", "true", "null", "[]", "[a]", "{}", "{a: 1}", '""']


@pytest.mark.parametrize("value", WRONG)
@pytest.mark.parametrize("key", ["device", "unit", "link", "output", "modbus", "kind", "evidence", "line"])
def test_no_value_beside_a_device_makes_it_raise(folder: Path, key: str, value: str) -> None:
    for name in ("jaw", "board"):
        keys = {"device": name, "output": "do1", key: value}
        lines_of(mine(f"a: {{{', '.join(f'{each}: {said}' for each, said in keys.items())}}}"))


@pytest.mark.parametrize("value", WRONG)
@pytest.mark.parametrize(
    "text",
    [
        "name: tool\ndevices: {}\nactuators: {{a: {{device: jaw}}}}\n",
        "name: tool\ndevices: mine\nlink: {}\nactuators: {{a: {{device: jaw}}}}\n",
        "name: tool\ndevices: mine\nlinks: {}\nactuators: {{a: {{device: jaw}}}}\n",
        "name: tool\ndevices: mine\nlink: {{frame: {}}}\nactuators: {{a: {{device: jaw}}}}\n",
        "name: tool\ndevices: mine\nlink: {{port: x}}\nchannels: {}\nactuators: {{a: {{device: jaw}}}}\n",
        "name: tool\ndevices: mine\nlink: {{port: x}}\nchannels: {{a_part: {}}}\nactuators: {{a: {{device: jaw}}}}\n",
        "name: tool\ndevices: mine\nlink: {{port: x}}\nchannels: {{b: {{device: jaw, input: {}}}}}\nactuators: {{}}\n",
        "name: tool\ndevices: mine\nlink: {{port: x}}\nactuators: {}\n",
    ],
)
def test_no_value_around_a_device_makes_it_raise(folder: Path, text: str, value: str) -> None:
    assert lines_of(text.format(value))


@pytest.mark.parametrize("value", WRONG)
@pytest.mark.parametrize("key", ["unit", "link", "channels", "actuator", "outputs", "inputs", "registers"])
def test_no_value_in_the_file_of_a_device_makes_it_raise(folder: Path, key: str, value: str) -> None:
    lines = [each for each in OWN.split("channels:")[0].splitlines() if not each.startswith(f"{key}:")]
    (folder / "mine" / "jaw.yaml").write_text("\n".join([*lines, f"{key}: {value}", ""]))
    lines_of(mine("jaw: {device: jaw}"))


def test_the_examples_of_the_page_are_valid(folder: Path) -> None:
    page = (DOCS / "how-to" / "device.md").read_text(encoding="utf-8")
    (folder / "my_devices").mkdir()
    for name in ("my-jaw", "my-gauge"):
        (own,) = re.findall(rf"```text\n# my_devices/{name}.yaml\n(.*?)```", page, re.DOTALL)
        (folder / "my_devices" / f"{name}.yaml").write_text(own)
    found = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert [lines_of(each) for each in found] == [[]] * 4


SHIPPED = [
    each for each in map(DeviceLibrary().get, DeviceLibrary().names()) if isinstance(each, LibraryDevice)
]


def registers_of(device: LibraryDevice) -> set[int]:
    """The addresses of all registers that a device reads and writes."""
    about, used = device.about, set[int]()
    parts = [
        (about.channels, about.actuator),
        *((each.channels, each.actuator) for each in about.outputs.values()),
    ]
    wide = {"uint32": 2, "int32": 2, "float32": 2}
    for channel in [*(each for channels, _ in parts for each in channels.values()), *about.inputs.values()]:
        register = channel["modbus"]
        used |= {register["address"] + at for at in range(wide.get(register.get("value_type", ""), 1))}
    common = about.actuator.get("modbus", {})
    for _, actuator in parts:
        output = {**common, **actuator.get("modbus", {})}
        if "address" in output:
            used |= {output["address"] + at for at in range(len(output["command_on"]))}
        used |= {
            output[key]["address"] for key in ("activation", "handshake") if "address" in output.get(key, {})
        }
    return used


def tool_with(device: LibraryDevice) -> str:
    """A description of a tool with every output and input of a device; a switch proves what has no kind."""
    about, actuators, channels = device.about, list[str](), list[str]()
    uses = {f"a_{each}": f"device: {device.name}, output: {each}" for each in about.outputs}
    uses = uses or {"a": f"device: {device.name}" if about.actuator else "line: OUT"}
    for name, use in uses.items():
        if "kind" in about.actuator:
            actuators.append(f"  {name}: {{{use}}}\n")
        else:
            actuators.append(f"  {name}: {{{use}, kind: vacuum, channel: {name}_seen}}\n")
            channels.append(f"  {name}_seen: {{digital: {{line: {name.upper()}}}}}\n")
    channels += [f"  in_{each}: {{device: {device.name}, input: {each}}}\n" for each in about.inputs]
    head = f"name: tool\nlink: {{port: /dev/a}}\nsequence: [{', '.join(uses)}]\nsupply: {{channel: none}}\n"
    return f"{head}actuators:\n{''.join(actuators)}" + (f"channels:\n{''.join(channels)}" if channels else "")


@pytest.mark.parametrize("device", SHIPPED, ids=lambda each: each.name)
def test_each_register_that_a_shipped_device_uses_is_documented(device: LibraryDevice) -> None:
    about = device.about
    documented = {each.address + at for each in about.registers for at in range(each.count)}
    assert registers_of(device) <= documented
    for each in about.registers:
        assert each.document <= len(about.documents)
        assert each.page or about.confirmation(each) != "maker", f"0x{each.address:04X} has no page"


def test_nothing_is_shipped_that_cannot_be_read() -> None:
    assert [each.name for each in SHIPPED] == DeviceLibrary().names()


@pytest.mark.parametrize("device", SHIPPED, ids=lambda each: each.name)
def test_each_shipped_device_makes_a_tool(device: LibraryDevice, folder: Path) -> None:
    found = tool(tool_with(device))
    assert {each for used in found.used_devices.values() for each in used.overridden} == set()
    assert len(found.register_outputs) == (len(device.about.outputs) or bool(device.about.actuator))
    assert {f"in_{each}" for each in device.about.inputs} <= found.channels.keys()


CELL = """\
name: cell
devices: mine
link: {port: /dev/a}
channels:
  locked: {device: board, input: di1}
  seal: {device: board, input: di2}
sequence: [cup]
actuators:
  cup:
    {device: board, output: do1, kind: vacuum, channel: seal, blow_off: {device: board, output: do2, duration_s: 0.3}}
tool_changer: {device: board, output: do1, unit: 2, unlocked_bit: none, stand_bit: none, present_bit: none}
outputs:
  lamp: {device: board, output: do2, unit: 2, modbus: {on_link_loss: release}}
supply: {channel: none}
"""


def test_a_tool_changer_a_blow_off_and_a_lamp_use_outputs_of_a_board(folder: Path) -> None:
    (folder / "mine" / "board.yaml").write_text(
        BOARD.replace("actuator: {", "actuator: {on_power_loss: keep, ")
    )
    found = tool(CELL)
    assert found.tool_changer
    assert {
        each.line: (each.modbus.register_type, each.modbus.verify)
        for each in found.every_output.values()
        if each.modbus
    } == {
        "modbus:1/0x000A": ("coil", "cup_switched"),
        "modbus:1/0x000B": ("coil", "cup_blow_off_switched"),
        "modbus:2/0x000A": ("coil", "tool_changer_switched"),
        "modbus:2/0x000B": ("coil", "lamp_switched"),
    }
    assert found.outputs["lamp"].modbus
    assert found.outputs["lamp"].modbus.on_link_loss == "release"
    assert {"cup", "cup_blow_off", "tool_changer", "lamp"} <= found.used_devices.keys()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "tool_changer: {device: board, output: do1",
            "tool_changer: {device: jaw",
            "jaw is no board with outputs that a tool changer, a blow-off or a lamp could use",
        ),
        ("output: do1, unit: 2", "output: do1", "this unit of the link has board already, do1"),
        ("lamp: {device: board", "lamp: {device: bord", "there is no such device in the library"),
        ("output: do2, duration", "output: do9, duration", "board has no such output"),
    ],
)
def test_what_such_an_output_cannot_use_is_one_fault(folder: Path, old: str, new: str, expected: str) -> None:
    assert old in CELL
    (line,) = lines_of(CELL.replace(old, new))
    assert expected in line


GAUGED = """\
name: tool
devices: mine
link: {port: /dev/a, device: gauge, period_ms: 20}
sequence: [cup]
actuators:
  cup: {kind: vacuum, line: GPIO17, channel: vacuum}
supply: {channel: none}
"""


def test_a_link_is_a_sensor_with_all_its_channels(folder: Path) -> None:
    found = tool(GAUGED)
    assert found.link
    assert (found.link.baudrate, found.link.period_ms) == (19200, 20), "what is written here precedes"
    assert set(found.channels) == {"vacuum", "ok"}
    assert found.used_devices["link"].overridden == ("link.period_ms",)
    assert "device" not in found.model_dump(mode="json")["link"]


def test_each_of_several_links_is_a_sensor_of_its_own(folder: Path) -> None:
    links = "links:\n  a: {port: /dev/a, device: gauge}\n  b: {port: /dev/b, device: gauge}\n"
    found = tool(
        GAUGED.replace("link: {port: /dev/a, device: gauge, period_ms: 20}\n", links).replace(
            "channel: vacuum", "channel: b_vacuum"
        )
    )
    assert {name: each.link for name, each in found.channels.items()} == {
        "a_vacuum": "a", "a_ok": "a", "b_vacuum": "b", "b_ok": "b",
    }  # fmt: skip


def test_a_sensor_on_a_bus_has_the_unit_beside_it(folder: Path) -> None:
    text = GAUGE.replace('frame: {text: {start: "$"}}', "frame: {modbus: {}}")
    text = text.replace("text: {key: P}", "modbus: {address: 3}").replace(
        "text: {key: S}", "modbus: {address: 4}"
    )
    (folder / "mine" / "gauge.yaml").write_text(text)
    found = tool(GAUGED.replace("device: gauge", "device: gauge, unit: 7"))
    assert [each.modbus.unit for each in found.channels.values() if each.modbus] == [7, 7]


@pytest.mark.parametrize(
    ("name", "expected"),
    [("jaw", "jaw is no sensor with a link of its own"), ("guage", "there is no such device in the library")],
)
def test_a_link_refuses_what_is_no_sensor(folder: Path, name: str, expected: str) -> None:
    found = [
        each for each in lines_of(GAUGED.replace("device: gauge", f"device: {name}")) if "EE-230" in each
    ]
    assert len(found) == 1
    assert expected in found[0]
