"""Modbus RTU frames, built with pymodbus: PDUs, address and CRC."""

from __future__ import annotations

from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU, ExceptionResponse
from pymodbus.pdu.bit_message import (
    ReadCoilsRequest,
    ReadCoilsResponse,
    ReadDiscreteInputsRequest,
    ReadDiscreteInputsResponse,
    WriteMultipleCoilsRequest,
    WriteMultipleCoilsResponse,
    WriteSingleCoilRequest,
)
from pymodbus.pdu.register_message import (
    MaskWriteRegisterRequest,
    ReadHoldingRegistersRequest,
    ReadHoldingRegistersResponse,
    ReadInputRegistersRequest,
    ReadInputRegistersResponse,
    WriteMultipleRegistersRequest,
    WriteMultipleRegistersResponse,
    WriteSingleRegisterRequest,
)

from end_effector_hal.codecs.modbus._read import (
    BITS,
    COILS,
    DISCRETE_INPUTS,
    HOLDING,
    INPUT,
    Read,
    RegisterWrite,
)

DEVICE_FAILURE = 4
REQUEST_BYTES = 8
_REQUESTS = {
    COILS: ReadCoilsRequest,
    DISCRETE_INPUTS: ReadDiscreteInputsRequest,
    HOLDING: ReadHoldingRegistersRequest,
    INPUT: ReadInputRegistersRequest,
}
_REGISTERS = {HOLDING: ReadHoldingRegistersResponse, INPUT: ReadInputRegistersResponse}
_BITS = {COILS: ReadCoilsResponse, DISCRETE_INPUTS: ReadDiscreteInputsResponse}
_FRAMER = FramerRTU(DecodePDU(is_server=False))


def request(read: Read) -> bytes:
    """Return the request for a read, from address to CRC."""
    pdu = _REQUESTS[read.function](address=read.address, count=read.count).encode()
    return _frame(read, read.function, pdu)


def write_request(write: RegisterWrite) -> bytes:
    """Return the request for a write, address to CRC: function 16 or 15 for several values, 6 or 5 for one, 22 for bits
    of a register.
    """
    return _frame(write, *_writing(write))


def acknowledgement(write: RegisterWrite) -> bytes:
    """Return the only answer that confirms the write."""
    count = len(write.values)
    if write.single:
        return write_request(write)  # the device repeats it
    done = WriteMultipleCoilsResponse if write.coils else WriteMultipleRegistersResponse
    return _frame(write, _writing(write)[0], done(address=write.address, count=count).encode())


def _writing(write: RegisterWrite) -> tuple[int, bytes]:
    """Return the function code and the PDU of a write."""
    values, one = list(write.values), write.single
    if write.coils:
        bits = [value != 0 for value in values]
        coils = WriteSingleCoilRequest if one else WriteMultipleCoilsRequest
        return (5 if one else 15), coils(address=write.address, bits=bits).encode()
    if write.mask is not None:
        keeps = ~write.mask & 0xFFFF
        return 22, MaskWriteRegisterRequest(address=write.address, and_mask=keeps, or_mask=values[0]).encode()
    registers = WriteSingleRegisterRequest if one else WriteMultipleRegistersRequest
    return (6 if one else 16), registers(address=write.address, registers=values).encode()


def answer(read: Read, words: list[int]) -> bytes:
    """Return the answer with these registers or bits."""
    if read.function in BITS:
        return _frame(read, read.function, _BITS[read.function](bits=[word != 0 for word in words]).encode())
    return _frame(read, read.function, _REGISTERS[read.function](registers=words).encode())


def refusal(read: Read) -> bytes:
    """Return the answer of a device without a value: the exception Server Device Failure."""
    return _frame(read, read.function | 0x80, ExceptionResponse(read.function, DEVICE_FAILURE).encode())


def words_of(read: Read, adu: bytes) -> list[int]:
    """Return the registers or bits in an answer with a correct CRC."""
    if read.function in BITS:
        bits = _BITS[read.function]()
        bits.decode(adu[2:-2])
        return [int(bit) for bit in bits.bits[: read.count]]
    registers = _REGISTERS[read.function]()
    registers.decode(adu[2:-2])
    return list(registers.registers)


def is_whole(adu: bytes) -> bool:
    """Return whether the CRC is correct."""
    return bool(FramerRTU.check_CRC(adu[:-2], int.from_bytes(adu[-2:], "big")))


def sealed(body: bytes) -> bytes:
    """Return a frame of RTU: unit and PDU with their CRC."""
    frame: bytes = _FRAMER.encode(body[1:], body[0], 0)
    return frame


def _frame(read: Read | RegisterWrite, function: int, pdu: bytes) -> bytes:
    return sealed(bytes([read.unit, function]) + pdu)
