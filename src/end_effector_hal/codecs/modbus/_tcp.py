"""Modbus TCP as a wire of Modbus RTU, sans-IO: everything else handles frames of RTU only."""

from __future__ import annotations

from end_effector_hal.codecs.modbus import _adu as adu

HEADER_BYTES = 6
SIZES = range(3, 255)
"""Possible values of the length in a header: unit, function and data."""
CRC_BYTES = 2


class TcpFrames:
    """Converts requests of RTU into requests of Modbus TCP, and the answers back.

    Only the answer to the last request is returned, once: an answer with the number of another transaction is late,
    or is for somebody else.
    """

    def __init__(self) -> None:
        self._transaction, self._waits = 0, False
        self._rest = b""

    def request(self, frame: bytes) -> bytes:
        """Return the bytes to send for a request, from unit to CRC."""
        self._transaction, self._waits = self._transaction % 0xFFFF + 1, True
        body = frame[:-CRC_BYTES]
        return self._transaction.to_bytes(2, "big") + bytes(2) + len(body).to_bytes(2, "big") + body

    def feed(self, data: bytes) -> bytes:
        """Return the answer that ends in the received data, with a CRC; empty: there is none.

        Raises:
            ValueError: this is no Modbus TCP; no later data of this connection could be understood.
        """
        self._rest += data
        answer = b""
        while len(self._rest) >= HEADER_BYTES:
            transaction, protocol, size = (int.from_bytes(self._rest[i : i + 2], "big") for i in (0, 2, 4))
            if protocol or size not in SIZES:
                raise ValueError("the far end does not speak Modbus TCP")
            if len(self._rest) < HEADER_BYTES + size:
                break
            body, self._rest = (
                self._rest[HEADER_BYTES : HEADER_BYTES + size],
                self._rest[HEADER_BYTES + size :],
            )
            if self._waits and transaction == self._transaction:
                self._waits, answer = False, adu.sealed(body)
        return answer
