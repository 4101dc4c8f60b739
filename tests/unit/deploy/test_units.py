"""The files of deploy/, held against the tools that read them and against the code that they start."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
from pathlib import Path

import click
import pytest
from ruamel.yaml import YAML

from end_effector_hal.arbiter import arbiter_policy
from end_effector_hal.cli._main import eehal
from end_effector_hal.description import Description, load, profile_path
from tests.support.places import DEPLOY

UNITS = sorted((DEPLOY / "systemd").glob("*.service"))
ARBITER, COMMON = "eehal-arbiter@.service", DEPLOY / "systemd" / "common.conf"
PACKAGE = DEPLOY / "package"
SCRIPTS = [path for path in DEPLOY.rglob("*") if path.is_file() and path.read_bytes().startswith(b"#!")]


def unit(name: str) -> configparser.ConfigParser:
    """A unit, of which keys that stand twice are joined."""
    parser = configparser.ConfigParser(strict=False, interpolation=None)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read([*([] if name == ARBITER else [COMMON]), DEPLOY / "systemd" / name])
    return parser


def seconds(text: str) -> float:
    """Of a time such as ``30s``."""
    match = re.fullmatch(r"(\d+)(ms|s)", text)
    assert match, text
    return int(match[1]) / {"ms": 1000, "s": 1}[match[2]]


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="systemd is not installed")
def test_systemd_reads_the_units_without_a_word(tmp_path: Path) -> None:
    paths = []
    for path in UNITS:
        # the programs are not installed here
        common = "" if path.name == ARBITER else COMMON.read_text()
        text = re.sub(
            r"^(ExecStart|ExecReload)=/opt/eehal/bin/\S+",
            r"\1=/bin/true",
            common + path.read_text(),
            flags=re.MULTILINE,
        )
        instance = tmp_path / path.name.replace("@", "@my_tool")
        instance.write_text(text)
        paths.append(instance)
    result = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", *map(str, paths)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    # of other units on this machine it may say what it likes
    said = [line for line in result.stderr.splitlines() if "eehal" in line]
    assert (result.returncode, said) == (0, [])


@pytest.mark.skipif(not shutil.which("systemd-sysusers"), reason="systemd is not installed")
def test_the_groups_have_the_numbers_of_torizon(tmp_path: Path) -> None:
    (tmp_path / "etc").mkdir()
    result = subprocess.run(
        ["systemd-sysusers", f"--root={tmp_path}", DEPLOY / "systemd" / "eehal.sysusers"],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    groups = {}
    for line in (tmp_path / "etc/group").read_text().splitlines():
        name, _, number, members = line.split(":")
        groups[name] = (number, set(members.split(",")) - {""})
    assert groups["gpio"] == ("49", {"eehal", "eehal-arbiter"})
    assert groups["dialout"] == ("20", {"eehal", "eehal-arbiter"})


def longest_will_s(description: Description) -> float:
    """Every actuator in turn, each until its feedback must be gone; and the lease of a client that died silently."""
    return sum(each.release_s for _, each in description.ordered) + arbiter_policy(description).lease_us / 1e6


def test_a_stop_leaves_the_time_that_a_will_takes() -> None:
    longest = longest_will_s(load(profile_path()))
    assert longest == 7.0
    arbiter = unit(ARBITER)["Service"]
    assert seconds(arbiter["TimeoutStopSec"]) > 2 * longest
    assert (arbiter["KillSignal"], arbiter["KillMode"]) == ("SIGTERM", "mixed")
    assert "SendSIGHUP" not in arbiter
    for service in compose()["services"].values():
        assert seconds(service["stop_grace_period"]) > 2 * longest


def test_no_unit_takes_another_one_down_with_it() -> None:
    """A restart of the arbiter would end a grip that survives it; one of the nodes, the tool."""
    wants = {
        "eehal@.service": "eehal-arbiter@%i.service",
        "eehal-ros1@.service": "eehal@%i.service",
        "eehal-ros2@.service": "eehal@%i.service",
    }
    for path in UNITS:
        keys = unit(path.name)["Unit"]
        assert not {"Requires", "BindsTo", "PartOf", "Conflicts"} & set(keys)
        wanted = wants.get(path.name)
        assert keys.get("Wants") == wanted
        assert wanted is None or wanted in keys["After"].split()


def test_all_but_the_arbiter_hear_this_machine_only_and_only_the_tool_has_ports() -> None:
    for path in UNITS:
        service = unit(path.name)["Service"]
        if path.name == ARBITER:
            assert service["PrivateNetwork"] == "yes"
            continue
        assert (service["IPAddressDeny"], service["IPAddressAllow"]) == ("any", "localhost")
        assert service["User"] == "eehal"
        assert ("DeviceAllow" in service) is (path.name == "eehal@.service")
    ros = "".join(path.read_text() for path in UNITS if "ros" in path.name)
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST" in ros
    assert "ROS_MASTER_URI=http://127.0.0.1:11311" in ros
    assert ros.count(" connect:=true ") == 2, "the nodes are faces of the tool that eehal@ serves"


def test_the_programs_and_options_of_the_units_exist() -> None:
    build = (DEPLOY / "build.sh").read_text()
    for path in UNITS:
        for command in re.findall(
            r"^Exec(?:Start|Reload)=/opt/eehal/bin/(.*)$", path.read_text(), re.MULTILINE
        ):
            program, *words = command.replace("%i", "tool").replace("$EEHAL_OPTIONS", "").split()
            if program == "python":
                assert (path.name, words) == ("eehal-program@.service", ["/etc/eehal/tool.py"])
            elif program == "eehal":
                found = eehal.get_command(click.Context(eehal), words[0])
                assert found, words[0]
                found.make_context(words[0], words[1:], resilient_parsing=True)
                known = {option for each in found.params for option in each.opts}
                own = words[: words.index("--")] if "--" in words else words
                assert {word for word in own if word.startswith("--")} <= known
            else:
                assert f"deploy/{program} " in build
                assert (DEPLOY / program).is_file()
                assert f"AssertPathExists=/opt/eehal/bin/{program}\n" in path.read_text(), (
                    "where it was built"
                )


def test_a_program_is_not_started_again_by_itself() -> None:
    """After a crash it would move the tool although nobody is there."""
    program = unit("eehal-program@.service")
    assert program["Service"]["Restart"] == "no"
    assert program["Unit"]["AssertPathExists"] == "/etc/eehal/%i.py", "its name is not that of a tool"


@pytest.mark.parametrize("restart", ["postinst", "prerm"])
def test_the_package_asks_the_tool_before_it_touches_its_services(restart: str) -> None:
    """A held part refuses: nothing is restarted or stopped before, and nothing is asked of a person."""
    text = (PACKAGE / restart).read_text()
    first = re.search(r"systemctl (?:re|try-re|st)[^\n]*", text)
    assert first
    asked = min(at for word in ("eehal reload ", "eehal check ") if (at := text.find(word)) >= 0)
    assert asked < first.start()
    assert "read " not in text


@pytest.mark.parametrize(
    ("arguments", "variables", "given"),
    [
        ((), {"EEHAL_DESCRIPTION": "/etc/my tool.yaml"}, ["hal", "--ros-args", "-p", "description:=/etc/my tool.yaml"]),
        (
            ("data_logger", "-r", "__ns:=/left"),
            {"EEHAL_DESCRIPTION": "/t.yaml", "EEHAL_LOG_DIRECTORY": "/var/log/eehal/a run"},
            [
                *("data_logger", "--ros-args", "-p", "description:=/t.yaml"),
                *("-p", "directory:=/var/log/eehal/a run", "-r", "__ns:=/left"),
            ],
        ),
    ],
)  # fmt: skip
def test_the_start_of_the_nodes_in_ros_2(
    tmp_path: Path, arguments: tuple[str, ...], variables: dict[str, str], given: list[str]
) -> None:
    for folder in ("bin", "ros"):
        (tmp_path / folder).mkdir()
    program = shutil.copy(DEPLOY / "eehal-hal-ros2", tmp_path / "bin")
    (tmp_path / "bin/python").write_text('#!/bin/sh\nprintf "%s\\n" "$SOURCED" "$@"\n')
    (tmp_path / "bin/python").chmod(0o755)
    missing = subprocess.run([program], capture_output=True, text=True, timeout=10, check=False)
    assert missing.returncode == 3
    (tmp_path / "ros/setup.bash").write_text("export SOURCED=yes\n")
    env = {"PATH": "/usr/bin:/bin", "EEHAL_DESCRIPTION": "", "EEHAL_LOG_DIRECTORY": "", **variables}
    said = subprocess.run(
        [program, *arguments], env=env, capture_output=True, text=True, timeout=10, check=True
    )
    assert said.stdout.splitlines() == ["yes", "-m", "end_effector_hal.ros2", *given]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_scripts_can_be_read_and_run(path: Path) -> None:
    shell = path.read_text().splitlines()[0].removeprefix("#!")
    assert path.stat().st_mode & 0o111 == 0o111
    subprocess.run([shell, "-n", path], check=True, timeout=10)


def compose() -> dict:
    """With what is merged."""
    text = (DEPLOY / "container" / "compose.yaml").read_text()
    document: dict = YAML(typ="safe", pure=True).load(text)
    return document


def test_containers_have_what_they_need_and_no_more() -> None:
    services = compose()["services"]
    assert services["arbiter"]["devices"] == ["/dev/gpiochip0"]
    # another one where the tool has no link: the inputs of the board
    assert services["hal"]["devices"] == [f"${{EEHAL_SENSORS:-{load(profile_path()).link.port}}}"]
    for service in services.values():
        assert service["privileged"] is False
        assert service["cap_drop"] == ["ALL"]
        assert service["group_add"] == ["${GPIO_GID:-49}", "${DIALOUT_GID:-20}"]
        assert service["network_mode"] == "none"


def test_a_container_is_well_when_the_doctor_says_so() -> None:
    from end_effector_hal.cli.doctor._doctor import PARTS

    recipe = (DEPLOY / "container" / "Containerfile").read_text()
    default = re.search(r"EEHAL_HEALTH=(\S+)", recipe)
    assert default
    healths = [default[1], *(each["environment"]["EEHAL_HEALTH"] for each in compose()["services"].values())]
    assert all(set(health.split(",")) <= set(PARTS) for health in healths)
    healthy = (DEPLOY / "container" / "eehal-healthy").read_text()
    assert "doctor" in healthy
    assert "--passive" in healthy, "a health check must not read the sensor port"


def test_the_image_has_a_package_for_every_module_of_ros() -> None:
    from end_effector_hal.cli.doctor._ros import PACKAGES

    packages = (DEPLOY / "container" / "packages.txt").read_text().split()
    assert packages == sorted(packages)
    # rospkg comes with roslaunch
    wanted = {f"python3-{name.replace('_', '-')}" for name in PACKAGES} - {"python3-rospkg"}
    assert wanted <= set(packages)


@pytest.mark.parametrize(
    ("description", "arguments", "given"),
    [
        ("/etc/eehal/my tool.yaml", ["arbiter"], ["arbiter", "/etc/eehal/my tool.yaml"]),
        ("", ["arbiter", "--profile", "verdin_gripper"], ["arbiter", "--profile", "verdin_gripper"]),
        ("", [], ["arbiter"]),
    ],
)
def test_the_entry_of_the_container_names_no_tool_by_itself(
    tmp_path: Path, description: str, arguments: list[str], given: list[str]
) -> None:
    (tmp_path / "eehal").write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    (tmp_path / "eehal").chmod(0o755)
    env = {"PATH": f"{tmp_path}:/usr/bin:/bin", "EEHAL_DESCRIPTION": description}
    entry = DEPLOY / "container" / "eehal-container"
    said = subprocess.run(
        [entry, *arguments], env=env, capture_output=True, text=True, timeout=10, check=True
    )
    assert said.stdout.splitlines() == given
