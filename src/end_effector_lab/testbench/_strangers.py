"""What others do on a bus: a second client that writes, and another device that answers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from end_effector_hal.kinds.stanza import RegisterOutput

from .devices import RemoteIo, read_request, sealed


def releases(outputs: Iterable[RegisterOutput]) -> Iterator[bytes]:
    """Yield the requests with which a client makes outputs inactive; a bit is written without its neighbours."""
    for each in outputs:
        row = each.values(level=False)
        head = bytes([each.unit, 15 if each.register_type == "coil" else 22 if each.bitmask else 16])
        head += each.address.to_bytes(2, "big")
        if each.register_type == "coil":
            bits = sum(bool(value) << place for place, value in enumerate(row))
            data = bits.to_bytes(-(-len(row) // 8), "little")
            yield sealed(head + len(row).to_bytes(2, "big") + bytes([len(data)]) + data)
        elif each.bitmask:
            yield sealed(head + (~each.bitmask & 0xFFFF).to_bytes(2, "big") + row[0].to_bytes(2, "big"))
        else:
            words = b"".join(value.to_bytes(2, "big") for value in row)
            yield sealed(head + len(row).to_bytes(2, "big") + bytes([len(words)]) + words)


class OtherDevice:
    """A device that is not the one of the description: it has all tables, of 0, and answers for every unit."""

    def __init__(self) -> None:
        self._station = RemoteIo({}, lambda channel, level: None)

    def answer(self, request: bytes, at: int) -> bytes:
        """Return its answer to a request; empty if the request is damaged."""
        if read_request(request) is None:
            return b""
        return self._station.answer(request[0], request[1:-2], at)
