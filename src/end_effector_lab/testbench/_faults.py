"""The faults that a scenario can name: a table, a row each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ._scenario import NEVER
from .physics import ACTUATOR, CHANGER, LEAKS, PRESSURE

ANY = ACTUATOR, CHANGER


@dataclass(frozen=True)
class Number:
    """A number in a fault's text, with its limits; ``default``: it may be left out; ``whole``: no fraction."""

    name: str
    low: float
    high: float
    default: float | None = None
    whole: bool = False


@dataclass(frozen=True)
class Fault:
    """A kind of fault.

    Args:
        name: as it stands in a scenario, ``name[:actuator][:number]``.
        meaning: a phrase for people.
        changes: field of :class:`Effect` (or of :class:`Scenario`) and value, from the number.
        on: traits of devices, one of which it takes; empty: it concerns the whole bench.
        number: what else is to be given.
    """

    name: str
    meaning: str
    changes: Callable[[float], Mapping[str, object]]
    on: tuple[str, ...] = ()
    number: Number | None = None

    @property
    def usage(self) -> str:
        """``leak:<actuator>[:<l_min>]``."""
        text = self.name + (":<actuator>" if self.on else "")
        if self.number is None:
            return text
        return text + (
            f"[:<{self.number.name}>]" if self.number.default is not None else f":<{self.number.name}>"
        )


RATE = Number("rate", 0, 1)
BIT = Number("bit", 0, 1, whole=True)


def _micros(seconds: float) -> int:
    return round(seconds * 1e6)


FAULTS: tuple[Fault, ...] = (
    Fault("nominal", "nothing is wrong", lambda _: {}),
    Fault("fails-once", "its first activation has no effect", lambda _: {"dead_activations": 1}, ANY),
    Fault("fails", "its first activations have no effect", lambda n: {"dead_activations": int(n)}, ANY,
          Number("times", 1, 1000, whole=True)),
    Fault("never-confirms", "no activation has any effect", lambda _: {"dead_activations": NEVER}, ANY),
    Fault("stuck-release", "its feedback stays after the deactivation", lambda _: {"stuck": True}, ANY),
    Fault("leak", "it leaks: confirmed, but never secure", lambda q: {"leak_l_min": q}, (LEAKS,),
          Number("l_min", 0.1, 2000, default=4.0)),
    Fault("leak-grows", "its leak grows by so much in each second: weak, and lost in the end",
          lambda q: {"leak_grows_l_min_s": q}, (LEAKS,), Number("l_min_s", 0.01, 100, default=1.0)),
    Fault("lost-after", "what it holds is lost, so long after the activation",
          lambda s: {"lost_after_us": _micros(s)}, (ACTUATOR,), Number("seconds", 0.001, 86400)),
    Fault("invalid", "its pressure is marked as invalid", lambda _: {"invalid": True}, (PRESSURE,)),
    Fault("shows", "its sensor shows this gauge pressure, whatever is there", lambda p: {"shows_kpa": p}, (PRESSURE,),
          Number("kpa", -110, 800)),
    Fault("frozen-after", "its sensor stays at what it shows", lambda s: {"frozen_after_us": _micros(s)}, (PRESSURE,),
          Number("seconds", 0, 86400)),
    Fault("swapped", "its sensor is exchanged with the next actuator's", lambda _: {"swapped": True}, (PRESSURE,)),
    Fault("locked-shows", "its sensor of locked shows this bit, whatever is there",
          lambda b: {"locked_shows": bool(b)}, (CHANGER,), BIT),
    Fault("unlocked-shows", "its sensor of unlocked shows this bit, whatever is there",
          lambda b: {"unlocked_shows": bool(b)}, (CHANGER,), BIT),
    Fault("stand-shows", "the sensor of the tool's stand shows this bit, wherever the tool is",
          lambda b: {"stand_shows": bool(b)}, (CHANGER,), BIT),
    Fault("supply", "the air supply has this gauge pressure", lambda p: {"supply_kpa": p},
          number=Number("kpa", 0, 2000)),
    Fault("silent-after", "the link falls silent", lambda s: {"silent_after_us": _micros(s)},
          number=Number("seconds", 0, 86400)),
    Fault("babble-after", "the link carries random bytes only", lambda s: {"babble_after_us": _micros(s)},
          number=Number("seconds", 0, 86400)),
    Fault("reboot-after", "the device that sends restarts", lambda s: {"reboot_after_us": _micros(s)},
          number=Number("seconds", 0, 86400)),
    Fault("noise", "this share of the bytes on the link is changed", lambda r: {"noise": r}, number=RATE),
    Fault("flips", "this share of the bits on the link is turned over", lambda r: {"flips": r}, number=RATE),
    Fault("bursts", "of this share of the frames some bytes in a row are changed", lambda r: {"bursts": r},
          number=RATE),
    Fault("lost-bytes", "this share of the bytes on the link is lost", lambda r: {"dropped": r}, number=RATE),
    Fault("doubled-bytes", "this share of the bytes on the link comes twice", lambda r: {"doubled": r},
          number=RATE),
    Fault("no-tool", "no tool is present", lambda _: {"tool_present": False}),
    Fault("not-in-stand", "the tool is away from its stand", lambda _: {"in_stand": False}),
    Fault("estop-open", "the emergency stop is open", lambda _: {"estop_ok": False}),
)  # fmt: skip
