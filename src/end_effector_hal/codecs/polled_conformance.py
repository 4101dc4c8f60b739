# ruff: noqa: D102 the name of a test says what must hold
"""Tests that every polled codec must pass; inherit `PolledCodecConformance` in your tests (needs pytest and
hypothesis).

class TestMyPolledCodec(PolledCodecConformance):
    codec = MyCodec()
    vectors = ((((b"request", b"answer"),), Frame(0, None, None, {"vacuum": -69_000})),)
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from typing import ClassVar

from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.codecs._codec import PolledCodec, PolledDecoder
from end_effector_hal.codecs.conformance import (
    EXAMPLES,
    check_counters,
    check_declarations,
    check_frames,
    damaged,
    pieces,
)
from end_effector_hal.signals import Frame, Kind, Value

Talk = Sequence[tuple[bytes, bytes]]


class PolledCodecConformance:
    """Tests of a polled codec. Set ``codec``, and ``vectors``: requests with their answers, and the frame of that
    cycle.
    """

    codec: ClassVar[PolledCodec]
    vectors: ClassVar[Sequence[tuple[Talk, Frame]]]
    pressures_pa = (-90_000, 0)
    longest_memory = 4096

    def values(self, data: st.DataObject) -> dict[str, Value]:
        """Return random values of a device."""
        kinds = {Kind.PRESSURE: st.integers(*self.pressures_pa), Kind.BIT: st.booleans()}
        return {name: data.draw(kinds[kind], label=name) for name, kind in self.codec.channels.items()}

    def cycle(
        self, decoder: PolledDecoder, values: Mapping[str, Value], *, noise: bytes = b""
    ) -> list[Frame]:
        """Return the frames of one cycle; ``noise`` arrives before each answer."""
        device, frames = self.codec.device(), []
        for _ in range(100):
            at = decoder.due
            polled = decoder.poll(at)
            frames += [*polled.frames]
            answer = device.answer(polled.data, values)
            if answer:
                frames += [*decoder.feed(noise, at + 1), *decoder.feed(answer, at + 2)]
            if frames:
                break
        return frames

    def test_declares_what_it_carries(self) -> None:
        check_declarations(self.codec)

    def test_vectors(self) -> None:
        assert self.vectors
        for talk, frame in self.vectors:
            decoder, device, found = self.codec.decoder(), self.codec.device(), []
            for request, answer in talk:
                assert decoder.poll(decoder.due).data == request
                assert device.answer(request, frame.values) == answer
                found += decoder.feed(answer, frame.at)
            assert found == [frame]
            assert self.codec.encode(frame) == b"".join(answer for _, answer in talk)

    def test_it_asks_by_itself_and_not_before_it_is_due(self) -> None:
        decoder = self.codec.decoder()
        assert decoder.poll(decoder.due).data
        assert decoder.poll(decoder.due - 1).data == b""

    def test_what_it_asks_and_when_is_plain_and_goes_on(self) -> None:
        decoder = self.codec.decoder()
        for _ in range(50):
            due = decoder.due
            polled = decoder.poll(due)
            assert type(due) is int
            assert type(polled.data) is bytes
            assert len(polled.data) <= 4096
            check_frames(self.codec, list(polled.frames), 64)
            check_counters(decoder)
            assert decoder.due > due, "one that is always due and never asks would keep the machine busy"

    @EXAMPLES
    @given(data=st.data())
    def test_frames_are_plain(self, data: st.DataObject) -> None:
        frames = self.cycle(self.codec.decoder(), self.values(data))
        check_frames(self.codec, frames, len(frames))

    @EXAMPLES
    @given(data=st.data())
    def test_round_trip(self, data: st.DataObject) -> None:
        decoder = self.codec.decoder()
        (frame,) = self.cycle(decoder, self.values(data))
        assert set(frame.values) == set(self.codec.channels)
        assert None not in frame.values.values()
        (again,) = self.cycle(decoder, frame.values)
        assert again.values == frame.values
        assert decoder.frames == 2

    def test_no_value_is_no_value(self) -> None:
        (frame,) = self.cycle(self.codec.decoder(), dict.fromkeys(self.codec.channels))
        assert frame.values == dict.fromkeys(self.codec.channels)

    def test_nobody_answers_nothing_is_known(self) -> None:
        decoder = self.codec.decoder()
        for _ in range(20):
            assert decoder.poll(decoder.due).frames == ()
        assert decoder.lost > 0
        assert len(self.cycle(decoder, dict.fromkeys(self.codec.channels, 0))) == 1

    @EXAMPLES
    @given(chunks=st.lists(st.binary(max_size=300), max_size=20))
    def test_garbage_is_no_frame_and_no_error(self, chunks: list[bytes]) -> None:
        decoder, device = self.codec.decoder(), self.codec.device()
        for chunk in chunks:
            decoder.poll(decoder.due)
            assert decoder.feed(chunk, decoder.due - 1) == []
            assert device.answer(chunk, {}) == b""
        assert decoder.bytes == sum(map(len, chunks))

    @EXAMPLES
    @given(noise=st.binary(max_size=300), data=st.data())
    def test_a_cycle_after_any_noise_is_whole(self, noise: bytes, data: st.DataObject) -> None:
        decoder, values = self.codec.decoder(), self.values(data)
        self.cycle(decoder, values, noise=noise)
        found = [frame for _ in range(2) for frame in self.cycle(decoder, values)]
        assert None not in found[-1].values.values()

    @EXAMPLES
    @given(data=st.data())
    def test_a_damaged_answer_is_no_value(self, data: st.DataObject) -> None:
        decoder, device = self.codec.decoder(), self.codec.device()
        values = self.values(data)
        (true,) = self.cycle(self.codec.decoder(), values)
        found: list[Frame] = []
        while not found and decoder.lost == 0:
            at = decoder.due
            polled = decoder.poll(at)
            found += polled.frames
            if polled.data:
                found += decoder.feed(damaged(data, device.answer(polled.data, values)), at + 1)
        assert all(
            value in (None, true.values[name]) for each in found for name, value in each.values.items()
        )

    @EXAMPLES
    @given(data=st.data())
    def test_split_anywhere(self, data: st.DataObject) -> None:
        decoder, device, values = self.codec.decoder(), self.codec.device(), self.values(data)
        (whole,) = self.cycle(self.codec.decoder(), values)
        found: list[Frame] = []
        while not found:
            request = decoder.poll(decoder.due).data
            answer = b"".join(device.answer(piece, values) for piece in pieces(data, request))
            found = [frame for piece in pieces(data, answer) for frame in decoder.feed(piece, 2)]
        assert [frame.values for frame in found] == [whole.values]

    def test_memory_is_bounded(self) -> None:
        values: dict[str, Value] = dict.fromkeys(self.codec.channels, 0)
        for byte in set(self.codec.encode(Frame(0, None, None, values))):
            decoder = self.codec.decoder()
            decoder.poll(decoder.due)
            before = len(pickle.dumps(decoder))
            for _ in range(8):
                decoder.feed(bytes([byte]) * self.longest_memory, 0)
            assert len(pickle.dumps(decoder)) - before <= self.longest_memory
