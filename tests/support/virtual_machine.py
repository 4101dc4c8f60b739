"""A virtual machine, as far as its GPIO chip can tell: a vhost-user front-end with one request queue."""

from __future__ import annotations

import mmap
import os
import socket
import struct
from pathlib import Path

SIZE, QUEUE = 1 << 16, 8
GUEST, USER = 0x1000_0000, 0x7F00_0000_0000
DESCRIPTORS, AVAILABLE, USED, REQUEST, ANSWER = 0x0, 0x400, 0x800, 0x1000, 0x2000


class VirtualMachine:
    """Sets up the queue as the gpio-virtio driver has it; `ask` waits for the answer, as the driver does."""

    def __init__(self, path: Path) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(20)
        self.socket.connect(str(path))
        self._fd = os.memfd_create("guest")
        os.truncate(self._fd, SIZE)
        self.memory = mmap.mmap(self._fd, SIZE)
        self._kick, self._call = os.eventfd(0), os.eventfd(0)
        self._asked = 0

    def boot(self, queue_size: int = QUEUE) -> VirtualMachine:
        """What QEMU and User-Mode-Linux say before the driver runs."""
        features = self.say(1, reply=True)
        assert struct.unpack("<Q", features)[0] & 1 << 32, "a driver needs VERSION_1"
        self.say(3)
        protocol = struct.unpack("<Q", self.say(15, reply=True))[0]
        self.say(16, struct.pack("<Q", protocol))
        self.say(21, fds=[self._call])
        self.say(2, features)
        region = struct.pack("<IIQQQQ", 1, 0, GUEST, SIZE, USER, 0)
        assert self.say(5, region, fds=[self._fd], flags=0x9, reply=True) == bytes(8)
        self.say(8, struct.pack("<II", 0, queue_size))
        self.say(10, struct.pack("<II", 0, 0))
        places = (USER + DESCRIPTORS, USER + USED, USER + AVAILABLE)
        self.say(9, struct.pack("<IIQQQQ", 0, 0, *places, 0))
        self.say(13, struct.pack("<Q", 0), fds=[self._call])
        self.say(12, struct.pack("<Q", 0), fds=[self._kick])
        self.say(18, struct.pack("<II", 0, 1))
        return self

    def say(
        self, kind: int, payload: bytes = b"", *, fds: tuple[int, ...] | list[int] = (), flags: int = 1,
        reply: bool = False,
    ) -> bytes:  # fmt: skip
        """One message; the payload of its reply, if it has one."""
        message = struct.pack("<III", kind, flags, len(payload)) + payload
        socket.send_fds(self.socket, [message], list(fds))
        if not reply:
            return b""
        answered, _, size = struct.unpack("<III", self._receive(12))
        assert answered == kind
        return self._receive(size)

    def ask(self, kind: int, line: int, value: int = 0, *, room: int = 2) -> bytes:
        """One request of the driver; its answer."""
        struct.pack_into("<HHI", self.memory, REQUEST, kind, line, value)
        self.memory[ANSWER : ANSWER + room] = b"\xee" * room
        table = struct.pack("<QIHHQIHH", GUEST + REQUEST, 8, 1, 1, GUEST + ANSWER, room, 2, 0)
        self.memory[DESCRIPTORS : DESCRIPTORS + len(table)] = table
        struct.pack_into("<H", self.memory, AVAILABLE + 4 + 2 * (self._asked % QUEUE), 0)
        self._asked = (self._asked + 1) & 0xFFFF
        struct.pack_into("<H", self.memory, AVAILABLE + 2, self._asked)
        self.ring()
        os.eventfd_read(self._call)
        assert struct.unpack_from("<H", self.memory, USED + 2)[0] == self._asked
        head, written = struct.unpack_from("<II", self.memory, USED + 4 + 8 * ((self._asked - 1) % QUEUE))
        assert head == 0
        return self.memory[ANSWER : ANSWER + written]

    def drive(self, line: int, level: bool) -> None:
        """As gpio-virtio makes an output: its value first, then the direction."""
        assert self.ask(5, line, int(level)) == b"\0\0"
        assert self.ask(3, line, 1) == b"\0\0"

    def ring(self) -> None:
        """The doorbell of the queue."""
        os.eventfd_write(self._kick, 1)

    @property
    def is_cut_off(self) -> bool:
        """Waits until the other end has closed the connection."""
        try:
            return self.socket.recv(1) == b""
        except ConnectionResetError:
            return True

    def off(self) -> None:
        """It ends."""
        for fd in (self._fd, self._kick, self._call):
            os.close(fd)
        self.socket.close()

    def _receive(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            part = self.socket.recv(size - len(data))
            if not part:
                raise EOFError
            data += part
        return data
