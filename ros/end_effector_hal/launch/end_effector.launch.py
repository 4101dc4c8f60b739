"""The HAL of one tool: its nodes in one process or in five, and the process that owns the output lines.

`ros2 launch end_effector_hal end_effector.launch.py --show-args` lists the arguments. This file is read by the
interpreter of `ros2`, which may not see the environment of end-effector-hal: it imports nothing of it.
"""

import subprocess
import tempfile

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, LogInfo, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.substitutions import ExecutableInPackage

PACKAGE = "end_effector_hal"
PROGRAMS = {
    "one": ("hal",),
    "five": ("hal_main", "grip", "tool_change", "pressure", "position"),
    "managed": ("lifecycle_hal",),
}
HOSTS = ("hal", "lifecycle_hal", "hal_main")
RECORDERS = (*HOSTS, "data_logger")
SWITCH = ("true", "false")
# an unfinished grip is unwound, and a last will is executed to its end
END_S = "30"
# Ctrl-C reaches a program twice, from the terminal and from ros2 launch; a second signal would end the arbiter at once
SIGNALLED_ONCE = "setsid"

ARGUMENTS = (
    (
        "description",
        "",
        None,
        "the tool: path of its YAML file; a relative one starts where ros2 launch is called",
    ),
    (
        "profile",
        "",
        None,
        "the tool: name of a shipped one, such as verdin_gripper; this or a description is required",
    ),
    ("namespace", "", None, "namespace of all nodes and names; empty: none"),
    (
        "processes",
        "one",
        tuple(PROGRAMS),
        "one for all nodes, five as the paper draws them, or one below a managed node, to be configured and activated",
    ),
    (
        "prove",
        "false",
        SWITCH,
        "managed: prove the tool when it is configured and `eehal verify` has kept no verdict",
    ),
    ("arbiter", "true", SWITCH, "start the line arbiter too; false: it runs already (a system service)"),
    (
        "connect",
        "false",
        SWITCH,
        "use the tool that `eehal serve` runs, which outlives a restart of ROS; arbiter:=false where it has its own",
    ),
    (
        "simulated",
        "false",
        SWITCH,
        "no hardware: a copy of the tool on virtual lines, the testbench at their other end",
    ),
    ("scenario", "nominal", None, "what goes wrong at the testbench; eehal testbench --list"),
    (
        "frame_id",
        "",
        None,
        "frame in the headers of the pressures; empty: TOOL_link, as eehal export urdf calls it",
    ),
    ("script", "", None, "commands for a Supervisor, such as: lock; grip; wait 2; drop; quit"),
    ("log_directory", "", None, "folder for the recording of a run; empty: no recording"),
    ("segment_mb", "64", None, "files of a recording are cut into segments of so many MB"),
    ("keep_mb", "1000", None, "a recording keeps so many MB; its oldest segments are removed"),
)


def generate_launch_description() -> LaunchDescription:
    """What ros2 launch asks for."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, choices=choices, description=about)
        for name, default, choices, about in ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_processes)])


def _processes(context):
    given = {name: LaunchConfiguration(name).perform(context) for name, *_ in ARGUMENTS}
    options = [f"--{name}={given[name]}" for name in ("description", "profile")]
    said = _run(context, "check_launch", *options, f"--file={given['description']}")
    tool = said.split(" ", 2)[2]
    started = []
    if given["simulated"] == "true":
        folder = tempfile.mkdtemp(prefix="eehal-simulated-")
        tool = _run(context, "eehal", "testbench", tool, "--prepare", folder)
        started += [
            LogInfo(msg=f"simulated: {tool}"),
            _eehal("testbench", tool, "--scenario", given["scenario"], name="testbench"),
        ]
    if given["arbiter"] == "true":
        started.append(_eehal("arbiter", tool, name="arbiter", prefix=SIGNALLED_ONCE))
    programs = [*PROGRAMS[given["processes"]], *(["data_logger"] if given["log_directory"] else [])]
    for program in programs:
        parameters = {"description": tool}
        if given["processes"] == "managed":
            parameters["prove"] = given["prove"]
        if program in HOSTS:
            parameters["connect"] = given["connect"]
        if given["frame_id"] and program in ("hal", "lifecycle_hal", "pressure"):
            parameters["frame_id"] = given["frame_id"]
        if given["log_directory"] and program in RECORDERS:
            parameters["directory"] = given["log_directory"]
            parameters |= {name: given[name] for name in ("segment_mb", "keep_mb")}
        started.append(_node(program, given["namespace"], parameters, respawn=True))
    if given["script"]:
        started.append(_node("supervisor", given["namespace"], {"script": given["script"]}))
    return started


def _node(program, namespace, parameters, *, respawn=False):
    return Node(
        package=PACKAGE,
        executable=program,
        namespace=namespace,
        parameters=[parameters],
        output="screen",
        respawn=respawn,
        respawn_delay=1.0,
        sigterm_timeout=END_S,
    )


def _eehal(*arguments, name, prefix=None):
    return ExecuteProcess(
        cmd=[ExecutableInPackage(package=PACKAGE, executable="eehal"), *arguments],
        name=name,
        prefix=prefix,
        output="screen",
        respawn=True,
        respawn_delay=1.0,
        sigterm_timeout=END_S,
    )


def _run(context, program, *arguments):
    """Run a program to its end; its output, or its sentence as the one error of this launch."""
    path = ExecutableInPackage(package=PACKAGE, executable=program).perform(context)
    done = subprocess.run([path, *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr.strip() or f"{path} ended with code {done.returncode}")
    return done.stdout.strip()
