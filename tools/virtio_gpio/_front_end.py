"""The connection to a virtual machine: vhost-user messages, and the notifications of its queue."""

from __future__ import annotations

import array
import os
import socket
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import IntEnum

from end_effector_hal.errors import WireError

from ._pins import Pins
from ._virtqueue import GuestMemory, Virtqueue

_HEADER = struct.Struct("<III")
_NUMBER, _PAIR = struct.Struct("<Q"), struct.Struct("<II")
_ADDRESSES = struct.Struct("<IIQQQQ")
_REPLY, _NEED_REPLY = 0x5, 0x8
_VERSION_1, _PROTOCOL_FEATURES = 1 << 32, 1 << 30
# User-Mode-Linux takes an interrupt only where the back-end could send requests of its own (1 << 5)
_OFFERED = 1 << 3 | 1 << 5 | 1 << 9
_NO_FILE = 0x100
_MOST = 4096  # bytes of a payload, far above what any message has
QUEUES = 2  # requests, and events (unused: no interrupts are offered)


class Message(IntEnum):
    """Messages that need more than an acknowledgement (VHOST_USER_*)."""

    GET_FEATURES = 1
    SET_MEM_TABLE = 5
    SET_VRING_NUM = 8
    SET_VRING_ADDR = 9
    SET_VRING_BASE = 10
    GET_VRING_BASE = 11
    SET_VRING_KICK = 12
    SET_VRING_CALL = 13
    GET_PROTOCOL_FEATURES = 15
    GET_QUEUE_NUM = 17
    SET_SLAVE_REQ_FD = 21
    GET_CONFIG = 24


@dataclass
class _Ring:
    """The state of a queue; ``queue`` is set when its addresses are received."""

    size: int = 0
    seen: int = 0
    kick: int = -1
    call: int = -1
    queue: Virtqueue | None = None


class FrontEnd:
    """One virtual machine that drives the pins, until it disconnects.

    Args:
        connection: its socket; `close` closes it.
        pins: the chip that it uses.
    """

    def __init__(self, connection: socket.socket, pins: Pins) -> None:
        self._socket, self._pins = connection, pins
        self._memory = GuestMemory()
        self._rings = [_Ring() for _ in range(QUEUES)]
        self._back_channel = -1
        self._handlers: dict[int, Callable[[bytes, list[int]], bytes | None]] = {
            Message.GET_FEATURES: lambda *_: _NUMBER.pack(_VERSION_1 | _PROTOCOL_FEATURES),
            Message.GET_PROTOCOL_FEATURES: lambda *_: _NUMBER.pack(_OFFERED),
            Message.GET_QUEUE_NUM: lambda *_: _NUMBER.pack(QUEUES),
            Message.SET_MEM_TABLE: self._set_memory,
            Message.SET_VRING_NUM: self._set_size,
            Message.SET_VRING_ADDR: self._set_addresses,
            Message.SET_VRING_BASE: self._set_base,
            Message.GET_VRING_BASE: self._get_base,
            Message.SET_VRING_KICK: self._set_kick,
            Message.SET_VRING_CALL: self._set_call,
            Message.SET_SLAVE_REQ_FD: self._set_back_channel,
            Message.GET_CONFIG: self._get_config,
        }

    def files(self) -> dict[int, Callable[[], None]]:
        """Return a handler for each file to wait for; handlers raise WireError after a disconnection."""
        kick = self._rings[0].kick
        return {self._socket.fileno(): self.message} | ({kick: self.kick} if kick >= 0 else {})

    def message(self) -> None:
        head, fds = self._receive(_HEADER.size)
        kind, flags, size = _HEADER.unpack(head)
        if size > _MOST:
            _close(fds)
            raise WireError(f"this is no vhost-user front-end: a message of {size} bytes.")
        try:
            payload, more = self._receive(size) if size else (b"", [])
            fds += more
            reply = self._handlers.get(kind, self._pass_over)(payload, fds)
        except (struct.error, IndexError) as error:
            raise WireError(f"a vhost-user message ({kind}) cannot be understood: {error}.") from error
        if reply is None and flags & _NEED_REPLY:
            reply = _NUMBER.pack(0)
        if reply is not None:
            with _gone():
                self._socket.sendall(_HEADER.pack(kind, _REPLY, len(reply)) + reply)

    def kick(self) -> None:
        """Answer the pending requests."""
        ring = self._rings[0]
        with suppress(BlockingIOError):
            os.read(ring.kick, 8)
        if ring.queue is not None and ring.queue.serve(self._pins.answer) and ring.call >= 0:
            os.write(ring.call, _NUMBER.pack(1))

    def close(self) -> None:
        self._socket.close()
        for ring in self._rings:
            _close([ring.kick, ring.call])
            ring.kick = ring.call = -1
            ring.queue = None
        _close([self._back_channel])
        self._back_channel = -1
        self._memory.close()

    def _receive(self, size: int) -> tuple[bytes, list[int]]:
        data, fds = b"", array.array("i")
        with _gone():
            while len(data) < size:
                part, rights, _, _ = self._socket.recvmsg(
                    size - len(data), socket.CMSG_SPACE(8 * fds.itemsize)
                )
                for level, kind, content in rights:
                    if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
                        fds.frombytes(content[: len(content) // fds.itemsize * fds.itemsize])
                if not part:
                    _close(fds)
                    raise EOFError
                data += part
        return data, list(fds)

    def _set_memory(self, payload: bytes, fds: list[int]) -> None:
        for ring in self._rings:
            ring.queue = None
        self._memory.close()
        self._memory = GuestMemory(payload, fds)

    def _set_size(self, payload: bytes, _fds: list[int]) -> None:
        index, size = _PAIR.unpack(payload)
        self._rings[index].size = size

    def _set_addresses(self, payload: bytes, _fds: list[int]) -> None:
        index, _, descriptors, used, available, _ = _ADDRESSES.unpack(payload)
        ring, at = self._rings[index], self._memory.at_user
        if not 0 < ring.size <= 1 << 15:
            raise WireError("the front-end gave a queue no size.")
        ring.queue = Virtqueue(
            self._memory, ring.size, at(descriptors), at(available), at(used), seen=ring.seen
        )

    def _set_base(self, payload: bytes, _fds: list[int]) -> None:
        index, seen = _PAIR.unpack(payload)
        self._rings[index].seen = seen

    def _get_base(self, payload: bytes, _fds: list[int]) -> bytes:
        """Stop a queue and return its position."""
        index, _ = _PAIR.unpack(payload)
        ring = self._rings[index]
        ring.seen, ring.queue = ring.queue.seen if ring.queue else ring.seen, None
        _close([ring.kick])
        ring.kick = -1
        return _PAIR.pack(index, ring.seen)

    def _set_kick(self, payload: bytes, fds: list[int]) -> None:
        ring = self._ring(payload)
        _close([ring.kick])
        ring.kick = _file(payload, fds)
        if ring.kick >= 0:
            os.set_blocking(ring.kick, False)

    def _set_call(self, payload: bytes, fds: list[int]) -> None:
        ring = self._ring(payload)
        _close([ring.call])
        ring.call = _file(payload, fds)

    def _set_back_channel(self, _payload: bytes, fds: list[int]) -> None:
        _close([self._back_channel])
        self._back_channel = fds.pop(0)
        _close(fds)

    def _get_config(self, payload: bytes, _fds: list[int]) -> bytes:
        offset, size, _ = _HEADER.unpack_from(payload)
        return payload[: _HEADER.size] + self._pins.config[offset : offset + size].ljust(size, b"\0")

    def _pass_over(self, _payload: bytes, fds: list[int]) -> None:
        """Ignore a message that does not concern this device."""
        _close(fds)

    def _ring(self, payload: bytes) -> _Ring:
        index: int = _NUMBER.unpack(payload)[0] & 0xFF
        return self._rings[index]


def _file(payload: bytes, fds: list[int]) -> int:
    return -1 if _NUMBER.unpack(payload)[0] & _NO_FILE else fds[0]


def _close(fds: Sequence[int]) -> None:
    for fd in fds:
        if fd >= 0:
            os.close(fd)


@contextmanager
def _gone() -> Iterator[None]:
    """Convert the end of a connection into a WireError."""
    try:
        yield
    except (OSError, EOFError) as error:
        raise WireError("the virtual machine has gone.") from error
