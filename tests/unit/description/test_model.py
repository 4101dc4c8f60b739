"""What a loaded description answers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import ValidationError

from end_effector_hal.description import (
    SHIPPED_AUTOMATA,
    Description,
    _paths,
    camel_case,
    content_hash,
    examine_text,
    load,
    profile_path,
    run_directory,
    socket_path,
)
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds.cylinder import CylinderActuator
from end_effector_hal.kinds.vacuum import VacuumActuator
from tests.support.parts import with_parts


@pytest.fixture
def loaded(tmp_path: Path, changed: Callable[..., str]) -> Callable[..., Description]:
    def load_changed(**lines: str) -> Description:
        path = tmp_path / "tool.yaml"
        path.write_text(changed(**lines))
        return load(path)

    return load_changed


def test_the_shipped_description_is_the_paper_s_tool() -> None:
    tool = load(profile_path())
    assert tool.name == "verdin_gripper"
    wires = [(name, actuator.kind, actuator.line, actuator.pin) for name, actuator in tool.ordered]
    assert wires == [
        ("bottom_vacuum", "vacuum", "SODIMM_208", "X20 pin 28"),
        ("cylinder", "cylinder", "SODIMM_210", "X20 pin 29"),
        ("top_vacuum", "vacuum", "SODIMM_212", "X20 pin 30"),
    ]
    assert (tool.tool_changer.line, tool.tool_changer.pin) == ("SODIMM_206", "X20 pin 27")
    assert (tool.link.port, tool.link.codec, tool.link.baudrate) == (
        "/dev/verdin-uart1",
        "ees1-ascii",
        115200,
    )
    services = [tool.service_of(name) for name in tool.sequence]
    topics = [tool.topic_of(name) for name in tool.sequence]
    assert services == ["SetBottomVacuum", "SetCylinder", "SetTopVacuum"]
    assert topics == ["PressureVacuumBottom", "PressureCylinder", "PressureVacuumTop"]
    times = {(each.timeout_s, each.reset_s, each.attempts, each.release_s) for _, each in tool.ordered}
    assert times == {(5.0, 1.0, 3, 2.0)}


def test_the_defaults_are_those_of_the_contract() -> None:
    cup = VacuumActuator(kind="vacuum", line="A", channel="bottom")
    assert (cup.confirmed_kpa, cup.confirmed_samples, cup.gone_kpa) == (55, 3, 10)
    assert (cup.lost_kpa, cup.lost_samples, cup.lost_at_once_kpa) == (50, 2, 20)
    assert (cup.secure_kpa, cup.secure_hysteresis_kpa) == (75, 15)
    rod = CylinderActuator(kind="cylinder", line="B", channel="cylinder")
    assert (rod.extended_fraction, rod.extended_s, rod.retracted_kpa, rod.retracted_s) == (0.85, 0.1, 50, 0.2)


def test_names_of_ros_are_made_of_the_actuator_s(loaded: Callable[..., Description]) -> None:
    tool = loaded(L9="    channel: bottom\n    topic: a/Pressure")
    assert (tool.service_of("cup"), tool.topic_of("cup")) == ("SetCup", "a/Pressure")
    assert (tool.service_of("rod"), tool.topic_of("rod")) == ("SetRod", "PressureRod")
    assert camel_case("left_cup_2") == "LeftCup2"
    with pytest.raises(KeyError):
        tool.service_of("magnet")


def test_release_is_the_sequence_reversed_unless_declared(loaded: Callable[..., Description]) -> None:
    assert loaded().releasing == ("rod", "cup")
    assert loaded(L4="sequence: [cup, rod]\nrelease_order: [cup, rod]").releasing == ("cup", "rod")


def test_the_order_of_the_sequence_is_not_that_of_the_stanzas(loaded: Callable[..., Description]) -> None:
    assert [name for name, _ in loaded(L4="sequence: [rod, cup]").ordered] == ["rod", "cup"]


def test_nothing_of_it_can_be_changed(loaded: Callable[..., Description]) -> None:
    tool = loaded()
    with pytest.raises(ValidationError):
        tool.name = "other"  # type: ignore[misc]
    with pytest.raises(ValidationError):
        tool.actuators["cup"].timeout_s = 1.0  # type: ignore[misc]
    assert isinstance(tool.sequence, tuple)
    assert isinstance(tool.automata.interface, tuple)


def test_where_names_the_place_of_a_value_or_of_what_is_around_it(
    loaded: Callable[..., Description], tmp_path: Path
) -> None:
    tool, file = loaded(), tmp_path / "tool.yaml"
    assert tool.source == file
    assert tool.where("actuators", "rod", "line") == f"{file}:12:11"
    assert tool.where("sequence", 1) == f"{file}:4:17"
    assert tool.where("actuators", "rod", "timeout_s") == f"{file}:10:3"
    assert tool.where("bounds", "grip_s") == f"{file}:1:1"
    assert tool.where() == f"{file}:1:1"
    assert tool.place("actuators", "rod", "line").text == "B"


def test_a_description_made_in_code_has_no_file() -> None:
    made = Description.model_validate(
        {
            "name": "tool",
            "link": {"port": "x"},
            "sequence": ["cup"],
            "actuators": {"cup": {"kind": "vacuum", "line": "A", "channel": "bottom"}},
        }
    )
    assert made.source == Path("<description>")
    assert made.where("name") == "<description>:1:1"


def test_automata_beside_the_description_else_the_shipped(
    loaded: Callable[..., Description], tmp_path: Path
) -> None:
    shipped = SHIPPED_AUTOMATA
    assert loaded().automata_path == shipped
    assert load(profile_path()).automata_path == shipped
    beside = tmp_path / "end_effector.xml"
    beside.touch()
    assert loaded().automata_path == beside
    (tmp_path / "own.xml").touch()
    named = loaded(L1="name: tool\nautomata: {file: own.xml}")
    assert named.automata_path == tmp_path / "own.xml"
    assert named.automata_path.is_absolute()
    # what is named and goes away later is missed, not replaced
    (tmp_path / "own.xml").unlink()
    assert named.automata_path == tmp_path / "own.xml"


def test_virtual_lines_and_another_port_are_the_same_tool(loaded: Callable[..., Description]) -> None:
    tool = loaded()
    virtual = tool.with_virtual(Path("/x/chip"), "/x/pty", Path("/x/arbiter.sock"))
    assert (virtual.lines.backend, virtual.lines.path) == ("virtual", "/x/chip")
    assert (virtual.link.port, socket_path(virtual)) == ("/x/pty", Path("/x/arbiter.sock"))
    assert (virtual.actuators, virtual.sequence) == (tool.actuators, tool.sequence)
    assert (virtual.source, virtual.where("name")) == (tool.source, tool.where("name"))
    assert (tool.lines.backend, tool.link.port) == ("gpiod", "/dev/ttyS0")
    assert tool.with_virtual(lines_path="/x/chip", port="/x/pty").lines.socket is None


def test_another_default_part_is_another_content(verdin: Description) -> None:
    tool = with_parts(verdin)
    turned = tool.model_copy(update={"parts": dict(reversed(tool.parts.items()))})
    assert turned.part_names == ("lid", "panel")
    for content in (Description.fingerprint, content_hash):
        assert len({content(verdin), content(tool), content(turned)}) == 3


def test_the_fingerprint_is_of_the_content(changed: Callable[..., str]) -> None:
    def fingerprint(text: str) -> str:
        description = examine_text(text, "tool.yaml").description
        return description.fingerprint()

    plain = fingerprint(changed())
    assert len(plain) == 12
    assert int(plain, 16) >= 0
    assert plain == fingerprint("# a remark\n" + changed(L1="", L15="  line: C\nname: tool"))
    assert plain == fingerprint(changed(L9="    channel: bottom\n    timeout_s: 5"))
    assert plain == fingerprint(changed(L9="    channel: bottom\n    timeout_s: 5.00"))
    lines = changed().splitlines()
    turned = [*lines[:5], *lines[9:13], *lines[5:9], *lines[13:]]
    assert plain == fingerprint("\n".join(turned))
    others = [
        changed(L1="name: tool2"),
        changed(L4="sequence: [rod, cup]"),
        changed(L9="    channel: bottom\n    timeout_s: 5.001"),
        changed(L15="  line: C\ninterlocks: {IL-05: false}"),
        changed(L14="", L15=""),
    ]
    assert len({plain, *map(fingerprint, others)}) == 1 + len(others)


def test_profiles_by_name() -> None:
    assert profile_path() == profile_path("verdin_gripper")
    assert profile_path().is_file()
    for name in ("nothing", "..", "verdin_gripper/."):
        with pytest.raises(UsageError, match=r"no profile is named .* Shipped: verdin_gripper\."):
            profile_path(name)


def test_the_run_directory(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    tool = load(profile_path())
    monkeypatch.setenv("EEHAL_RUN_DIR", str(tmp_path))
    assert run_directory() == tmp_path
    assert socket_path(tool) == tmp_path / "verdin_gripper.sock"
    monkeypatch.delenv("EEHAL_RUN_DIR")
    monkeypatch.setattr("os.access", lambda *_: True)
    assert run_directory() == Path("/run/eehal")
    monkeypatch.setattr("os.access", lambda *_: False)
    monkeypatch.setattr("os.getuid", lambda: 1234)
    monkeypatch.setenv("XDG_RUNTIME_DIR", "/run/user/1234")
    assert run_directory() == Path("/run/user/1234/eehal")
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    monkeypatch.setattr(_paths, "SHARED", tmp_path)
    assert run_directory() == tmp_path / "eehal-1234"
