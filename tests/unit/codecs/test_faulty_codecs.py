"""A codec or a port that does what it must not: the link is down with the reason, tried again, and can be closed."""

from __future__ import annotations

import errno
import os
import termios
import threading
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count, repeat
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

import pytest

from end_effector_hal.codecs import OWN_DECODERS, codec_names, declared, get_codec
from end_effector_hal.codecs.conformance import check_frames
from end_effector_hal.errors import LinkError, UsageError
from end_effector_hal.signals import Frame, Kind
from end_effector_hal.wires.link import (
    CodecCalls,
    GuardedDecoder,
    LinkHealth,
    LinkState,
    PtyPair,
    _guard,
    _port,
    _reader,
    open_port,
)
from end_effector_hal.wires.link._guard import CodecFailure
from end_effector_hal.wires.link._reader import LinkReader
from tests.support.patience import PATIENCE_S, wait_until
from tests.unit.codecs.faulty_codec import AskingCodec, FaultyCodec, FaultyDecoder

GOOD = {"bottom": -60_000, "locked": True}


class Unspeakable(Exception):
    """Its text cannot be had."""

    def __str__(self) -> str:
        raise OSError


def raising(error: BaseException | type[BaseException]) -> Callable[..., NoReturn]:
    def fault(*_: object) -> NoReturn:
        raise error

    return fault


def returning(answer: Callable[[int], Any]) -> Callable[..., Any]:
    return lambda _decoder, _data, at: answer(at)


def frame(**changes: Any) -> Callable[[int], list[Frame]]:
    return lambda at: [Frame(**{"at": at, "seq": None, "device_ms": None, "values": GOOD, **changes})]


def cut_off(_decoder: FaultyDecoder, _data: bytes, at: int) -> Iterator[Frame]:
    yield Frame(at, None, None, GOOD)
    raise IndexError("no more")


STAMP = "feed() returned a frame whose stamp is ahead of now, before the last one, or no time"
NUMBER = "feed() returned a frame whose number or clock is no whole number in its range"
PRESSURE = "feed() returned a frame whose pressure bottom is no whole number of Pa"
FAULTS: dict[str, tuple[Callable[..., Any], str]] = {
    "an exception": (raising(ValueError("bad\nnibble")), "feed() raised ValueError: bad nibble"),
    "a subscript": (raising(KeyError), "feed() raised KeyError"),
    "exit": (raising(SystemExit(3)), "feed() raised SystemExit: 3"),
    "interrupt": (raising(GeneratorExit), "feed() raised GeneratorExit"),
    "no memory": (raising(MemoryError), "feed() raised MemoryError"),
    "recursion": (
        lambda *a: (lambda f: f(f))(lambda f: f(f)),
        "feed() raised RecursionError: maximum recursion",
    ),
    "an unspeakable one": (raising(Unspeakable), "feed() raised Unspeakable"),
    "half a character": (raising(ValueError("\ud800\x00x")), "feed() raised ValueError: x"),
    "nothing": (returning(lambda at: None), "feed() raised TypeError: 'NoneType' object is not iterable"),
    "a text": (returning(lambda at: "frame"), "feed() returned more than 3 frames"),
    "letters": (returning(lambda at: "ab"), "feed() returned something else than frames"),
    "for ever": (
        returning(lambda at: repeat(Frame(at, None, None, GOOD))),
        "feed() returned more than 3 frames",
    ),
    "cut off": (cut_off, "feed() raised IndexError: no more"),
    "the future": (returning(lambda at: frame(at=at + 60_000_000)(at)), STAMP),
    "2038": (returning(frame(at=2**51)), STAMP),
    "negative": (returning(frame(at=-1)), STAMP),
    "nan": (returning(frame(at=float("nan"))), STAMP),
    "the past": (
        returning(lambda at: [Frame(at, None, None, GOOD), Frame(at - 1, None, None, GOOD)]),
        STAMP,
    ),
    "number": (returning(frame(seq="7")), NUMBER),
    "huge number": (returning(frame(seq=2**31)), NUMBER),
    "clock": (returning(frame(device_ms=-1)), NUMBER),
    "a strange channel": (
        returning(frame(values={"humidity": 1})),
        "feed() returned a frame with a channel that the codec does not declare",
    ),
    "no name": (
        returning(frame(values={7: 1})),
        "feed() returned a frame with a channel that the codec does not declare",
    ),
    "a fraction": (returning(frame(values={"bottom": -60_000.5})), PRESSURE),
    "no number": (returning(frame(values={"bottom": float("nan")})), PRESSURE),
    "a bit for a pressure": (returning(frame(values={"bottom": True})), PRESSURE),
    "a huge pressure": (returning(frame(values={"bottom": 10**5000})), PRESSURE),
    "a number for a bit": (
        returning(frame(values={"locked": 1})),
        "feed() returned a frame whose bit locked is neither true nor false",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_whatever_feed_does_is_a_failure_of_the_codec(fault: str) -> None:
    codec = FaultyCodec()
    guard = GuardedDecoder(codec, CodecCalls("/dev/ttyX"))
    assert len(guard.feed(b"abc")) == 3
    codec.fault, why = FAULTS[fault]
    with pytest.raises(CodecFailure) as caught:
        guard.feed(b"abc")
    assert str(caught.value).startswith(f"/dev/ttyX: the codec failed: {why}")
    assert str(caught.value).isprintable()
    assert isinstance(caught.value, LinkError)
    assert guard.counters.bytes in (3, 6)


@pytest.mark.parametrize(
    ("part", "answer", "why"),
    [
        ("bytes", raising(ValueError), "counters raised ValueError"),
        ("bytes", lambda: 1.5, "its counters are no whole numbers by name"),
        ("frames", lambda: -1, "its counters are no whole numbers by name"),
        ("errors", lambda: None, "counters raised TypeError"),
        ("errors", lambda: {"crc": "many"}, "its counters are no whole numbers by name"),
        ("errors", lambda: {7: 7}, "its counters are no whole numbers by name"),
        ("errors", lambda: {f"kind {n}": n for n in range(65)}, "its counters are no whole numbers by name"),
        ("errors", lambda: {"a\nb": 1}, "its counters are no whole numbers by name"),
        ("channels", raising(SystemExit), "channels raised SystemExit"),
        ("channels", lambda: 7, "channels raised TypeError"),
        ("decoder", raising(SystemExit), "decoder() raised SystemExit"),
        ("decoder", lambda: None, "counters raised AttributeError"),
    ],
)
def test_a_decoder_that_cannot_be_made_or_counted(part: str, answer: Callable[[], Any], why: str) -> None:
    codec = FaultyCodec()
    codec.broken[part] = answer
    with pytest.raises(CodecFailure, match="failed: ") as caught:
        GuardedDecoder(codec, CodecCalls("/dev/ttyX"))
    assert why in str(caught.value)


@pytest.mark.parametrize(
    ("part", "answer", "why"),
    [
        ("poll", raising(SystemExit), "poll() raised SystemExit"),
        ("poll", lambda: None, "poll() raised TypeError"),
        ("poll", lambda: (None, ()), "poll() returned something else than at most 4096 bytes to send"),
        ("poll", lambda: (b"x" * 4097, ()), "poll() returned something else than at most 4096 bytes to send"),
        ("poll", lambda: (b"", count()), "poll() returned more than 64 frames"),
        ("poll", lambda: (b"", [None]), "poll() returned something else than frames"),
        ("due", raising(ZeroDivisionError), "due raised ZeroDivisionError"),
        ("due", lambda: float("nan"), "due is no whole number of microseconds"),
        ("due", lambda: None, "due is no whole number of microseconds"),
    ],
)
def test_a_decoder_that_asks_wrongly(part: str, answer: Callable[[], Any], why: str) -> None:
    codec = AskingCodec()
    guard = GuardedDecoder(codec, CodecCalls("/dev/ttyX"))
    codec.broken[part] = answer
    with pytest.raises(CodecFailure, match="failed: ") as caught:
        guard.wait_s() if part == "due" else guard.poll()
    assert why in str(caught.value)


@pytest.mark.parametrize("due", [10**5000, 2**63], ids=["5000 digits", "63 bits"])
def test_a_decoder_that_never_wants_to_ask_is_looked_at_each_second(due: int) -> None:
    codec = AskingCodec()
    codec.broken["due"] = lambda: due
    assert GuardedDecoder(codec, CodecCalls("/dev/ttyX")).wait_s() == 1.0


def test_a_decoder_that_is_always_due_and_never_asks_does_not_spin() -> None:
    codec = AskingCodec()
    codec.broken |= {"due": lambda: 0, "poll": lambda: (b"", ())}
    guard = GuardedDecoder(codec, CodecCalls("/dev/ttyX"))
    assert guard.wait_s() == 0
    assert guard.poll() == (b"", ())
    assert guard.wait_s() == 0.001


@pytest.mark.parametrize("fault", [name for name, (_, why) in FAULTS.items() if "returned a frame" in why])
def test_the_tests_of_a_codec_s_author_find_such_frames(fault: str) -> None:
    codec = FaultyCodec()
    check_frames(codec, FaultyDecoder(codec).feed(b"a", 5), 1)
    if "stamp" in FAULTS[fault][1] and fault != "nan":
        return  # they compare the stamp with the one that was given
    with pytest.raises(AssertionError):
        check_frames(codec, FAULTS[fault][0](FaultyDecoder(codec), b"a", 5), 1)


# What it says of itself


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"name": 7}, "an invalid name"),
        ({"name": "a\nb"}, "an invalid name"),
        ({"channels": {}}, "0 channels, expected 1 to 262"),
        ({"channels": {f"c{n}": Kind.BIT for n in range(263)}}, "263 channels, expected 1 to 262"),
        ({"channels": {"Bottom": Kind.BIT}}, "an invalid channel name"),
        ({"channels": {"none": Kind.BIT}}, "an invalid channel name"),
        ({"channels": {7: Kind.BIT}}, "an invalid channel name"),
        ({"channels": {"bottom": "pressure"}}, "no Kind for the channel bottom"),
        ({"period_us": 0}, "a period_us that is no whole number from 1 to 600000000"),
        ({"period_us": 0.02}, "a period_us that is no whole number"),
        ({"period_us": float("nan")}, "a period_us that is no whole number"),
        ({"baudrate": "fast"}, "a baudrate that is no whole number from 300 to 4000000"),
        ({"baudrate": True}, "a baudrate that is no whole number"),
        ({"parity": "X"}, "a parity that is not N, E or O"),
        ({"resolution_pa": 0}, "a resolution_pa that is no number above 0"),
        ({"resolution_pa": float("nan")}, "a resolution_pa that is no number above 0"),
    ],
)
def test_what_a_codec_declares_is_checked_once(changes: dict[str, Any], why: str) -> None:
    kind = type("Odd", (FaultyCodec,), changes)
    with pytest.raises(UsageError, match="the codec declares ") as caught:
        declared(kind())
    assert why in caught.value.what


@pytest.mark.parametrize("error", [SystemExit, RecursionError, Unspeakable])
def test_an_entry_point_that_raises_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    from importlib.metadata import EntryPoint, EntryPoints

    class Raises:
        def __init__(self) -> None:
            raise error

    monkeypatch.setattr("tests.unit.codecs.faulty_codec.Raises", Raises, raising=False)
    points = EntryPoints(
        [EntryPoint("odd", "tests.unit.codecs.faulty_codec:Raises", "end_effector_hal.codecs")]
    )
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **options: points.select(**options))
    assert "odd" in codec_names()
    with pytest.raises(UsageError, match=f"the codec odd cannot be loaded: {error.__name__}"):
        get_codec("odd")


def test_a_codec_is_made_once_so_that_a_restart_of_a_program_cannot_fail_by_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from importlib.metadata import EntryPoint, EntryPoints

    class MadeOnce(FaultyCodec):
        made = 0

        def __init__(self) -> None:
            MadeOnce.made += 1
            if MadeOnce.made > 1:
                raise KeyError("no second one")
            super().__init__()

    monkeypatch.setattr("tests.unit.codecs.faulty_codec.MadeOnce", MadeOnce, raising=False)
    points = EntryPoints(
        [EntryPoint("once", "tests.unit.codecs.faulty_codec:MadeOnce", "end_effector_hal.codecs")]
    )
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **options: points.select(**options))
    assert get_codec("once") is get_codec("once")


# Behind a real port, with the thread of the link


class Heard:
    """What a link reports."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.changes: list[LinkHealth] = []

    def down(self, why: str) -> bool:
        return any(each.state is LinkState.DOWN and why in each.error for each in self.changes)


@pytest.fixture
def port(tmp_path: Path) -> str:
    return str(tmp_path / "uart")


def works(pty: PtyPair, heard: Heard) -> None:
    """Frames come, sooner or later."""
    begun = len(heard.frames)

    def one_more() -> bool:
        pty.write(b"a")
        return len(heard.frames) > begun

    wait_until("a frame", one_more)


@pytest.mark.wall
@pytest.mark.parametrize("fault", FAULTS)
def test_the_link_is_down_with_the_reason_and_comes_back(port: str, fault: str) -> None:
    heard, codec = Heard(), FaultyCodec()
    with PtyPair(port) as pty:
        link = LinkReader(port, codec, None, heard.frames.append, heard.changes.append)
        link.start()
        works(pty, heard)
        codec.fault, why = FAULTS[fault]

        def failed() -> bool:
            pty.write(b"abc")
            return heard.down(why.replace("3 frames", ""))

        wait_until("DOWN", failed)
        assert link.health.errors["codec"] >= 1
        codec.fault = None
        before, fed = len(codec.decoders), link.health.bytes
        works(pty, heard)
        assert link.health.state is LinkState.UP
        assert len(codec.decoders) >= before, "a new decoder"
        assert link.health.bytes > fed > 0, "what was counted before stays"
        link.close()
    assert not any(thread.name == f"link {port}" for thread in threading.enumerate())


@pytest.mark.wall
@pytest.mark.parametrize("part", ["decoder", "channels", "baudrate", "parity"])
def test_a_codec_that_fails_before_its_first_byte(port: str, part: str) -> None:
    heard, codec = Heard(), FaultyCodec()
    broken: dict[str, Callable[[], Any]] = {part: raising(SystemExit("no"))}
    kind = type("Odd", (FaultyCodec,), {
        "baudrate": property(lambda self: self.asked("baudrate", 115_200)),
        "parity": property(lambda self: self.asked("parity", "N")),
    })  # fmt: skip
    codec = kind()
    codec.broken = broken
    with PtyPair(port) as pty:
        link = LinkReader(port, codec, None, heard.frames.append, heard.changes.append)
        link.start()
        wait_until("DOWN", lambda: heard.down("raised SystemExit: no"))
        assert link.health.state is LinkState.DOWN
        broken.clear()
        works(pty, heard)
        link.close()


@pytest.mark.wall
def test_a_codec_that_does_not_return_is_down_and_can_be_closed(
    port: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(_guard, "HUNG_US", 50_000)
    monkeypatch.setattr(_reader, "CLOSE_S", 0.1)
    heard, codec, goes_on, inside = Heard(), FaultyCodec(), threading.Event(), threading.Event()

    def blocks(decoder: FaultyDecoder, data: bytes, at: int) -> list[Frame]:
        inside.set()
        goes_on.wait(PATIENCE_S)
        return [Frame(at, None, None, GOOD)]

    with PtyPair(port) as pty:
        link = LinkReader(port, codec, None, heard.frames.append, heard.changes.append)
        link.start()
        works(pty, heard)
        codec.fault = blocks
        pty.write(b"a")
        wait_until("the block", inside.is_set)
        wait_until("DOWN", lambda: link.health.state is LinkState.DOWN)
        assert "the codec has not returned from feed() for " in link.health.error
        begun = len(heard.frames)
        thread = next(each for each in threading.enumerate() if each.name == f"link {port}")
        link.close()  # returns
        assert "has not returned from feed()" in caplog.text
        open_port(port, 115_200).close()  # and the port is free
        goes_on.set()
        thread.join(PATIENCE_S)
        assert not thread.is_alive()
        assert len(heard.frames) == begun, "nothing is delivered after close()"


def test_a_built_in_decoder_is_watched_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    calls, hung = CodecCalls("port"), []
    decoder = GuardedDecoder(get_codec("ees1-cobs"), calls)
    monkeypatch.setattr(_guard, "HUNG_US", 0)

    def feed(_: object, data: bytes, at: int) -> list[Frame]:
        hung.append(calls.hung)
        return []

    assert type(decoder._decoder) in OWN_DECODERS
    monkeypatch.setattr(type(decoder._decoder), "feed", feed)
    with pytest.raises(LinkError, match=r"feed\(\) took"):
        decoder.feed(b"a")
    assert "has not returned from feed() for " in hung[0][0]


@pytest.mark.wall
def test_a_call_that_returns_too_late_is_a_failure(port: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_guard, "HUNG_US", 1)
    heard = Heard()
    with PtyPair(port), LinkReader(port, FaultyCodec(), None, heard.frames.append, heard.changes.append):
        wait_until("DOWN", lambda: heard.down("took 0.0 s"))


@pytest.mark.wall
def test_a_listener_that_ends_its_program_ends_nothing(port: str, caplog: pytest.LogCaptureFixture) -> None:
    heard, codec = Heard(), FaultyCodec()

    def listener(each: Frame) -> None:
        heard.frames.append(each)
        raise SystemExit

    with PtyPair(port) as pty, LinkReader(port, codec, None, listener, heard.changes.append):
        works(pty, heard)
        works(pty, heard)
    assert "SystemExit" in caplog.text


# The port itself


@pytest.mark.wall
def test_a_reader_that_has_ended_before_it_is_woken_is_closed_all_the_same(
    port: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its thread sees that it is told to end with the next frame: the pipe that wakes it may be closed by then."""
    heard = Heard()
    with PtyPair(port) as pty:
        link = LinkReader(port, FaultyCodec(), None, heard.frames.append)
        link.start()
        thread = link._thread
        assert thread is not None
        works(pty, heard)

        def late(fd: int, *rest: bytes, call: Callable[..., Any]) -> Any:
            if threading.current_thread() is not thread:
                pty.write(b"a")
                thread.join(PATIENCE_S)
                assert not thread.is_alive()
            return call(fd, *rest)

        slow = {name: partial(late, call=getattr(os, name)) for name in ("write", "close")}
        monkeypatch.setattr(_reader, "os", SimpleNamespace(**{**vars(os), **slow}))
        link.close()


class OddPort:
    """A serial port that closes while it is read, as pyserial and termios show it."""

    def __init__(self, path: str, error: BaseException, at: str) -> None:
        self._port, self._error, self._at = open_port(path, 115_200), error, at

    def close(self) -> None:
        self._port.close()
        self._raise("close")

    def fileno(self) -> int:
        self._raise("fileno")
        return self._port.fileno()

    def _raise(self, where: str) -> None:
        if where == self._at:
            raise self._error


@pytest.mark.wall
@pytest.mark.parametrize("at", ["open", "fileno", "close"])
@pytest.mark.parametrize(
    ("error", "why"),
    [
        (OSError(errno.EIO, "Input/output error"), "Input/output error"),
        (termios.error(5, "Input/output error"), "error: (5, 'Input/output error')"),
        (TypeError("'NoneType' object cannot be interpreted as an integer"), "TypeError: 'NoneType' object"),
        (SystemExit(1), "SystemExit: 1"),
    ],
)
def test_whatever_a_port_raises_it_is_lost_and_opened_again(
    port: str, monkeypatch: pytest.MonkeyPatch, error: BaseException, why: str, at: str
) -> None:
    heard, odd = Heard(), [True]

    def opened(path: str, baudrate: int, **options: Any) -> Any:
        if not odd[0]:
            return open_port(path, baudrate, **options)
        if at == "open":
            raise error
        return OddPort(path, error, at)

    monkeypatch.setattr(_port, "open_port", opened)
    with PtyPair(port) as pty:
        link = LinkReader(port, FaultyCodec(), None, heard.frames.append, heard.changes.append)
        link.start()
        if at == "close":
            works(pty, heard)
            monkeypatch.setattr(_reader.os, "read", raising(OSError(errno.EIO, "gone")))
            pty.write(b"a")
        wait_until("DOWN", lambda: heard.down(f"the port was lost: {why}"))
        monkeypatch.undo()
        odd[0] = False
        works(pty, heard)
        assert link.health.state is LinkState.UP
        assert "codec" not in link.health.errors
        link.close()
