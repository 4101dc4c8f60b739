# ruff: noqa: D102 the name of a test says what must hold
"""Tests that every codec must pass; inherit `CodecConformance` in your tests (needs pytest and hypothesis).

class TestMyCodec(CodecConformance):
    codec = MyCodec()
    vectors = ((b"...", Frame(0, 41, 820, {"bottom": -78_250})),)

For a polled codec inherit `PolledCodecConformance`, of the module polled_conformance.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Sequence
from typing import ClassVar

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from end_effector_hal.codecs._answers import counters_of, frame_fault
from end_effector_hal.codecs._codec import Codec, Decoder
from end_effector_hal.codecs._registry import declared
from end_effector_hal.signals import Frame, Kind, Value

EXAMPLES = settings(
    suppress_health_check=[HealthCheck.differing_executors],
    deadline=None,
    max_examples=settings().max_examples // 2,  # of the profile that is loaded
)


class CodecConformance:
    """Tests of a codec. Set ``codec``, and ``vectors``: at least one exact pair of bytes and their frame."""

    codec: ClassVar[Codec]
    vectors: ClassVar[Sequence[tuple[bytes, Frame]]]
    pressures_pa = (-90_000, 700_000)
    has_checksum = True
    """Whether damaged bytes never become a frame; if False, tests that need a checksum are left out."""
    unbelieved = 0
    """Frames that the decoder discards at the start and after damage, for formats without a checksum."""
    longest_memory = 4096
    """Most bytes that a decoder may keep of a stream without frames."""

    def sent(self, data: st.DataObject, seq: int = 7) -> bytes:
        """Return the bytes of a random frame."""
        kinds = {Kind.PRESSURE: st.integers(*self.pressures_pa), Kind.BIT: st.booleans()}
        values: dict[str, Value] = {
            name: data.draw(kinds[kind], label=name) for name, kind in self.codec.channels.items()
        }
        return self.codec.encode(Frame(0, seq, 20 * seq, values))

    def in_step(self) -> Decoder:
        """Return a new decoder that accepts the next frame."""
        decoder = self.codec.decoder()
        assert decoder.feed(self.first(), 0) == []
        return decoder

    def first(self) -> bytes:
        """Return frames that the decoder discards."""
        return self.unbelieved * self.codec.encode(Frame(0, 0, 0, dict.fromkeys(self.codec.channels, 0)))

    def frame(self, data: st.DataObject, seq: int = 7) -> Frame:
        """Return a random frame after one transmission (a format may round values or derive a channel)."""
        (frame,) = self.in_step().feed(self.sent(data, seq), 0)
        return frame

    def test_declares_what_it_carries(self) -> None:
        check_declarations(self.codec)

    def test_vectors(self) -> None:
        assert self.vectors
        for data, frame in self.vectors:
            assert self.codec.encode(frame) == data
            assert self.in_step().feed(data, frame.at) == [frame]

    @EXAMPLES
    @given(data=st.data(), at=st.integers(0, 2**62))
    def test_frames_are_plain_and_have_the_stamp_that_was_given(self, data: st.DataObject, at: int) -> None:
        decoder, sent = self.codec.decoder(), self.sent(data)
        check_frames(self.codec, found := decoder.feed(sent, at), len(sent))
        assert [frame.at for frame in found] == [at] * len(found)
        check_counters(decoder)

    def test_each_decoder_is_a_new_one(self) -> None:
        first, second = self.codec.decoder(), self.codec.decoder()
        first.feed(b"x", 0)
        assert (first.bytes, second.bytes) == (1, 0)

    @EXAMPLES
    @given(data=st.data())
    def test_round_trip(self, data: st.DataObject) -> None:
        frame = self.frame(data)
        assert self.in_step().feed(self.codec.encode(frame), 0) == [frame]
        assert set(frame.values) == set(self.codec.channels)

    @EXAMPLES
    @given(chunks=st.lists(st.binary(max_size=300), max_size=20))
    def test_never_raises(self, chunks: list[bytes]) -> None:
        decoder = self.codec.decoder()
        frames = [frame for at, chunk in enumerate(chunks) for frame in decoder.feed(chunk, at)]
        assert decoder.bytes == sum(map(len, chunks))
        assert decoder.frames == len(frames)
        check_frames(self.codec, frames, decoder.bytes)
        check_counters(decoder)

    @EXAMPLES
    @given(noise=st.binary(max_size=300))
    def test_garbage_is_no_frame(self, noise: bytes) -> None:
        decoder = self.codec.decoder()
        frames = decoder.feed(noise, 0)
        if self.has_checksum:
            assert frames == []
        # what is left over can still become a frame: it is counted once it cannot
        assert sum(decoder.errors.values()) + len(frames) <= len(noise)

    @EXAMPLES
    @given(noise=st.binary(max_size=300), data=st.data())
    def test_frame_after_any_noise_is_found(self, noise: bytes, data: st.DataObject) -> None:
        decoder = self.codec.decoder()
        decoder.feed(noise, 1)
        frame = self.frame(data)
        found = decoder.feed(self.first() + self.first() + self.codec.encode(frame), 2)
        assert found
        assert (found[-1].at, found[-1].values) == (2, frame.values)

    @EXAMPLES
    @given(data=st.data())
    def test_frame_after_a_cut_frame_is_found(self, data: st.DataObject) -> None:
        decoder = self.codec.decoder()
        whole = self.sent(data, seq=6)
        cut = whole[: data.draw(st.integers(0, len(whole)), label="cut at")]
        decoder.feed(cut, 1)
        frame = self.frame(data)
        again = self.first() + self.first() + self.codec.encode(frame)
        assume(not completed(cut, whole, again))
        assert decoder.feed(again, 2)[-1].values == frame.values

    @EXAMPLES
    @given(data=st.data())
    def test_a_damaged_frame_is_dropped_and_the_next_one_found(self, data: st.DataObject) -> None:
        first, second, third = (self.frame(data, seq) for seq in (1, 2, 3))
        stream = [self.codec.encode(frame) for frame in (first, second, third)]
        whole, cut = stream[1], damaged(data, stream[1])
        stream[1] = cut + self.first() + self.first()
        assume(not completed(cut, whole, stream[2]))
        found = self.in_step().feed(b"".join(stream), 0)
        assert found[0] == first
        assert found[-1].values == third.values
        if self.has_checksum:
            assert all(frame in (first, second, third) for frame in found)

    @EXAMPLES
    @given(data=st.data())
    def test_split_anywhere(self, data: st.DataObject) -> None:
        frames = [self.frame(data, seq) for seq in (1, 2, 3)]
        stream = b"".join(map(self.codec.encode, frames))
        assert fed(self.in_step(), pieces(data, stream)) == frames

    @EXAMPLES
    @given(data=st.data())
    def test_any_split_of_any_bytes_gives_the_same_frames(self, data: st.DataObject) -> None:
        kinds = [
            st.just(self.sent(data, 1)),
            st.just(self.sent(data, 2)),
            st.just(damaged(data, self.sent(data, 3))),
            st.binary(max_size=120),
        ]
        stream = b"".join(data.draw(st.lists(st.one_of(*kinds), max_size=8), label="stream"))
        whole = self.codec.decoder().feed(stream, 0)
        assert fed(self.codec.decoder(), pieces(data, stream)) == whole

    def test_sequence_numbers_tell_what_is_lost_doubled_and_begun_anew(self) -> None:
        values: dict[str, Value] = dict.fromkeys(self.codec.channels, 0)
        sent = [self.codec.encode(Frame(0, seq, 20 * seq, values)) for seq in (1000, 1000, 1001, 1005, 0)]
        decoder = self.codec.decoder()
        found = [frame for data in sent for frame in decoder.feed(data, 0)]
        if found[0].seq is None:
            return  # the format has none
        assert [frame.seq for frame in found] == [1000, 1001, 1005, 0]
        assert (decoder.errors["duplicate"], decoder.lost, decoder.reboots) == (1, 3, 1)

    def test_memory_is_bounded(self) -> None:
        for byte in self.codec.encode(Frame(0, 0, 0, dict.fromkeys(self.codec.channels, 0))):
            decoder = self.codec.decoder()
            before = len(pickle.dumps(decoder))
            for _ in range(8):
                decoder.feed(bytes([byte]) * self.longest_memory, 0)
            assert len(pickle.dumps(decoder)) - before <= self.longest_memory


def check_declarations(codec: Codec) -> None:
    """Check that the declarations are constant plain values of the right types; other codecs cannot be loaded."""
    checked = declared(codec)
    assert (checked.name, dict(checked.channels)) == (codec.name, dict(codec.channels))
    assert (checked.period_us, checked.baudrate) == (codec.period_us, codec.baudrate)


def check_frames(codec: Codec, frames: object, fed: int) -> None:
    """Check for a list of frames whose values match the channels and are whole numbers within the range of
    a message.
    """
    assert type(frames) is list
    assert len(frames) <= fed
    assert [fault for each in frames if (fault := frame_fault(each, codec.channels, 0, 2**63))] == []


def check_counters(decoder: Decoder) -> None:
    """Check that the counters are whole numbers with printable names."""
    assert counters_of(decoder) is not None


def damaged(data: st.DataObject, frame: bytes) -> bytes:
    """Return the frame with one byte changed, lost or doubled."""
    at = data.draw(st.integers(0, len(frame) - 1), label="damaged at")
    byte = frame[at : at + 1]
    other = bytes([byte[0] ^ data.draw(st.integers(1, 255), label="by")])
    return frame[:at] + data.draw(st.sampled_from([other, b"", 2 * byte]), label="now") + frame[at + 1 :]


def completed(cut: bytes, whole: bytes, after: bytes) -> bool:
    """Return whether the following bytes complete a cut frame; then a later frame has lost its first bytes."""
    return len(cut) < len(whole) and (cut + after).startswith(whole)


def pieces(data: st.DataObject, stream: bytes) -> list[bytes]:
    """Return the stream, cut into pieces at random."""
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8), label="cuts"))
    return [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]


def fed(decoder: Decoder, chunks: Iterable[bytes]) -> list[Frame]:
    """Feed the pieces and return all frames."""
    return [frame for chunk in chunks for frame in decoder.feed(chunk, 0)]
