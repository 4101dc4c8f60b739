"""Rules for outputs that are registers of a device: values that are possible but make no sense."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from end_effector_hal.description._fault import Fault, Keys, did_you_mean
from end_effector_hal.description._numbers import number
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model._description import Description
from end_effector_hal.kinds.stanza import lowest_bit

from ._channels import CodecChannels
from ._frames import link_of, unit_faults

CODE = "EE-229"


def output_faults(facts: Facts) -> Iterator[Fault]:
    """Yield every fault of an output on the bus."""
    taken: dict[tuple[str | None, int, str, int, int], str] = {}
    for output in facts.outputs():
        path: Keys = (*output, "modbus")
        if not facts.written(*path) or not isinstance(facts.get(*path), dict):
            continue
        yield from _one_output(facts, output)
        yield from unit_faults(facts, _bus_of(facts, path), path)
        yield from _commands(facts, path)
        yield from _activation(facts, output)
        yield from _keeps_alive(facts, path)
        for key in (("verify",), ("activation", "ready"), ("handshake", "taken")):
            yield from _channel(facts, (*path, *key))
        yield from _told_twice(facts, path)
        yield from _masked(facts, path)
        yield from _pulsed(facts, path)
        yield from _pair(facts, path)
        yield from _shared(facts, output, taken)


def _one_output(facts: Facts, output: Keys) -> Iterator[Fault]:
    for key, expected in (
        ("line", "one output: a line, or registers"),
        ("opposite", "modbus: {opposite: {address: …}}"),
    ):
        yield from _excluded(facts, output, (key,), "modbus", expected)
    if any(path[:1] in (("link",), ("links",)) for path in facts.broken):
        return
    buses, path = _buses(facts), (*output, "modbus", "link")
    if not buses:
        expected = "link: {port: …, frame: {modbus: {}}}"
        yield facts.key_fault(path[:-1], CODE, "registers need a Modbus link", expected)
        return
    link, known = facts.get(*path), [str(each[-1]) for each in buses]
    if path in facts.broken:
        return
    if link is None and len(buses) > 1:
        expected = f"link: {' or '.join(known)}"
        yield facts.key_fault(path[:-1], "EE-206", "the bus is missing", expected, found="")
    elif link is not None and buses == [("link",)]:
        yield facts.fault(path, CODE, "there is one link, and it has no name", "no link")
    elif link is not None and ("links", link) not in buses:
        hint = did_you_mean(str(link), known)
        yield facts.fault(path, CODE, "there is no such Modbus link", f"one of {', '.join(known)}", hint=hint)


def _excluded(
    facts: Facts, path: Keys, keys: tuple[str, ...], by: str, expected: str, found: str = ""
) -> Iterator[Fault]:
    """Yield a fault for each written key that another key of the output excludes; ``found``: the other one's."""
    for key in keys:
        if facts.written(*path, key) and facts.get(*path, key) is not None:
            what = (
                f"{by!r} and {key!r} exclude each other"
                if found
                else f"{key!r} and {by!r} exclude each other"
            )
            yield facts.key_fault((*path, found or key), CODE, what, expected)


def _buses(facts: Facts) -> list[Keys]:
    """Return the keys of each Modbus link."""
    links: list[Keys] = [("links", each) for each in facts.names("links")] or [("link",)]
    return [path for path in links if (facts.get(*path, "frame") or {}).get("modbus") is not None]


def _bus_of(facts: Facts, output: Keys) -> Keys | None:
    """Return the keys of the link that an output is on; None: it is not known."""
    buses, link = _buses(facts), facts.get(*output, "link")
    named = [path for path in buses if link is None or path == ("links", link)]
    return named[0] if len(named) == 1 else None


def _registers(
    facts: Facts, path: Keys, row: Sequence[int], start: int | None, *, coils: bool
) -> Iterator[Fault]:
    """Check values that are written to registers from ``start`` on, or to coils."""
    if coils and set(row) - {0, 1}:
        yield facts.fault(path, "EE-208", "a coil is 0 or 1", "[0] or [1]")
    if start is not None and start + len(row) > 0x10000:
        what = "the last of these registers does not exist"
        yield facts.fault(path, "EE-208", what, "less than 65536 with address")


def _commands(facts: Facts, path: Keys) -> Iterator[Fault]:
    on, off = facts.get(*path, "command_on"), facts.get(*path, "command_off")
    coils = facts.get(*path, "register_type") == "coil"
    rows: list[tuple[Keys, list[int]]] = [
        ((*path, key), row) for key, row in (("command_on", on), ("command_off", off)) if row
    ]
    for several in ((*path, "activation", "write"), (*path, "acknowledge")):
        rows += [((*several, index), row) for index, row in enumerate(facts.get(*several) or ())]
    address, activated = facts.get(*path, "address"), facts.get(*path, "activation", "address")
    for key in ("command_on", "command_off", "activation", "acknowledge"):
        where = (*path, key, *(("write",) if key == "activation" else ()))
        given = facts.get(*where)
        if given is not None and (len(given) == 0 or [] in [*given]):
            yield facts.fault(where, "EE-211", f"{where[-1]!r} is empty", "at least one register")
    for where, row in rows:
        if facts.broken_within(*where):
            continue
        start = activated if "activation" in where and activated is not None else address
        yield from _registers(facts, where, row, start, coils=coils)
        if "acknowledge" in where and on and row[: len(on)] == on:
            what = "a reset would make it grip"
            yield facts.fault(where, CODE, what, "rows that begin otherwise than 'command_on'")
    yield from _handshake(facts, path, coils=coils)
    seen = facts.says(*path, "verify") or facts.get("tool_changer", "latching")
    if path[0] == "tool_changer" and not seen:
        what = "the line arbiter cannot see whether the unlock output is active"
        expected = "verify: a channel that reads it back (IL-03), or latching: true"
        yield facts.key_fault(path, "EE-206", what, expected, found="")
    if on and off and not any(facts.broken_within(*each) for each, _ in rows):
        yield from _differ(facts, path, "command_on", "command_off", "what makes it release")


def _differ(facts: Facts, path: Keys, first: str, second: str, expected: str) -> Iterator[Fault]:
    """Check that two rows are different values of the same registers."""
    row, other = facts.get(*path, first), facts.get(*path, second)
    if len(row) != len(other):
        what = f"{second!r} does not write what {first!r} writes"
        yield facts.fault((*path, second), CODE, what, f"{len(row)} values")
    elif row == other:
        yield facts.fault((*path, second), CODE, f"{first!r} and {second!r} are the same", expected)


def _handshake(facts: Facts, path: Keys, *, coils: bool) -> Iterator[Fault]:
    """Check that `request` and `end` are two different values of the same registers."""
    keys = (*path, "handshake")
    if not facts.written(*keys) or facts.broken_within(*keys):
        return
    request, end, own = (facts.get(*keys, key) for key in ("request", "end", "address"))
    command, on = facts.get(*path, "address"), facts.get(*path, "command_on")
    address = command if own is None else own
    for key, row in (("request", request), ("end", end)):
        if row:
            yield from islice(_registers(facts, (*keys, key), row, address, coils=coils), 1)
        else:
            yield facts.fault((*keys, key), "EE-211", f"{key!r} is empty", "at least one register")
    if request and end:
        yield from _differ(facts, keys, "request", "end", "what ends the handshake")
    if facts.get(*keys, "order") == "after" and request and on and None not in (address, command):
        apart = address + len(request) <= command or command + len(on) <= address
        if not apart and not (address == command and len(request) >= len(on)):
            what = "the handshake overwrites a part of the command"
            expected = "an address of its own, or the whole command with it"
            yield facts.fault((*keys, "request"), CODE, what, expected)


LIMITS = {"actuators": ("timeout_s", "release_s"), "tool_changer": ("prove_s", "prove_s")}
"""Keys of the time limits for proving that an output became active, and inactive."""


def _activation(facts: Facts, output: Keys) -> Iterator[Fault]:
    """Check that an attempt outlasts its activation and handshakes, and a release its handshake."""
    if output[-1] != "tool_changer" and output[:-1] != ("actuators",):
        return  # no sensor proves it
    name, (on, off) = output[-1], LIMITS[str(output[0])]
    path, shakes = (*output, "modbus", "activation"), (*output, "modbus", "handshake", "within_s")
    limit_s, whole_s = facts.get(*path, "ready_within_s"), facts.get(*output, on)
    if facts.written(*path) and limit_s is not None and whole_s is not None and limit_s >= whole_s:
        what = "the attempt is over before the device is activated"
        expected = f"less than {on} of {name} = {number(whole_s)}"
        yield facts.fault((*path, "ready_within_s"), "EE-222", what, expected)
        return
    shake_s = facts.get(*shakes) if facts.written(*shakes[:-1]) and shakes not in facts.broken else None
    if shake_s is None:
        return
    activated_s = limit_s if facts.written(*path) and limit_s is not None else 0
    for key, most_s in ((on, activated_s + shake_s * (2 if activated_s else 1)), (off, shake_s)):
        whole_s = facts.get(*output, key)
        if whole_s is not None and most_s >= whole_s:
            expected = f"less than {key} of {name} = {number(whole_s)}"
            if most_s != shake_s:
                expected += f": twice, and ready_within_s = {number(activated_s)}"
            yield facts.fault(shakes, "EE-222", "the handshake may last too long", expected)
            return


def _told_twice(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Check that `ready` and `verify` differ: an active, open device has `ready` on and `verify` off."""
    ready, verify = (*path, "activation", "ready"), facts.get(*path, "verify")
    if facts.written(*ready) and verify is not None and facts.get(*ready) == verify:
        expected = "the bit of an active device, open or closed"
        yield facts.fault(ready, CODE, "'ready' and 'verify' are the same", expected)


def _keeps_alive(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Check that a device with `keep_alive_ms` is read: the reads keep it alive."""
    unit, bus = facts.get(*path, "unit"), _bus_of(facts, path)
    over = [name for name in facts.names("channels") if bus is None or link_of(facts, name) == bus]
    read = [facts.get("channels", name, "modbus", "unit") for name in over]
    if facts.get(*path, "keep_alive_ms") is not None and unit is not None and unit not in read:
        expected = f"a channel: {{modbus: {{unit: {unit}, address: …}}}}"
        yield facts.fault((*path, "keep_alive_ms"), CODE, f"nothing is read from unit {unit}", expected)


def _channel(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Check that a key names a bit that is read over the same bus: its master reads nothing else."""
    channel = facts.get(*path) if facts.written(*path) else None
    if channel is None or path in facts.broken:
        return
    bus = _bus_of(facts, path[: path.index("modbus") + 1])
    channels = [
        name
        for name in facts.names("channels")
        if facts.get("channels", name, "modbus") is not None
        and facts.get("channels", name, "unit") is None
        and (bus is None or link_of(facts, name) == bus)
    ]
    if channel not in channels:
        expected = f"one of {', '.join(channels)}" if channels else "a channel: {modbus: …} without unit"
        what = f"{path[-1]!r} names no bit that is read over the bus"
        yield facts.fault(path, CODE, what, expected, hint=did_you_mean(channel, channels))


STEPS = ("activation", "handshake", "acknowledge")
"""Keys of commands with several steps."""


def _masked(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Check an output that is a part of a register."""
    bitmask, at = facts.get(*path, "bitmask"), (*path, "bitmask")
    alone = facts.get(*path, "use_mask_write") is True
    if bitmask is None:
        if alone and at not in facts.broken:
            what = "function 22 writes bits of a register"
            yield facts.key_fault((*path, "use_mask_write"), CODE, what, "bitmask: the bits of this output")
        return
    if facts.get(*path, "register_type") == "coil":
        yield facts.key_fault(at, CODE, "a coil has no bits", "register_type: holding")
    yield from _excluded(facts, path, STEPS, "bitmask", "whole registers, or one command", "bitmask")
    if not alone and not facts.says(*path, "verify"):
        what = "its neighbours in the register cannot be written"
        expected = "verify: a channel that reads it back, or use_mask_write: true"
        yield facts.key_fault(at, "EE-206", what, expected, found="")
    others = [(*each, "modbus") for each in facts.outputs() if facts.get(*each, "modbus", "bitmask")]
    same = ("link", "unit", "address")
    mates = [each for each in others if all(facts.get(*path, key) == facts.get(*each, key) for key in same)]
    if alone and not all(facts.get(*each, "use_mask_write") for each in mates):
        what = "another output of this register does without it"
        yield facts.key_fault((*path, "use_mask_write"), CODE, what, "it in all of them, or in none")
    highest = bitmask >> lowest_bit(bitmask)
    for key in ("command_on", "command_off"):
        row = facts.get(*path, key)
        if row and not facts.broken_within(*path, key) and (len(row) > 1 or row[0] & ~highest):
            expected = f"one value of at most {highest}"
            yield facts.fault((*path, key), "EE-208", "this is no value of the bits", expected)


def _pulsed(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Check an output whose commands are pulses: zeros end them, and nothing of it can be read back."""
    if not facts.written(*path, "pulse_s") or facts.get(*path, "pulse_s") is None:
        return
    keys = ("verify", *(() if facts.get(*path, "use_mask_write") else ("bitmask",)), *STEPS)
    yield from _excluded(facts, path, keys, "pulse_s", "coils or registers that are pulsed only")
    for key in ("command_on", "command_off"):
        row = facts.get(*path, key)
        neighbours = facts.get(*path, "opposite") is None
        if neighbours and row and not facts.broken_within(*path, key) and not any(row):
            expected = "a value that is not zero, such as [1, 0] and [0, 1]"
            yield facts.fault((*path, key), CODE, f"{key!r} is the end of a pulse", expected)


def _pair(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Check a valve with two coils that are no neighbours: each is written alone."""
    own, row, at = facts.get(*path, "address"), facts.get(*path, "command_on"), (*path, "opposite")
    second, mask = facts.get(*at, "address"), facts.get(*at, "bitmask")
    if facts.get(*at) is None or None in (own, second) or not row:
        return
    yield from _excluded(facts, path, STEPS, "opposite", "two coils that are only switched", "opposite")
    if abs(own - second) < len(row):
        what, expected = "the second coil is in the registers of the first", "another address, or "
        expected += "one output with both coils: bitmask, command_on: [1] and command_off: [2]"
        yield facts.key_fault(at, CODE, what, expected)
    else:
        yield from _registers(facts, (*at, "address"), row, second, coils=False)
    values = [*row, *(facts.get(*path, "command_off") or ())]
    if mask is not None and any(value & ~(mask >> lowest_bit(mask)) for value in values):
        expected = "bits of the second coil, as many as `bitmask` of the output has"
        yield facts.fault((*at, "bitmask"), CODE, "the commands do not fit into these bits", expected)
    whole, alone = facts.get(*path, "bitmask") is None, facts.get(*path, "use_mask_write") is True
    if whole is not (mask is None) or (not whole and not alone):
        what = "bits of two registers are written with function 22 only"
        expected = "both bitmask with use_mask_write: true, or no bitmask: coils, or whole registers"
        yield facts.key_fault(at, CODE, what, expected)


def _shared(
    facts: Facts, output: Keys, taken: dict[tuple[str | None, int, str, int, int], str]
) -> Iterator[Fault]:
    path, name = (*output, "modbus"), ".".join(map(str, output[output[0] in ("actuators", "outputs") :]))
    unit, table = facts.get(*path, "unit"), facts.get(*path, "register_type")
    address, row = facts.get(*path, "address"), facts.get(*path, "command_on")
    if None in (unit, table, address) or not row or facts.broken_within(*path):
        return
    registers = [address + index for index in range(len(row))]
    if (request := facts.get(*path, "handshake", "request")) and not facts.broken_within(*path, "handshake"):
        own = facts.get(*path, "handshake", "address")
        registers += [(address if own is None else own) + index for index in range(len(request))]
    written = [(registers, facts.get(*path, "bitmask"))]
    if (second := facts.get(*path, "opposite", "address")) is not None:
        written.append(
            ([second + index for index in range(len(row))], facts.get(*path, "opposite", "bitmask"))
        )
    mine = [
        (facts.get(*path, "link"), unit, table, register, bit)
        for rows, mask in written
        for register in rows
        for bit in range(16)
        if (mask or 0xFFFF) >> bit & 1
    ]
    if owner := next((taken[each] for each in mine if each in taken), None):
        what = f"these registers already belong to {owner!r}"
        yield facts.fault((*path, "address"), "EE-221", what, "registers of its own")
    taken |= {each: taken.get(each, name) for each in mine}


def lost_by_silence(description: Description, codec: CodecChannels) -> Iterator[str]:
    """Yield a sentence for each held part that falls, or may fall, without power or messages.

    Also yield one for each bus that is too slow to keep a device alive.
    """
    period_ms = codec.period_us / 1000
    yield from _outlasts(description)
    for name, actuator in description.ordered:
        output = actuator.modbus
        if output is not None and output.keep_alive_ms is not None and output.keep_alive_ms < 2 * period_ms:
            yield (
                f"{name}: keep_alive_ms = {output.keep_alive_ms}, and the bus is read each "
                f"{number(period_ms)} ms: after one lost answer the device counts the link as lost"
            )
        if output is not None:
            when = f" for {output.keep_alive_ms} ms" if output.keep_alive_ms else ""
            silent = f"when the bus or the line arbiter is silent{when}"
            yield from _falls(name, "on_link_loss", output.on_link_loss, silent)
        # of a valve on a line it is asked for only where it is written: what it does is known from its wiring
        if output is not None or "on_power_loss" in actuator.model_fields_set:
            yield from _falls(name, "on_power_loss", actuator.on_power_loss, "without power")


def _outlasts(description: Description) -> Iterator[str]:
    """Yield a sentence for each output with a longest time that its device may keep active without the bus."""
    changer, blown = description.tool_changer, {each.line for each in description.blow_offs.values()}
    limited = {} if changer is None or changer.latching else {changer.line: "tool_changer: the unlock output"}
    limited |= {
        line: f"{name}: blow_off: it" for name, line in description.blow_off_lines.items() if line in blown
    }
    for line, what in limited.items():
        output = description.register_outputs.get(line)
        if output is not None and output.on_link_loss != "release":
            interlock = "IL-03" if changer is not None and line == changer.line else "IL-08"
            yield (
                f"{what} may stay active for longer than its longest time ({interlock}) while the bus is lost: "
                f"on_link_loss: {output.on_link_loss}"
            )


def _falls(name: str, key: str, what: str, when: str) -> Iterator[str]:
    if what == "release":
        yield f"{name}: a held part falls {when} ({key}: release)"
    elif what == "undefined":
        yield f"{name}: the description does not say whether a held part falls {when} ({key}: undefined)"
