"""Rules between stanzas: the sequence, names, endings, files, the size of a tool, and the order of numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from end_effector_hal.description._fault import Fault, Keys, closest, did_you_mean
from end_effector_hal.description._numbers import number
from end_effector_hal.description._shape import Facts
from end_effector_hal.kinds import JointRule, Pair, get_kind
from end_effector_hal.vocabulary import MOST_ACTUATORS, MOST_CHANNELS

# Columns of states.csv, and the tool changer's place among the devices.
RESERVED = ("time_s", "end_effector", "command", "tool_changer")
# struct sockaddr_un holds 108 bytes with the final zero.
SOCKET_BYTES = 107


def rule_faults(facts: Facts) -> Iterator[Fault]:
    """Yield every fault between stanzas."""
    if isinstance(facts.tree.get("actuators"), dict):
        yield from _names(facts, "sequence")
        yield from _unused(facts)
        yield from _names(facts, "release_order")
        yield from _unreleased(facts)
    yield from _unread(facts)
    yield from _board_units(facts)
    yield from _reserved(facts)
    yield from _pulses(facts)
    yield from _blow_offs(facts)
    yield from _endings(facts)
    yield from _files(facts)


def _unread(facts: Facts) -> Iterator[Fault]:
    """Check that the description declares a source of readings."""
    if facts.written("link"):
        if facts.get("link") is None and not facts.names("channels") and ("link",) not in facts.broken:
            yield facts.fault(("link",), "EE-207", "'link' has no value", "keys with values", found="")
        return
    if facts.written("channels") or facts.written("links"):
        return
    expected = "link: the sensor link, or channels: inputs of the board"
    yield Fault.at(facts.places.key(), "EE-206", "key 'link' is missing", found="", expected=expected)


def _board_units(facts: Facts) -> Iterator[Fault]:
    """Check that an analog input has a unit and a digital input, which is a bit, has none."""
    for name in facts.names("channels"):
        keys = ("channels", name)
        if _given(facts, *keys, "analog") and not facts.written(*keys, "unit"):
            what = f"key 'unit' is missing in channel {name!r}"
            yield facts.key_fault((*keys, "analog"), "EE-206", what, "unit: kPa, bar, ...", hint="see scale")
        if _given(facts, *keys, "digital") and _given(facts, *keys, "unit"):
            expected = "no unit: it is a bit"
            yield facts.fault((*keys, "unit"), "EE-205", f"channel {name!r} is a digital input", expected)


def _given(facts: Facts, *path: str) -> bool:
    return facts.written(*path) and facts.get(*path) is not None


def _pulses(facts: Facts) -> Iterator[Fault]:
    """Check that a pulse and its pause are over before the output is to change again."""
    stanzas: list[tuple[Keys, tuple[str, ...]]] = [(("tool_changer",), ("unlock_max_s", "prove_s"))]
    stanzas += [(("actuators", name), ("timeout_s", "reset_s", "release_s")) for name, _ in facts.actuators()]
    for stanza, output, keys in (
        (stanza, output, keys) for stanza, keys in stanzas for output in ("opposite", "modbus")
    ):
        path, pause = (*stanza, output, "pulse_s"), (*stanza, output, "pause_s")
        pulse_s = facts.get(*path) if facts.written(*path) else None
        pause_s = facts.get(*pause) if facts.written(*pause) else None
        if not isinstance(pulse_s, int | float):
            if isinstance(pause_s, int | float) and path not in facts.broken:
                expected = "pulse_s, how long each coil is active"
                yield facts.fault(pause, "EE-222", "there is no pulse before this pause", expected)
            continue
        rest_s = pause_s if isinstance(pause_s, int | float) else 0
        place, name = (pause, "the pause after the pulse") if rest_s else (path, "the pulse")
        for key in keys:
            limit_s = facts.get(*stanza, key)
            if isinstance(limit_s, int | float) and pulse_s + rest_s >= limit_s:
                what = f"{name} is not over when its output may change again"
                with_pulse = f", with pulse_s = {pulse_s:g}" if rest_s else ""
                yield facts.fault(place, "EE-222", what, f"less than {key} = {limit_s:g}{with_pulse}")


def _blow_offs(facts: Facts) -> Iterator[Fault]:
    """Check that `until_gone` is only set for a blow-off with `duration_s`, which a release drives."""
    for name, kind in facts.actuators():
        opposing = get_kind(kind).opposing
        path = ("actuators", name, opposing)
        if not opposing or not _given(facts, *path) or not facts.get(*path, "until_gone"):
            continue
        if facts.get(*path, "duration_s") is None and (*path, "duration_s") not in facts.broken:
            what = f"nothing drives the {opposing} of {name!r}"
            yield facts.fault(
                (*path, "until_gone"), "EE-222", what, "duration_s, how long it lasts at the most"
            )


def _names(facts: Facts, key: str) -> Iterator[Fault]:
    """Yield a fault for each name that is no actuator's, or is repeated."""
    known, seen = facts.names("actuators"), set()
    for index, name in enumerate(facts.names(key)):
        place = facts.places.value(key, index)
        if (key, index) in facts.broken:
            continue
        if name in seen:
            yield Fault.at(place, "EE-220", f"actuator {name!r} is repeated in {key}", expected="it once")
        elif name not in known:
            expected = f"one of {', '.join(known)}" if known else "a name under actuators"
            plain = (
                name in facts.names("outputs")
                and "a plain output stands under outputs only: no step drives it"
            )
            hint = plain or did_you_mean(name, known)
            yield Fault.at(place, "EE-220", f"{key} names no actuator", expected=expected, hint=hint)
        seen.add(name)


def _absent(facts: Facts, key: str) -> list[str]:
    """Return the actuators that a list leaves out, except those that a misspelt name in the list means."""
    known, listed = facts.names("actuators"), facts.names(key)
    meant = {closest(name, known) for name in listed if name not in known}
    return [name for name in known if name not in listed and name not in meant]


def _unused(facts: Facts) -> Iterator[Fault]:
    for name in _absent(facts, "sequence") if facts.names("sequence") else ():
        yield facts.key_fault(
            ("actuators", name), "EE-220", f"actuator {name!r} is never used", "it in the sequence"
        )


def _unreleased(facts: Facts) -> Iterator[Fault]:
    if facts.get("release_order") is None:
        return
    missing = [name for name in _absent(facts, "release_order") if name in facts.names("sequence")]
    if missing:
        what = f"{', '.join(missing)} would never be released"
        yield facts.fault(("release_order",), "EE-220", what, "every actuator of the sequence, once")


def _reserved(facts: Facts) -> Iterator[Fault]:
    for name in facts.names("actuators"):
        if name in RESERVED:
            yield facts.key_fault(
                ("actuators", name), "EE-211", "this name means something else in a recording", "another name"
            )


def _endings(facts: Facts) -> Iterator[Fault]:
    """Check for the whole tool and each actuator that nothing but a Drop releases a held part (IL-09)."""
    if facts.get("interlocks", "IL-09") is not True:
        return
    why = "IL-09 lets only a Drop release a held part; interlocks: {IL-09: false} switches it off"
    stanzas: list[Keys] = [("endings",)]
    stanzas += [("actuators", name, "endings") for name, _ in facts.actuators()]
    for stanza in stanzas:
        for path in (
            *((*stanza, "held", key) for key in ("lost", "sigterm", "process_death")),
            (*stanza, "power_up"),
        ):
            if facts.get(*path) == "release":
                yield facts.fault(path, "EE-223", f"{path[-1]!r} would drop a held part", "hold", hint=why)


def _files(facts: Facts) -> Iterator[Fault]:
    """Check that a named file exists, and that a socket's path is short enough.

    The default file may be the shipped one.
    """
    named, folder = facts.get("automata", "file"), facts.places.file.parent
    if facts.written("automata", "file") and named and ("\0" in named or not (folder / named).is_file()):
        expected = f"a UPPAAL file, relative to {folder}"
        yield facts.fault(("automata", "file"), "EE-224", "there is no such file", expected)
    socket = facts.get("lines", "socket")
    if socket and len(socket.encode()) > SOCKET_BYTES:
        expected = f"a path of at most {SOCKET_BYTES} bytes"
        yield facts.fault(("lines", "socket"), "EE-211", "'socket' is too long", expected)
    path_wanted = facts.get("lines", "backend") == "virtual" and ("lines", "path") not in facts.broken
    if path_wanted and not facts.get("lines", "path"):
        expected = "path: the file that is the virtual chip"
        yield facts.fault(("lines", "backend"), "EE-206", "key 'path' is missing in 'lines'", expected)


MOST = {"actuators": MOST_ACTUATORS, "outputs": MOST_ACTUATORS, "channels": MOST_CHANNELS}


def limit_faults(facts: Facts) -> Iterator[Fault]:
    """Yield a fault for each stanza with more names than a tool may have."""
    for stanza, most in MOST.items():
        names = facts.names(stanza) if isinstance(facts.get(stanza), dict) else []
        if len(names) > most:
            what = f"too many {stanza}"
            yield facts.key_fault((stanza,), "EE-208", what, f"at most {most}", found=str(len(names)))


SUPPLY: tuple[Pair, ...] = (("refuse_kpa", "<", "warn_kpa"), ("warn_kpa", "<", "nominal_kpa"))
LINK: tuple[Pair, ...] = (("stale_s", "<", "down_s"), ("stale_periods", "<", "down_periods"))
CHANGER: tuple[Pair, ...] = (("proven_s", "<", "prove_s"),)


def order_faults(facts: Facts) -> Iterator[Fault]:
    """Yield a fault for every pair of numbers in the wrong order."""
    yield from _pairs(facts, ("supply",), SUPPLY)
    yield from _pairs(facts, ("link",), LINK)
    if isinstance(facts.get("tool_changer"), dict):
        yield from _pairs(facts, ("tool_changer",), CHANGER)
    for name, kind in facts.actuators():
        yield from _pairs(facts, ("actuators", name), get_kind(kind).orders)
        for rule in get_kind(kind).joint_rules:
            yield from _joint(facts, name, rule)
    yield from _supply_returns(facts)


def _pairs(facts: Facts, stanza: Keys, pairs: tuple[Pair, ...]) -> Iterator[Fault]:
    for low, relation, high in pairs:
        less, more = facts.get(*stanza, low), facts.get(*stanza, high)
        if less is None or more is None or less < more or (relation == "<=" and less == more):
            continue
        # The one that is written is at fault; of two, the one that ought to be the higher.
        if facts.written(*stanza, high):
            key, size, words, other = high, "small", "more than" if relation == "<" else "at least", low
        else:
            key, size, words, other = low, "large", "less than" if relation == "<" else "at most", high
        expected = f"{words} {_quote(facts, *stanza, other)}"
        yield facts.fault((*stanza, key), "EE-222", f"{key!r} is too {size}", expected)


def _joint(facts: Facts, name: str, rule: JointRule) -> Iterator[Fault]:
    paths: dict[str, Keys] = {
        key: ("supply", key.removeprefix("supply."))
        if key.startswith("supply.")
        else ("actuators", name, key)
        for key in rule.keys
    }
    numbers = {key: facts.get(*path) for key, path in paths.items()}
    if None in numbers.values():
        return
    if found := rule.fault(name, numbers, lambda key: _quote(facts, *paths[key])):
        yield _of_several(facts, list(paths.values()), *found)


def _supply_returns(facts: Facts) -> Iterator[Fault]:
    """Check that after a refusal the nominal pressure is enough to grip again."""
    keys = ("hysteresis_kpa", "refuse_kpa", "nominal_kpa", "warn_kpa")
    paths = [("supply", key) for key in keys]
    hysteresis, refuse, nominal, warn = (facts.get(*path) for path in paths)
    # If the three are not in order anyhow, that is the fault.
    if None in (hysteresis, refuse, nominal, warn) or not refuse < warn < nominal:
        return
    if nominal <= refuse + hysteresis:
        expected = (
            f"refuse_kpa + hysteresis_kpa = {number(refuse + hysteresis)} below {_quote(facts, *paths[2])}"
        )
        yield _of_several(facts, paths, "a grip, once refused, would never be granted again", expected)


def _of_several(facts: Facts, paths: Sequence[Keys], what: str, expected: str) -> Fault:
    """Return a fault of several numbers together, at the place of the first one that is written."""
    path = next((each for each in paths if facts.written(*each)), paths[0])
    place = facts.places.value(*path)
    return Fault.at(place, "EE-222", what, found=f"{path[-1]}: {place.text}", expected=expected)


def _quote(facts: Facts, *path: str | int) -> str:
    default = "" if facts.written(*path) else " (default)"
    return f"{path[-1]} = {number(facts.get(*path))}{default}"
