"""Every interlock at each door: how it is violated, and the sentence that refuses; or why that cannot be."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from end_effector_hal.vocabulary import ChangerState
from end_effector_hal.vocabulary import EndEffectorState as State
from tests.acceptance.interlocks.rig import BLOW_OFF, BOTTOM, CYLINDER, TOP, UNLOCK, Rig, refusal

INTERLOCKS = tuple(f"IL-{number:02}" for number in range(1, 14))
DOORS = ("action", "service", "socket")


class Cell(NamedTuple):
    """One of the table: ``said`` is a pattern of the sentence; without ``violate`` the reason why not."""

    interlock: str
    door: str
    said: str
    violate: Callable[[Rig], str] | None = None


CELLS: list[Cell] = []


def cell(interlock: str, door: str, said: str) -> Callable[[Callable[[Rig], str]], Callable[[Rig], str]]:
    def add(violate: Callable[[Rig], str]) -> Callable[[Rig], str]:
        CELLS.append(Cell(interlock, door, said, violate))
        return violate

    return add


def no(interlock: str, door: str, why: str) -> None:
    CELLS.append(Cell(interlock, door, why))


# IL-01: unlock only when nothing is gripped, held or unknown


@cell("IL-01", "action", r"^IL-01: unlock only in STAND_BY; the end-effector is GRIPPED")
def _(rig: Rig) -> str:
    rig.gripped()
    return rig.action("unlock")


@cell("IL-01", "service", r"^IL-01: Bottom vacuum is not active, but its feedback is not proven to be gone")
def _(rig: Rig) -> str:
    rig.odd["bottom"] = -30_000
    rig.until(lambda: rig.hal.status.evidence[0] == 2)
    said: list[str] = []  # without a frame for 150 ms the tool changer is UNKNOWN, which is said first
    rig.until(lambda: "IL-01" in (said.append(rig.service("tool_changer", True).reason) or said[-1]))
    return said[-1]


@cell(
    "IL-01", "socket", r"^IL-01: .*206 \(unlock\) is not activated: the sensors do not prove that nothing is"
)
def _(rig: Rig) -> str:
    rig.odd["top"] = -12_000
    with rig.hand(UNLOCK) as hand:
        rig.until(lambda: not hand.status()["told"]["nothing_gripped"]["holds"])
        return refusal(hand, UNLOCK)


# IL-02: unlock only with the tool in its stand or absent


@cell("IL-02", "action", r"^IL-02: the tool is not in its stand")
def _(rig: Rig) -> str:
    rig.show(in_stand=False)
    said: list[str] = []
    rig.until(lambda: "IL-02" in (said.append(rig.action("unlock")) or said[-1]))
    return said[-1]


@cell("IL-02", "service", r"^IL-02: the tool is not in its stand")
def _(rig: Rig) -> str:
    rig.show(in_stand=False)
    said: list[str] = []
    rig.until(lambda: "IL-02" in (said.append(rig.service("tool_changer", True).reason) or said[-1]))
    return said[-1]


@cell(
    "IL-02",
    "socket",
    r"^IL-02: SODIMM_206 \(unlock\) is not activated: the tool is neither in its stand nor absent",
)
def _(rig: Rig) -> str:
    rig.odd["in_stand"] = False
    with rig.hand(UNLOCK) as hand:
        rig.until(lambda: not hand.status()["told"]["parked"]["holds"])
        return refusal(hand, UNLOCK)


# IL-03: the unlock output is active for a limited time


@cell("IL-03", "action", r"^the program ended it: LOCKED$")
def _(rig: Rig) -> str:
    rig.until(
        lambda: rig.action("unlock") == ""
    )  # the sensors must have proven for a while that nothing is there
    rig.until(lambda: not rig.arbiter.levels()[UNLOCK])
    rig.until(lambda: rig.hal.status.changer == ChangerState.LOCKED)
    return f"the program ended it: {ChangerState(rig.hal.status.changer).name}"


@cell("IL-03", "service", r"^the program ended it: LOCKED$")
def _(rig: Rig) -> str:
    rig.until(lambda: rig.service("tool_changer", True).accepted)
    rig.until(lambda: not rig.arbiter.levels()[UNLOCK])
    rig.until(lambda: rig.hal.status.changer == ChangerState.LOCKED)
    return f"the program ended it: {ChangerState(rig.hal.status.changer).name}"


@cell("IL-03", "socket", r"^the arbiter ended SODIMM_206 by IL-03$")
def _(rig: Rig) -> str:
    with rig.hand(UNLOCK) as hand:
        hand.set({UNLOCK: True})
        rig.until(lambda: bool(hand.status()["trips"]))
        assert not hand.levels()[UNLOCK]
        (trip,) = hand.status()["trips"]
        return f"the arbiter ended {trip['line']} by {trip['interlock']}"


# IL-04: a lock is proven by its sensors; both bits or neither is a sensor fault

UNPROVEN = r"^The tool changer is \w+: its sensors do not prove LOCKED"
FAULT = r"IL-04: .*sensor fault"


def unlocked_by_itself(rig: Rig) -> None:
    rig.odd |= {"locked": False, "unlocked": True}
    rig.until(lambda: rig.hal.status.changer != ChangerState.LOCKED)


def no_bit(rig: Rig) -> None:
    rig.odd |= {"locked": False, "unlocked": False}
    rig.until(lambda: rig.hal.status.changer != ChangerState.LOCKED)


@cell("IL-04", "action", UNPROVEN)
def _(rig: Rig) -> str:
    unlocked_by_itself(rig)
    return rig.action("lock")


@cell("IL-04", "action", FAULT)
def _(rig: Rig) -> str:
    no_bit(rig)
    return rig.action("lock")


@cell("IL-04", "service", FAULT)
def _(rig: Rig) -> str:
    no_bit(rig)
    return rig.service("tool_changer", False).reason


no("IL-04", "socket", "the arbiter tells the levels of its lines and claims no lock")

# IL-05: no gripping unless the tool is locked


@cell("IL-05", "action", r"^IL-05: the tool is not proven to be locked")
def _(rig: Rig) -> str:
    rig.odd |= {"locked": False, "unlocked": True}
    rig.until(lambda: rig.hal.status.changer != ChangerState.LOCKED)
    return rig.action("grip")


@cell("IL-05", "service", r"^IL-05: the tool is not proven to be locked")
def _(rig: Rig) -> str:
    rig.odd |= {"locked": False, "unlocked": True}
    rig.until(lambda: rig.hal.status.changer != ChangerState.LOCKED)
    return rig.service("cylinder", True).reason


@cell(
    "IL-05",
    "socket",
    r"^IL-05: SODIMM_210 \(cylinder\) is not activated: the tool is not proven to be locked",
)
def _(rig: Rig) -> str:
    rig.odd |= {"locked": False, "unlocked": True}
    with rig.hand(CYLINDER) as hand:
        rig.until(lambda: not hand.status()["told"]["locked"]["holds"])
        return refusal(hand, CYLINDER)


# IL-06: supply pressure


@cell("IL-06", "action", r"^IL-06: the supply pressure is 390 kPa, a grip requires at least 400 kPa")
def _(rig: Rig) -> str:
    rig.show(supply=390_000)
    return rig.action("grip")


no("IL-06", "service", "refuses a new grip; maintenance drives one actuator and claims no grip")
no("IL-06", "socket", "refuses a new grip; a line is none")

# IL-07: no grip with the link down, a channel invalid, or feedback present


@cell("IL-07", "action", r"^IL-07: Top vacuum is not active, but its feedback is not proven to be gone")
def _(rig: Rig) -> str:
    rig.odd["top"] = -15_000
    rig.until(lambda: rig.hal.status.evidence[2] == 2)
    return rig.action("grip")


@cell("IL-07", "action", r"^IL-07: Top vacuum is not proven to be gone: top has no valid reading")
def _(rig: Rig) -> str:
    rig.odd["top"] = None
    rig.until(lambda: rig.hal.status.evidence[2] == 0)
    return rig.action("grip")


@cell("IL-07", "action", r"^IL-07: the sensor link none is not up")
def _(rig: Rig) -> str:
    rig.silent = True
    rig.until(lambda: not rig.hal.status.link_up)
    return rig.action("grip")


no(
    "IL-07",
    "service",
    "refuses a new grip; without a reading the service never succeeds, for no sensor proves it",
)
no("IL-07", "socket", "refuses a new grip; a line is none")

# IL-08: blow-off never together with suction

no("IL-08", "action", "a release that blows leaves the gap by itself: proven (blow-gap)")
no("IL-08", "service", "no service drives a blow-off valve")


@cell(
    "IL-08", "socket", r"^IL-08: SODIMM_214 \(blow-off of bottom_vacuum\) is not activated while SODIMM_208"
)
def _(rig: Rig) -> str:
    with rig.hand(BOTTOM, BLOW_OFF) as hand:
        hand.set({BOTTOM: True})
        return refusal(hand, BLOW_OFF)


@cell(
    "IL-08", "socket", r"^IL-08: SODIMM_208 \(bottom_vacuum\) is not activated while SODIMM_214 .* is active"
)
def _(rig: Rig) -> str:
    with rig.hand(BOTTOM, BLOW_OFF) as hand:
        hand.set({BLOW_OFF: True})
        return refusal(hand, BOTTOM)


# IL-09: only a Drop releases what is held


@cell("IL-09", "action", r"^There is no running grip to cancel; the end-effector is GRIPPED")
def _(rig: Rig) -> str:
    rig.gripped()
    return rig.action("cancel")


@cell(
    "IL-09",
    "service",
    r"^IL-12: a part is held \(GRIPPED\): no maintenance, only a Drop releases it",
)
def _(rig: Rig) -> str:
    rig.gripped()
    return rig.service("bottom_vacuum", False).reason


@cell("IL-09", "socket", r"^SODIMM_208 belongs to hal \(pid ")
def _(rig: Rig) -> str:
    rig.gripped()
    try:
        with rig.hand(BOTTOM) as hand:
            hand.set({BOTTOM: False})
    except OSError as error:
        assert rig.arbiter.levels()[BOTTOM]
        return str(error)
    raise AssertionError("it was dropped")


# IL-10: a valve is on or off for at least 50 ms


@cell("IL-10", "action", r"^0 intervals under 50 ms$")
def _(rig: Rig) -> str:
    from end_effector_hal.wires.lines import ChipWatcher, Edge

    edges: list[Edge] = []
    with ChipWatcher(rig.chip, edges.append):
        assert rig.hal.command("grip").accepted
        rig.until(lambda: rig.hal.command("cancel").accepted)
        rig.until(lambda: rig.hal.status.ee == State.STAND_BY and len(edges) >= 2)
    pairs = zip(
        [e.at for e in edges if e.line == BOTTOM], [e.at for e in edges if e.line == BOTTOM][1:], strict=False
    )
    return f"{sum(after - before < 50_000 for before, after in pairs)} intervals under 50 ms"


no(
    "IL-10",
    "service",
    "waits for the sensor of one switching before the next is asked for; the arbiter sees to it anyhow",
)


@cell("IL-10", "socket", r"^waits [1-9]\d* µs$")
def _(rig: Rig) -> str:
    with rig.hand(CYLINDER) as hand:
        hand.set({CYLINDER: True})
        return f"waits {hand.set({CYLINDER: False}).delay_us} µs"


# IL-11: nothing is activated automatically


@cell("IL-11", "action", r"^0 activations after a restart$")
def _(rig: Rig) -> str:
    rig.gripped()
    rig.odd |= {"bottom": 0, "top": 0}
    rig.until(lambda: rig.hal.status.ee == State.GRIP_ERROR)
    before = rig.arbiter.levels()
    rig.hal.close()
    rig.start()
    rig.until(lambda: rig.hal.status.ee != State.OFF)
    rig.hal.close()
    after = rig.arbiter.levels()
    return f"{sum(after[line] and not before[line] for line in after)} activations after a restart"


no("IL-11", "service", "a service activates what it is asked for, and nothing else")


@cell(
    "IL-11",
    "socket",
    r"^IL-11: step 0 of the last will would activate SODIMM_208; a last will only deactivates",
)
def _(rig: Rig) -> str:
    with rig.hand(BOTTOM) as hand:
        return refusal(hand, BOTTOM, will=[{"line": BOTTOM, "level": True}])


# IL-12: the services work in maintenance only


@cell("IL-12", "action", r"^IL-12: .*maintenance.*Cylinder")
def _(rig: Rig) -> str:
    assert rig.service("cylinder", True).accepted
    return rig.action("grip")


@cell("IL-12", "service", r"^IL-12: maintenance is possible in STAND_BY only; the end-effector is GRIPPING")
def _(rig: Rig) -> str:
    rig.odd["bottom"] = 0  # it stays in the first step
    assert rig.hal.command("grip").accepted
    return rig.service("cylinder", True).reason


@cell("IL-12", "service", r"^IL-12: a part is held \(GRIPPED\)")
def _(rig: Rig) -> str:
    rig.gripped()
    return rig.service("cylinder", False).reason


no("IL-12", "socket", "maintenance is a mode of the program; at the socket each line has one writer")

# IL-13: an open e-stop


def open_e_stop(rig: Rig) -> None:
    rig.odd["estop_ok"] = False
    rig.until(lambda: "e_stop_closed" in rig.faults())
    # at the socket there is no program
    rig.until(lambda: not rig.program or "IL-13" in " ".join(rig.hal.status.alarm_texts))


@cell("IL-13", "action", r"^IL-13: the emergency stop was opened\. Nothing is activated")
def _(rig: Rig) -> str:
    open_e_stop(rig)
    return rig.action("grip")


@cell("IL-13", "action", r"^IL-13: the emergency stop was opened\. Nothing is activated")
def _(rig: Rig) -> str:
    open_e_stop(rig)
    said: list[str] = []
    rig.until(lambda: "IL-13" in (said.append(rig.action("unlock")) or said[-1]))
    return said[-1]


@cell("IL-13", "service", r"^IL-13: the emergency stop was opened\. Nothing is activated")
def _(rig: Rig) -> str:
    open_e_stop(rig)
    return rig.service("cylinder", True).reason


@cell("IL-13", "socket", r"^IL-13: SODIMM_212 .* the emergency stop was opened; reset the faults first")
def _(rig: Rig) -> str:
    open_e_stop(rig)
    del rig.odd["estop_ok"]
    with rig.hand(TOP) as hand:
        rig.until(lambda: hand.status()["told"]["e_stop_closed"]["holds"])
        return refusal(hand, TOP)
