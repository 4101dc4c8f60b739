"""In place of `ros2 launch` and `ros2 run`, of which there is no wheel: what this product's launch files use of them.

Written from the public interface of `launch` and `launch_ros` (Jazzy). `python ros2_launch.py launch PACKAGE FILE
NAME:=VALUE …`, or `run PACKAGE PROGRAM …`. The modules that a launch file imports are this one.
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from runpy import run_path
from typing import Any, Protocol

MODULES = (
    "launch",
    "launch.actions",
    "launch.launch_description_sources",
    "launch.substitutions",
    "launch_ros",
    "launch_ros.actions",
    "launch_ros.substitutions",
)
PREFIX = Path(os.environ["AMENT_PREFIX_PATH"].partition(":")[0])
LOOK_S, SIGKILL_S = 0.05, 5.0


class Entity(Protocol):
    """What a launch description consists of."""

    def visit(self, context: Context) -> None:
        """Do it."""


@dataclass
class Context:
    """Arguments by name, and what runs."""

    given: dict[str, str]
    running: list[Running]

    def apart(self) -> Context:
        return Context(dict(self.given), self.running)


@dataclass
class LaunchDescription:
    entities: Sequence[Entity]

    def visit(self, context: Context) -> None:
        for entity in self.entities:
            entity.visit(context)


class DeclareLaunchArgument:
    def __init__(
        self,
        name: str,
        *,
        default_value: str | None = None,
        choices: Sequence[str] | None = None,
        description: str = "",
    ) -> None:
        self._name, self._default, self._choices = name, default_value, choices

    def visit(self, context: Context) -> None:
        value = context.given.get(self._name, self._default)
        if value is None:
            raise RuntimeError(f"missing required argument {self._name!r}")
        if self._choices and value not in self._choices:
            raise RuntimeError(f"Argument {self._name!r} is {value!r}, valid are {self._choices}")
        context.given[self._name] = value


class LaunchConfiguration:
    def __init__(self, name: str, *, default: str | None = None) -> None:
        self._name, self._default = name, default

    def perform(self, context: Context) -> str:
        if self._default is None:
            return context.given[self._name]
        return context.given.get(self._name, self._default)


@dataclass
class ExecutableInPackage:
    package: str
    executable: str

    def perform(self, _context: Context) -> str:
        path = PREFIX / "lib" / self.package / self.executable
        if not os.access(path, os.X_OK):
            raise RuntimeError(
                f"executable {self.executable!r} not found on the libexec directory {path.parent}"
            )
        return str(path)


@dataclass
class OpaqueFunction:
    function: Callable[[Context], Iterable[Entity]]

    def visit(self, context: Context) -> None:
        LaunchDescription([*self.function(context)]).visit(context)


@dataclass
class GroupAction:
    actions: Sequence[Entity]

    def visit(self, context: Context) -> None:
        LaunchDescription(self.actions).visit(context.apart())


@dataclass
class PythonLaunchDescriptionSource:
    path: str

    def load(self) -> LaunchDescription:
        description = run_path(self.path)["generate_launch_description"]()
        assert isinstance(description, LaunchDescription)
        return description


@dataclass
class IncludeLaunchDescription:
    source: PythonLaunchDescriptionSource
    launch_arguments: Iterable[tuple[str, str]] = ()

    def visit(self, context: Context) -> None:
        context.given.update(self.launch_arguments)
        self.source.load().visit(context)


@dataclass
class LogInfo:
    msg: str

    def visit(self, _context: Context) -> None:
        say(self.msg)


@dataclass
class ExecuteProcess:
    cmd: Sequence[str | ExecutableInPackage]
    name: str
    prefix: str | None = None
    output: str = "log"
    respawn: bool = False
    respawn_delay: float = 0.0
    sigterm_timeout: str = "5"

    def visit(self, context: Context) -> None:
        words = [word if isinstance(word, str) else word.perform(context) for word in self.cmd]
        running = Running(self, [*shlex.split(self.prefix or ""), *words], len(context.running) + 1)
        context.running.append(running)


class Node(ExecuteProcess):
    def __init__(
        self,
        *,
        package: str,
        executable: str,
        namespace: str,
        parameters: Sequence[Mapping[str, Any]],
        **options: Any,
    ) -> None:
        # of one file for all nodes of the process; JSON is YAML
        with tempfile.NamedTemporaryFile("w", prefix="launch_params_", delete=False) as file:
            json.dump(
                {"/**": {"ros__parameters": {k: v for each in parameters for k, v in each.items()}}}, file
            )
        space = ["-r", f"__ns:=/{namespace.strip('/')}"] if namespace else []
        command = [ExecutableInPackage(package, executable), "--ros-args", *space, "--params-file", file.name]
        super().__init__(command, name=executable, **options)


@dataclass
class Running:
    """A process, and when it is started again."""

    action: ExecuteProcess
    command: Sequence[str]
    number: int
    process: subprocess.Popen[bytes] | None = None
    due: float = field(default_factory=time.monotonic)
    urged: list[tuple[float, signal.Signals]] = field(default_factory=list)

    def end(self) -> None:
        """Ask it to end; where it does not, more urgently."""
        now = time.monotonic()
        late = now + float(self.action.sigterm_timeout)
        # the terminal has sent the first one to all of this group already
        self.urged = [(now, signal.SIGINT), (late, signal.SIGTERM), (late + SIGKILL_S, signal.SIGKILL)]

    def look(self, *, ending: bool) -> bool:
        """Start it where it is due, and tell its end; whether it goes on."""
        label = f"[{self.action.name}-{self.number}]"
        if self.process is None:
            if ending or time.monotonic() < self.due:
                return not ending
            self.process = subprocess.Popen(self.command)
            say(f"{label}: process started with pid [{self.process.pid}]")
        if (code := self.process.poll()) is None:
            while self.urged and time.monotonic() >= self.urged[0][0]:
                _, number = self.urged.pop(0)
                if number != signal.SIGINT:
                    say(f"{label}: failed to terminate, escalating to '{number.name}'")
                self.process.send_signal(number)
            return True
        say(f"{label}: process has {f'died [exit code {code}]' if code else 'finished cleanly'}")
        self.process, self.due = None, time.monotonic() + self.action.respawn_delay
        return self.action.respawn and not ending


def say(text: str) -> None:
    print(f"[INFO] {text}", flush=True)  # noqa: T201 as `ros2 launch` does


def launch(package: str, name: str, *arguments: str) -> int:
    """To its end, by itself or by SIGINT."""
    given = {key: value for key, _, value in (each.partition(":=") for each in arguments)}
    context = Context(given, [])
    try:
        path = PREFIX / "share" / package / "launch" / name
        PythonLaunchDescriptionSource(str(path)).load().visit(context)
    except RuntimeError as error:
        print(f"[ERROR] [launch]: Caught exception in launch: {error}", flush=True)  # noqa: T201
        return 1
    running = context.running
    try:
        while running:
            running = [each for each in running if each.look(ending=False)]
            time.sleep(LOOK_S)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for each in running:
            each.end()
        while running := [each for each in running if each.look(ending=True)]:
            time.sleep(LOOK_S)
    return 0


def main(command: str, package: str, name: str, *arguments: str) -> int:
    sys.modules.update(dict.fromkeys(MODULES, sys.modules[__name__]))
    if command == "launch":
        return launch(package, name, *arguments)
    assert command == "run"
    program = ExecutableInPackage(package, name).perform(Context({}, []))
    return subprocess.run([program, *arguments], check=False).returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
