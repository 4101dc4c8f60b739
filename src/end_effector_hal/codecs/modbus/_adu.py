"""Modbus RTU frames, by pymodbus: PDUs, address and CRC."""

from __future__ import annotations

from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU, ExceptionResponse
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadHoldingRegistersResponse,
    ReadInputRegistersRequest,
    ReadInputRegistersResponse,
)

from end_effector_hal.codecs.modbus._read import HOLDING, INPUT, Read

DEVICE_FAILURE = 4
REQUEST_BYTES = 8
_REQUESTS = {HOLDING: ReadHoldingRegistersRequest, INPUT: ReadInputRegistersRequest}
_RESPONSES = {HOLDING: ReadHoldingRegistersResponse, INPUT: ReadInputRegistersResponse}
_FRAMER = FramerRTU(DecodePDU(is_server=False))


def request(read: Read) -> bytes:
    """The request, address to CRC."""
    pdu = _REQUESTS[read.function](address=read.address, count=read.count).encode()
    return _frame(read, read.function, pdu)


def answer(read: Read, words: list[int]) -> bytes:
    """The answer with these registers."""
    return _frame(read, read.function, _RESPONSES[read.function](registers=words).encode())


def refusal(read: Read) -> bytes:
    """The answer of a device that has no value: an exception, Server Device Failure."""
    return _frame(read, read.function | 0x80, ExceptionResponse(read.function, DEVICE_FAILURE).encode())


def words_of(read: Read, adu: bytes) -> list[int]:
    """The registers in an answer whose CRC is right."""
    response = _RESPONSES[read.function]()
    response.decode(adu[2:-2])
    return list(response.registers)


def is_whole(adu: bytes) -> bool:
    """Whether the CRC is right."""
    return bool(FramerRTU.check_CRC(adu[:-2], int.from_bytes(adu[-2:], "big")))


def _frame(read: Read, function: int, pdu: bytes) -> bytes:
    frame: bytes = _FRAMER.encode(bytes([function]) + pdu, read.unit, 0)
    return frame
