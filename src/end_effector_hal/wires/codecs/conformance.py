# ruff: noqa: D102 the name of a test says what must hold
"""What every codec must do; inherit `CodecConformance` in your tests (needs pytest and hypothesis).

class TestMyCodec(CodecConformance):
    codec = MyCodec()
    vectors = ((b"...", Frame(0, 41, 820, {"bottom": -78_250})),)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from end_effector_hal.wires.codecs._codec import Codec
from end_effector_hal.wires.frame import Frame, Kind, Value

_EXAMPLES = settings(suppress_health_check=[HealthCheck.differing_executors], deadline=None)


class CodecConformance:
    """Set ``codec``, and ``vectors``: at least one exact pair of bytes and the frame that they mean."""

    codec: ClassVar[Codec]
    vectors: ClassVar[Sequence[tuple[bytes, Frame]]]
    pressures_pa = (-90_000, 700_000)
    longest_memory = 4096
    """Bytes; more than a decoder may keep of a stream without frames (measured by what it still finds)."""

    def frame(self, data: st.DataObject, seq: int = 7) -> Frame:
        """Any frame, as it is after one way over the wire (a format may round, or derive a channel)."""
        kinds = {Kind.PRESSURE: st.integers(*self.pressures_pa), Kind.BIT: st.booleans()}
        values: dict[str, Value] = {
            name: data.draw(kinds[kind], label=name) for name, kind in self.codec.channels.items()
        }
        sent = self.codec.encode(Frame(0, seq, 20 * seq, values))
        (frame,) = self.codec.decoder().feed(sent, 0)
        return frame

    def test_declares_what_it_carries(self) -> None:
        assert self.codec.channels
        assert all(isinstance(kind, Kind) for kind in self.codec.channels.values())
        assert self.codec.period_us > 0
        assert self.codec.baudrate > 0

    def test_vectors(self) -> None:
        assert self.vectors
        for data, frame in self.vectors:
            assert self.codec.encode(frame) == data
            assert self.codec.decoder().feed(data, frame.at) == [frame]

    @_EXAMPLES
    @given(data=st.data())
    def test_round_trip(self, data: st.DataObject) -> None:
        frame = self.frame(data)
        assert self.codec.decoder().feed(self.codec.encode(frame), 0) == [frame]
        assert set(frame.values) == set(self.codec.channels)

    @_EXAMPLES
    @given(chunks=st.lists(st.binary(max_size=300), max_size=20))
    def test_never_raises(self, chunks: list[bytes]) -> None:
        decoder = self.codec.decoder()
        frames = [frame for at, chunk in enumerate(chunks) for frame in decoder.feed(chunk, at)]
        assert decoder.bytes == sum(map(len, chunks))
        assert decoder.frames == len(frames)
        assert all(set(frame.values) <= set(self.codec.channels) for frame in frames)

    @_EXAMPLES
    @given(noise=st.binary(max_size=300), data=st.data())
    def test_frame_after_any_noise_is_found(self, noise: bytes, data: st.DataObject) -> None:
        decoder = self.codec.decoder()
        decoder.feed(noise, 1)
        frame = self.frame(data)
        found = decoder.feed(self.codec.encode(frame), 2)
        assert found
        assert (found[-1].at, found[-1].values) == (2, frame.values)

    @_EXAMPLES
    @given(data=st.data())
    def test_frame_after_a_cut_frame_is_found(self, data: st.DataObject) -> None:
        decoder = self.codec.decoder()
        cut = self.codec.encode(self.frame(data, seq=6))
        decoder.feed(cut[: data.draw(st.integers(0, len(cut)), label="cut at")], 1)
        frame = self.frame(data)
        assert decoder.feed(self.codec.encode(frame), 2)[-1].values == frame.values

    @_EXAMPLES
    @given(data=st.data())
    def test_split_anywhere(self, data: st.DataObject) -> None:
        frames = [self.frame(data, seq) for seq in (1, 2, 3)]
        stream = b"".join(map(self.codec.encode, frames))
        cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8), label="cuts"))
        pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
        decoder = self.codec.decoder()
        found = [frame for piece in pieces for frame in decoder.feed(piece, 0)]
        assert found == frames

    def test_memory_is_bounded(self) -> None:
        for byte in self.codec.encode(Frame(0, 0, 0, dict.fromkeys(self.codec.channels, 0))):
            decoder = self.codec.decoder()
            for _ in range(64):
                decoder.feed(bytes([byte]) * self.longest_memory, 0)
            assert _kept(decoder) <= self.longest_memory


def _kept(decoder: object) -> int:
    """Bytes in the attributes of a decoder."""
    names = (*getattr(decoder, "__dict__", ()), *getattr(decoder, "__slots__", ()))
    parts = (getattr(decoder, name, None) for name in names)
    return sum(len(part) for part in parts if isinstance(part, bytes | bytearray | list))
