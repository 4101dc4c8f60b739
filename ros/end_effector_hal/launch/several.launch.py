"""Several tools, each in a namespace of its own: tools:="left=left.yaml right=right.yaml".

`ros2 launch end_effector_hal several.launch.py --show-args` lists the arguments; those of end_effector.launch.py may be
given as well and count for every tool; each records into a folder of its own below log_directory.
"""

import shlex
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

ONE_TOOL = Path(__file__).with_name("end_effector.launch.py")
TOOLS = "namespace=FILE of each tool, with spaces between them; a name of a shipped tool counts as well"


def generate_launch_description() -> LaunchDescription:
    """What ros2 launch asks for."""
    return LaunchDescription(
        [DeclareLaunchArgument("tools", description=TOOLS), OpaqueFunction(function=_tools)]
    )


def _tools(context):
    text = LaunchConfiguration("tools").perform(context)
    try:
        given = shlex.split(text)
    except ValueError as error:
        raise RuntimeError(f"several.launch: tools:={text}: {error}.") from None
    pairs = [each.partition("=")[::2] for each in given]
    namespaces = [namespace.strip("/") for namespace, _ in pairs]
    if not pairs or not all(namespace and tool for namespace, tool in pairs):
        raise RuntimeError(f"several.launch: {given} are no tools. Expected: tools:='left=FILE right=FILE'.")
    if len(set(namespaces)) < len(namespaces):
        raise RuntimeError(f"several.launch: two tools in one namespace: {', '.join(namespaces)}.")
    folder = LaunchConfiguration("log_directory", default="").perform(context)
    return [_tool(namespace, tool, folder) for namespace, tool in pairs]


def _tool(namespace, tool, folder):
    named = {"description": "", "profile": ""}
    named["description" if Path(tool).suffix else "profile"] = tool
    source = PythonLaunchDescriptionSource(str(ONE_TOOL))
    recorded = str(Path(folder, namespace.strip("/"))) if folder else ""
    arguments = {**named, "namespace": namespace, "log_directory": recorded}
    return GroupAction([IncludeLaunchDescription(source, launch_arguments=arguments.items())])
