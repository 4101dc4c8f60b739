"""Devices that answer on one bus of Modbus RTU, by their registers."""

from __future__ import annotations

from typing import Protocol

from end_effector_lab.testbench.devices import (
    LONGEST,
    RegisterRequest,
    done_answer,
    exception_answer,
    read_request,
    sealed,
)

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS = 1, 2


class RegisterMap(Protocol):
    """The registers of one device; each call comes with its time, µs."""

    def read(self, function: int, address: int, count: int, at: int) -> list[int] | None:
        """Registers; None: it has no such ones."""
        ...

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        """Set registers; False: it has no such ones, or they may not be set so."""
        ...


class RtuServer:
    """Devices on one bus, by their units; others do not answer.

    A request is taken for whole as it comes; half a request is kept until more comes.
    """

    def __init__(self, units: dict[int, RegisterMap]) -> None:
        self._units = units
        self._rest = b""

    def answer(self, data: bytes, at: int) -> bytes:
        """The answer to the request that ends in ``data``, empty where there is none."""
        self._rest = (self._rest + data)[-LONGEST:]
        for start in range(len(self._rest)):
            if (request := read_request(self._rest[start:])) is not None:
                self._rest = b""
                return self._answer(request, at)
        return b""

    def _answer(self, request: RegisterRequest, at: int) -> bytes:
        device = self._units.get(request.unit)
        if device is None:
            return b""
        if request.values is not None:
            done = device.write(request.address, request.values, at)
            return done_answer(request) if done else exception_answer(request, ILLEGAL_ADDRESS)
        if request.function not in (3, 4):
            return exception_answer(request, ILLEGAL_FUNCTION)
        words = device.read(request.function, request.address, request.size, at)
        return exception_answer(request, ILLEGAL_ADDRESS) if words is None else _words_answer(request, words)


def _words_answer(request: RegisterRequest, words: list[int]) -> bytes:
    """The answer to a read of registers."""
    data = b"".join(word.to_bytes(2, "big") for word in words)
    return sealed(bytes([request.unit, request.function, len(data)]) + data)
