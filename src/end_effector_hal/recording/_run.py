"""``run.json``: the origin of a recording, written at its start; of a counterexample also what it violates."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from pydantic import FiniteFloat, TypeAdapter, ValidationError

from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.owned import open_owned

from ._files import RunFile


@dataclass(frozen=True, slots=True)
class Watched:
    """The course of a variable, of the location of a process, or of a clock.

    Attributes:
        name: ``evidence[cups]``, ``Gripper``, ``Observer.x``.
        wrong: whether it belongs to the part of the requirement that does not hold at the end.
        values: pairs of a start time, s, and the value from then on, in words; empty for a clock.
        points: for a clock: points (s, s), joined by lines.
        limits: for a clock: the limits with which it is compared, in words and s.
        deadline_s: for a clock: the time at which it passed the violated limit; None: it has not passed a limit.
    """

    name: str
    wrong: bool = False
    values: tuple[tuple[FiniteFloat, str], ...] = ()
    points: tuple[tuple[FiniteFloat, FiniteFloat], ...] = ()
    limits: tuple[tuple[str, FiniteFloat], ...] = ()
    deadline_s: FiniteFloat | None = None

    def document(self) -> dict[str, object]:
        """Return the fields as JSON, without the empty ones."""
        return {key: value for key, value in asdict(self).items() if value not in ((), None)}


_WATCHED = TypeAdapter(Watched)


def read_watched(content: object) -> Watched | None:
    """Return the object in JSON content; None: the content has another form, or no values."""
    try:
        found = _WATCHED.validate_python(content)
    except ValidationError:
        return None
    return found if found.values or found.points else None


SCHEMA_VERSION = 1
"""Version of the format; raised when a key is removed or changes its meaning, but not for a new key."""
KINDS = {
    **dict.fromkeys(
        ("scenario", "description", "hash", "version", "started", "e_stop", "violated", "because"), str
    ),
    **dict.fromkeys(("ros", "simulated"), bool),
    **dict.fromkeys(("actuators", "limits", "switches", "parts"), dict),
    **dict.fromkeys(("start_us", "seed", "ros_generation"), int),
    "violated_s": float,
    "gaps": list,
    "watched": list,
}
_WITHIN = {
    "actuators": str, "limits": dict, "switches": dict, "parts": dict, "gaps": str, "watched": Watched,
}  # fmt: skip
_OF_COUNTEREXAMPLES = ("violated", "violated_s", "because", "watched")


@dataclass(frozen=True)
class RunInfo:
    """The facts about a run, besides its states, that figures and reports need.

    Args:
        scenario: scenario of the testbench; empty on real hardware.
        description: name of the tool.
        hash: hash of the description and its automata.
        version: version of this product.
        ros: whether ROS carried the states.
        ros_generation: generation of ROS, 1 or 2; None: unknown, or without ROS.
        started: time of the start, ISO 8601.
        actuators: name -> kind (``vacuum``, ``cylinder``).
        limits: actuator -> its channel, kind, ``attempts`` and thresholds, such as ``confirmed_kpa`` (for a vacuum kPa
            below ambient, else gauge kPa); ``measured``: the thresholds of its conditions on quantities other than
            pressures (``channel``, ``proves``, ``sign``, ``at``). Missing limits are not drawn.
        parts: part -> the limits with the values of that part; empty: the tool names no parts. An empty value is not
            written.
        switches: channel of a switch -> its ``actuator``, and a word for the meaning of ``on`` and of ``off``
            (``confirmed``, ``gone``, ``empty``); switches without an actuator are left out.
        e_stop: channel of the e-stop's input; empty: no input is read, or unknown. An empty value is not written.
        simulated: whether a testbench supplied the inputs; None: it did if a scenario is named.
        start_us: time zero of the recording, µs on the monotonic clock of its traces.
        gaps: sentences about rows that could not be written, and when.
        seed: seed of the testbench's noise and dead times; None: unknown, or nothing is simulated.
        violated: the requirement that a counterexample refutes; empty: the run is no counterexample.
        violated_s: time at which the violation shows, s.
        because: why the requirement is violated, a sentence.
        watched: the variables, locations and clocks that the violated requirement names.
        note: a sentence about unreadable content; it is not written.
    """

    scenario: str = ""
    description: str = ""
    hash: str = ""
    version: str = ""
    ros: bool = False
    started: str = ""
    actuators: Mapping[str, str] = field(default_factory=dict)
    limits: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    switches: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    parts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    simulated: bool | None = None
    ros_generation: int | None = None
    start_us: int | None = None
    gaps: tuple[str, ...] = ()
    seed: int | None = None
    e_stop: str = ""
    violated: str = ""
    violated_s: float = 0.0
    because: str = ""
    watched: tuple[Watched, ...] = ()
    note: str = field(default="", compare=False)

    @property
    def is_simulated(self) -> bool:
        """Whether a testbench supplied the inputs, as far as the run says."""
        return bool(self.scenario) if self.simulated is None else self.simulated

    def write(self, folder: str | Path) -> Path:
        """Write ``run.json`` into a folder, completely or not at all; raises OSError."""
        path = Path(folder) / RunFile.INFO
        left_out = ["note", *(name for name in ("e_stop", "parts") if not getattr(self, name))]
        left_out += () if self.violated else _OF_COUNTEREXAMPLES
        content: dict[str, Any] = {"schema_version": SCHEMA_VERSION}
        content |= {item.name: getattr(self, item.name) for item in fields(self) if item.name not in left_out}
        if self.violated:
            content["watched"] = [each.document() for each in self.watched]
        beside = path.with_name(f".{RunFile.INFO}.{os.getpid()}")
        try:
            fd = open_owned(beside, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
            with os.fdopen(fd, "w", encoding="utf-8") as file:
                file.write(json.dumps(content, indent=2, ensure_ascii=False, default=dict) + "\n")
                file.flush()
                os.fsync(file.fileno())
            beside.replace(path)
        except OSError:
            with suppress(OSError):
                beside.unlink()
            raise
        return path

    def gripping(self, parts: Sequence[str]) -> RunInfo:
        """Return these facts with the limits of some parts: a limit that differs among them is left out."""
        if not (found := [self.parts[name] for name in parts if name in self.parts]):
            return self
        limits = {
            name: {
                key: at
                for key, at in _items(found[0], name)
                if all((key, at) in _items(each, name) for each in found)
            }
            for name in found[0]
        }
        return replace(self, limits=limits)

    def attempts(self, actuator: str, part: str = "") -> int | None:
        """Return the number of failed attempts that aborts a grip of a part; None: the run does not state it."""
        number = self.gripping([part]).limits.get(actuator, {}).get("attempts")
        return number if isinstance(number, int) and not isinstance(number, bool) and number > 0 else None


def _items(limits: Mapping[str, Any], actuator: str) -> Sequence[tuple[str, Any]]:
    of_it = limits.get(actuator)
    return [*of_it.items()] if isinstance(of_it, dict) else []


def read_run(path: str | Path) -> RunInfo:
    """Read a ``run.json`` or that of a folder; unusable values get their defaults, reported in ``note``."""
    path = Path(path)
    try:
        if path.is_dir():
            path = path / RunFile.INFO
        content = json.loads(path.read_text(encoding="utf-8", errors="replace"))
    except FileNotFoundError:
        return RunInfo()
    except OSError as error:
        return RunInfo(note=_not_read(path, error.strerror or str(error)))
    except (ValueError, RecursionError) as error:
        return RunInfo(note=_not_read(path, f"not JSON: {error}"))
    if not isinstance(content, dict):
        return RunInfo(note=_not_read(path, "not an object"))
    found = {key: _usable(key, value) for key, value in content.items() if key in KINDS and value is not None}
    wrong = [key for key, value in found.items() if value is None or _len(value) != _len(content[key])]
    note = _not_read(path, f"wrong type of {', '.join(wrong)}") if wrong else ""
    return RunInfo(**{key: value for key, value in found.items() if value is not None}, note=note)


def _usable(key: str, value: object) -> Any:
    """Return the value, or its usable elements; None: nothing in it is usable."""
    if not isinstance(value, KINDS[key]):
        return None
    if isinstance(value, dict):
        return {name: item for name, item in value.items() if isinstance(item, _WITHIN[key])}
    if isinstance(value, list):
        value = list(map(read_watched, value)) if key == "watched" else value
        return tuple(item for item in value if isinstance(item, _WITHIN[key]))
    return value


def _len(value: object) -> int:
    return len(value) if isinstance(value, dict | list | tuple) else 1


def _not_read(path: Path, why: str) -> str:
    return f"{path} can only be read in part: {why}."


MODEL_RUN = "run of the model"
"""First words of the scenario of a simulated run of the model."""
COUNTEREXAMPLE = "counterexample"
"""Scenario of a run that refutes a requirement."""
_RECORDED = ("*.mcap", "states*.csv", "events*.csv", "pressures*.csv", "alarms*.csv")


def check_replaceable(folder: Path) -> None:
    """Check that a run of the model may be written into a folder, where it may replace files of the same names.

    Args:
        folder: need not exist.

    Raises:
        UsageError: the folder contains a recording, or cannot be read.
    """
    with os_errors("Cannot be read", folder):
        recorded = [each for pattern in _RECORDED for each in folder.glob(pattern)]
        has_run = (folder / RunFile.INFO).exists()
    scenario = read_run(folder).scenario
    of_model = scenario == COUNTEREXAMPLE or scenario.startswith(MODEL_RUN)
    if any(each.suffix == ".mcap" for each in recorded) or ((recorded or has_run) and not of_model):
        what = "This folder contains a recording: a run of the model would overwrite its files."
        raise UsageError(what, where=str(folder), todo="Name another folder with -o.")
