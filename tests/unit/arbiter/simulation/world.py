"""One virtual time for the arbiter with its disk, the program with its client, and who reads the sensors."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from end_effector_hal import runtime
from end_effector_hal.arbiter import HAL, ArbiterClient, Policy, arbiter_policy, client_lines
from end_effector_hal.arbiter.client import _client
from end_effector_hal.arbiter.protocol import write_message
from end_effector_hal.arbiter.rules._policy import Role
from end_effector_hal.arbiter.rules._predicates import FORMER
from end_effector_hal.arbiter.server import _requests
from end_effector_hal.control import Status, network_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import LineBusyError, ReportedError, UsageError
from end_effector_hal.runtime.programs import _program
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_hal.wires.rpc import _client as rpc_client
from tests.unit.arbiter.simulation.disk import SimulatedDisk
from tests.unit.arbiter.simulation.judge import Judge
from tests.unit.arbiter.simulation.process import ArbiterProcess
from tests.unit.arbiter.simulation.wire import NearEnd

TICK_US, RENEW_US = 50_000, 250_000
TOOL = load(profile_path())
GRIP_LINES = tuple(actuator.line for _, actuator in TOOL.ordered)
POLICY = arbiter_policy(TOOL)
CHANGES = "description changed"
CHANGED = [
    replace(
        POLICY, roles={line: Role("another") if line == each else role for line, role in POLICY.roles.items()}
    )
    for each in POLICY.lines
] + [
    replace(POLICY, roles={line: role for line, role in POLICY.roles.items() if line != each})
    for each in GRIP_LINES
]
"""The same tool with another description: a line has another role in it, or none."""
KEYS = {"bottom": -80_000, "cylinder": 600_000, "top": -80_000}
FAULTS = (
    "arbiter dies", "program dies", "both die", "sensors die", "disk full", "disk fails", "disk hangs", "memory full",
    "memory fails", "power", "e-stop",
)  # fmt: skip
REST = {EndEffectorState.GRIPPED, EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR}


class ArbiterKilledError(BaseException):
    """The arbiter dies here; a BaseException, so that no part of it can catch it."""


class ProgramKilledError(BaseException):
    """The program dies here."""


class _NoThread:
    def __init__(self, **_: object) -> None: ...

    def start(self) -> None: ...

    def is_alive(self) -> bool:
        return False


class _Event:
    """Nobody waits for a real time."""

    def __init__(self) -> None:
        self._set = False

    def is_set(self) -> bool:
        return self._set

    def set(self) -> None:
        self._set = True

    def wait(self, seconds: float) -> bool:
        raise LineBusyError(f"wait {seconds} s")


class World:
    """Everything, from one seed.

    Args:
        seed: replays the run.
        met: counts which fault met which point of which message.
    """

    def __init__(self, seed: int, met: Counter[tuple[str, str]]) -> None:
        self._last = POLICY
        self.random, self._changes = random.Random(seed), random.Random(f"{seed} changed")
        self.now, self.boot = 1_000_000_000, "boot 0"
        self.lines = dict.fromkeys(POLICY.lines, False)
        self.judge = Judge(self.lines, GRIP_LINES)
        self.memory = SimulatedDisk("memory", self.hazard)
        self.mark = SimulatedDisk("mark", self.hazard)
        self.disk = SimulatedDisk("disk", self.hazard)
        self.ends: list[NearEnd] = []
        self.arbiter: ArbiterProcess | None = None
        self.program: Program | None = None
        self.sensors: NearEnd | None = None
        self.e_stop_open = False
        self.never_confirms = self.random.choice((None, None, *GRIP_LINES))
        self._met, self._message, self._points = met, "start", 0
        self._faults = sorted(
            (int(self.random.expovariate(1 / 80)), self.random.choice(FAULTS))
            for _ in range(self.random.randint(1, 4))
        )
        self._heal_at: dict[str, int] = {}
        self._inside: list[str] = []
        self._doomed: set[str] = set()
        self._sequence = 0
        self.safe = False

    # What the processes touch

    def clock(self) -> int:
        return self.now

    def pid(self) -> int:
        """In a PID namespace of its own every client is pid 0."""
        return self.random.choice((0, 0, self.random.randint(2, 9)))

    @property
    def listener(self) -> ArbiterProcess | None:
        return self.arbiter

    def message(self, line: bytes) -> None:
        """The arbiter reads a message."""
        content = json.loads(line)
        self._message = str(content["op"])
        if self._message == "set":
            self.judge.asked(content["levels"], content.get("will"))
        self.hazard("message")

    def hazard(self, where: str) -> None:
        """A point at which something may fail, and whoever is at work may die."""
        self._points += self._message != "tell" or self.random.random() < 0.1  # they are most of all messages
        while self._faults and self._faults[0][0] <= self._points and not self.safe:
            _, fault = self._faults.pop(0)
            self._met[fault, f"{self._message}: {where}"] += 1
            self._happens(fault)
        if "arbiter" in self._doomed and "arbiter" in self._inside:
            raise ArbiterKilledError

    @contextmanager
    def inside(self, process: str) -> Iterator[None]:
        """A process is at work; it may die in here, and with it only what it does."""
        if process == "arbiter" and self.arbiter is None:
            return
        self._inside.append(process)
        try:
            yield
        except ArbiterKilledError:
            self._inside.pop()
            self._bury_arbiter()
        else:
            self._inside.pop()
        if "program" in self._doomed and "program" in self._inside and "arbiter" not in self._inside:
            raise ProgramKilledError

    def _happens(self, fault: str) -> None:
        later = self.now + self.random.choice((TICK_US, 400_000, 3_000_000))
        match fault:
            case "arbiter dies" | "both die" | "power":
                self._doomed.add("arbiter")
                self._heal_at["arbiter"] = later + self.random.choice(
                    (0, 0, 9_000_000)
                )  # longer than a release
            case "disk full" | "memory full":
                for disk in [self.disk] if fault.startswith("disk") else [self.memory, self.mark]:
                    disk.full = True
                self._heal_at[fault] = later
            case "disk fails" | "memory fails":
                for disk in [self.disk] if fault.startswith("disk") else [self.memory, self.mark]:
                    disk.failing = True
                self._heal_at[fault] = later
            case "disk hangs":
                self.disk.hangs, self._heal_at[fault] = True, later
            case "e-stop":
                self.e_stop_open, self._heal_at[fault] = True, later
            case "sensors die":
                self._doomed.add("sensors")
                self._heal_at["sensors"] = later
        if fault in ("program dies", "both die", "power"):
            self._doomed.add("program")
            self._heal_at["program"] = self.now + self.random.choice((TICK_US, 400_000, 3_000_000))
        if fault == "power":
            self._doomed.add("power")

    def waits(self) -> list[str]:
        """Lines whose deactivation waits for them to settle."""
        sessions = self.arbiter.rules.sessions if self.arbiter is not None else []
        waiting = [write.levels for each in sessions for write in each.queue]
        return [name for name in GRIP_LINES if any(levels.get(name) is False for levels in waiting)]

    def shown(self) -> None:
        """Somebody is told of the faults that the arbiter has latched."""
        if self.arbiter is not None:
            safe = {name for name in self.judge.latched if self._on_disk(name)}
            self.judge.shown(set(self.arbiter.rules.predicates.faults), safe=safe)

    def _on_disk(self, fault: str) -> bool:
        return f'"{fault}"'.encode() in self.disk.safe

    # The course of a run

    def run(self) -> None:
        """Faults in the middle of grips and drops; then everything is well again, and must work."""
        until = self.now + self.random.choice((2_000_000, 6_000_000, 12_000_000))
        self._start_arbiter()
        while self.now < until and not self.judge.violations:
            self._tick()
            self._play()
        if not self.judge.violations:
            self._must_work()

    def _tick(self) -> None:
        self.now += self.random.choice((TICK_US, TICK_US - 10_000, 20_000))
        for what in [name for name, at in self._heal_at.items() if at <= self.now]:
            del self._heal_at[what]
            self._heal(what)
        if self.arbiter is not None:
            self.arbiter.step()
        self._bury()
        self._tell()
        self._bury()
        if self.program is None and "program" not in self._heal_at:
            self._start_program()
        if self.program is not None:
            self._as_program(self.program.tick)
        self._bury()

    def _heal(self, what: str) -> None:
        match what:
            case "arbiter":
                self._start_arbiter()
            case "disk full":
                self.disk.full = False
            case "disk fails":
                self.disk.failing = False
            case "disk hangs":
                self.disk.hangs = False
            case "memory full":
                self.memory.full = self.mark.full = False
            case "memory fails":
                self.memory.failing = self.mark.failing = False
            case "e-stop":
                self.e_stop_open = False

    def _play(self) -> None:
        program, dice = self.program, self.random.random()
        if program is None:
            return
        state = program.state
        if self.arbiter is None and dice < 0.2:
            self._as_program(lambda: program.command("cancel" if dice < 0.05 else "drop"))
        elif state == EndEffectorState.STAND_BY and dice < 0.3:
            self._as_program(lambda: program.command("grip"))
        elif state == EndEffectorState.GRIPPING and dice < 0.01:
            self._as_program(lambda: program.command("cancel"))
        elif state in REST and dice < 0.05:
            self._as_program(lambda: program.command("drop"))
        elif dice > 0.995:
            self._as_program(program.leave)
        elif dice > 0.985 and self.judge.latched:
            self._as_program(program.reset)
        elif dice > 0.98 and self.arbiter is not None:
            self.arbiter.close()
            self._bury_arbiter()
            self._heal_at["arbiter"] = self.now + 200_000
        self._bury()

    def _must_work(self) -> None:
        self.safe, self.never_confirms, self.e_stop_open = True, None, False
        for what in [*self._heal_at]:
            self._heal(what)
        self._heal_at.clear()
        if self.arbiter is None:
            self._start_arbiter()
        self._until("the program is ready", lambda state: state in REST | {EndEffectorState.STAND_BY}, 15)
        program = self.program
        assert program is not None
        if program.state in REST:
            self._until("a drop is accepted", lambda _: program.command("drop"), 5)
        self._until("STAND_BY", lambda state: state == EndEffectorState.STAND_BY, 10)
        self._until("the faults are reset", lambda _: self._is_reset(), 5)
        self._until("a grip is accepted", lambda _: program.command("grip"), 5)
        self._until("GRIPPED", lambda state: state == EndEffectorState.GRIPPED, 15)
        self._as_program(lambda: program.command("drop"))
        self._until("STAND_BY after a Drop", lambda state: state == EndEffectorState.STAND_BY, 5)
        if not self.judge.violations and any(self.lines[name] for name in GRIP_LINES):
            self.judge.violations.append("lines are active in STAND_BY")

    def _is_reset(self) -> bool:
        assert self.program is not None
        return self.program.reset()

    def _until(self, what: str, ready: Any, seconds: float) -> None:
        end = self.now + round(seconds * 1e6)
        while not self.judge.violations:
            self._tick()
            if self.program is not None and ready(self.program.state):
                return
            if self.now > end:
                seen = self.program.words() if self.program else "there is none"
                self.judge.violations.append(f"the next program cannot work: never {what} ({seen})")

    # Births and deaths

    def _start_arbiter(self) -> None:
        if self.arbiter is None:
            self._message = "start"
            if self._changes.random() < 0.3:
                self._start_changed(self._changes.choice(CHANGED))
            try:
                self._start_with(POLICY)
            except UsageError:  # the one with another description has left a doubt: it is started once more
                self._start_changed(self._last)
                with suppress(UsageError):
                    self._start_with(POLICY)
            if self.arbiter is None:
                self._heal_at.setdefault("arbiter", self.now + 200_000)

    def _start_with(self, policy: Policy) -> None:
        with self._inside_start():
            self.arbiter = ArbiterProcess(self, policy)
            self.shown()

    def _start_changed(self, policy: Policy) -> None:
        """Somebody has changed the description: it is refused while the line may be active; then it is restored."""
        end, recorded = "refused", any(b'"driven"' in disk.content for disk in (self.memory, self.disk))
        with suppress(UsageError), self._inside_start():
            changed = self.arbiter = ArbiterProcess(self, policy)
            end, self._last = "accepted", policy
            lost = [
                line
                for line, role in POLICY.roles.items()
                if policy.roles.get(line) != role and self.lines[line]
            ]
            if lost and recorded and FORMER not in changed.rules.predicates.faults:
                self.judge.violations.append(f"{lost[0]} is active, and a description without it is accepted")
            changed.close()
        self.arbiter = None
        self._met[CHANGES, end] += 1

    @contextmanager
    def _inside_start(self) -> Iterator[None]:
        self._inside.append("arbiter")
        try:
            yield
        except ArbiterKilledError:
            self.arbiter = None
        finally:
            self._inside.pop()

    def _start_program(self) -> None:
        try:
            self.program = Program(self)
        except ReportedError:
            return  # tried again
        except ProgramKilledError:
            self._bury()
            return
        if self.arbiter is not None:
            self.judge.came(set(self.arbiter.rules.predicates.faults))
        self._as_program(self.program.begin)

    def _as_program(self, what: Any) -> Any:
        try:
            with self.inside("program"):
                return what()
        except ProgramKilledError:
            self._inside = [each for each in self._inside if each != "program"]
            self._bury()
        return None

    def _bury(self) -> None:
        """Those who were hit while somebody else was at work die now."""
        if "arbiter" in self._doomed:
            self._bury_arbiter()
        if "program" in self._doomed:
            self._doomed.discard("program")
            if self.program is not None:
                program, self.program = self.program, None
                self.judge.died(program.decided)
                program.client_end_closes()
        if "sensors" in self._doomed:
            self._doomed.discard("sensors")
            if self.sensors is not None:
                self.sensors.close()
                self.sensors = None
        if "power" in self._doomed:
            self._lose_power()

    def _bury_arbiter(self) -> None:
        self._doomed.discard("arbiter")
        self.arbiter = None
        for end in self.ends:
            end.is_lost = True
        self._heal_at.setdefault("arbiter", self.now + 200_000)

    def _lose_power(self) -> None:
        """All processes die, outputs go inactive, memory is empty; what stands safely on the disk stays."""
        self._doomed.discard("power")
        self.disk.lose_power()
        self.memory.remove()
        self.mark.remove()
        self.boot = f"boot {self.now}"
        for name in self.lines:
            self.lines[name] = False
        self.judge.held = self.judge.commanded = self.judge.unfinished = False
        self.judge.latched = {name for name in self.judge.latched if self._on_disk(name)}

    # Who reads the sensors

    def _tell(self) -> None:
        if self.sensors is not None and self.sensors.is_lost:
            self.sensors.close()
            self.sensors = None
        try:
            if self.sensors is None and "sensors" not in self._heal_at:
                self.sensors = NearEnd(self)
                self.sensors.connect("")
                token = f"{self.random.getrandbits(128):032x}"
                hello = {"op": "hello", "role": "sensors", "client": "pressure", "token": token}
                self.sensors.sendall(write_message({"id": 0, **hello}))
            if self.sensors is not None:
                told = {
                    "locked": True,
                    "e_stop_closed": not self.e_stop_open,
                    "nothing_gripped": not self.lines[GRIP_LINES[0]],
                }
                known = {need.predicate for needs in POLICY.needs.values() for need in needs}
                predicates = {name: holds for name, holds in told.items() if name in known}
                self.sensors.sendall(
                    write_message({"op": "tell", "predicates": predicates, "at_us": self.now})
                )
        except OSError:
            self.sensors = None

    def frame(self) -> Frame:
        """What the sensors show: as the lines are, but for an actuator that never confirms."""
        self._sequence += 1
        shows = {
            name: self.lines[actuator.line] and actuator.line != self.never_confirms
            for name, actuator in TOOL.ordered
        }
        parts = [shows[name] for name, _ in TOOL.ordered]
        noise = 25 * (self._sequence % 4)  # a sensor that never moves counts as frozen
        values: dict[str, Any] = {
            key: (high if on else 0) + noise for (key, high), on in zip(KEYS.items(), parts, strict=True)
        }
        values |= {"cylinder_extended": parts[1], "cylinder_retracted": not parts[1]}
        values |= {
            "supply": 600_000 + noise,
            "locked": True,
            "unlocked": False,
            "tool_present": True,
            "in_stand": True,
        }
        values["estop_ok"] = not self.e_stop_open
        return Frame(self.now, self._sequence, self._sequence * 20, values)


class Program:
    """The program and the client of the product, without their threads."""

    def __init__(self, world: World) -> None:
        self._world, self._renew_at = world, world.now + RENEW_US
        self.told: Status | None = None
        self._known = set(world.ends)
        self._client = ArbiterClient("simulated", HAL, client_lines(TOOL, HAL), patience_s=0)
        self._program = runtime.Program(TOOL, self._client, self._tell, clock=lambda: world.now)
        self._client.attend(on_lost=self._program_loses, on_faults=self._program_knows)

    @property
    def state(self) -> int:
        return int(self.told.ee) if self.told else int(EndEffectorState.OFF)

    @property
    def decided(self) -> int:
        """What its automata are in; perhaps it has not said so yet."""
        return int(self._program._adoption.controller.status().ee)

    def words(self) -> str:
        """What it said last."""
        if self.told is None:
            return "it has said nothing"
        return f"{EndEffectorState(self.told.ee).name}: {self.told.reason} {' '.join(self.told.alarm_texts)}"

    def begin(self) -> None:
        self._program._begin()

    def tick(self) -> None:
        program, now = self._program, self._world.now
        if (due := program._due()) is not None and due <= now and (follow_up := program._time_passed()):
            follow_up()
        if program._adoption.begun:
            program._act(program._adoption.controller.frame(self._world.frame(), now))
        if now >= self._renew_at:
            self._renew_at = now + RENEW_US
            if lost := self._client._renew():
                self._program_loses(lost)

    def command(self, name: str) -> bool:
        program, judge, lost = self._program, self._world.judge, self._world.arbiter is None
        answer, statuses = program._decide(name)
        adoption, held = program._adoption, judge.held
        if answer.accepted:
            judge.accepted(name)
            if lost and name in ("drop", "cancel"):
                judge.violations.append(f"a {name} is accepted while there is no line arbiter")
        program._act(statuses)
        if answer.accepted and program._adoption is not adoption and program._adoption.lost:
            judge.unreachable(held=held)
            return False
        return bool(answer.accepted)

    def reset(self) -> bool:
        judge, before = self._world.judge, set(self._world.judge.latched)
        judge.latched.clear()  # whoever dies in between may have done it or not
        try:
            self._client.reset()
        except ReportedError:
            arbiter = self._world.arbiter
            judge.latched |= before & set(arbiter.rules.predicates.faults) if arbiter else set()
            return False
        return True

    def leave(self) -> None:
        """SIGTERM."""
        with suppress(ReportedError):
            self._client.close(
                self._program._adoption.outputs.mapping.last_will(self._program.status, "sigterm")
            )
        self._world.program = None
        self._world.judge.commanded, self._world.judge.at_work = False, True

    def client_end_closes(self) -> None:
        """The kernel closes the sockets of the dead."""
        if (socket := self._client._arbiter._socket) is not None:
            socket.close()

    def _tell(self, status: Status) -> None:
        self.told = status
        at_work = status.command is not Command.NONE
        self._world.judge.told(int(status.ee), self._world.waits(), held=status.held, at_work=at_work)

    def _program_loses(self, error: Any) -> None:
        self._program._lose(error)

    def _program_knows(self, faults: Mapping[str, str]) -> None:
        self._world.shown()
        self._program._act(self._program._keep_faults(faults))


@contextmanager
def virtual_time(patch: Any) -> Iterator[Any]:
    """The product's own modules in the time of a world; gives a function that chooses the world."""
    worlds: list[World] = []
    network = network_of(TOOL)

    def now() -> int:
        return worlds[-1].now

    for module in (_requests, _client):
        if hasattr(module, "now_us"):
            patch.setattr(module, "now_us", now)
    lock = _client.threading.Lock
    patch.setattr(
        _client,
        "threading",
        SimpleNamespace(Lock=lock, Event=_Event, Thread=_NoThread, current_thread=lambda: None),
    )
    patch.setattr(_client, "make_token", lambda: f"{worlds[-1].random.getrandbits(128):032x}")
    patch.setattr(_program, "network_of", lambda _: network)
    real = rpc_client.socket
    fake = SimpleNamespace(
        **{
            name: getattr(real, name)
            for name in ("AF_UNIX", "SOCK_STREAM", "SOL_SOCKET", "SO_RCVTIMEO", "SO_SNDTIMEO")
        }
    )
    fake.socket = lambda *_: NearEnd(worlds[-1])
    patch.setattr(rpc_client, "socket", fake)
    yield worlds.append
