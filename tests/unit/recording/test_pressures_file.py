"""pressures.csv: thinned to what a figure needs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import read_pressures
from end_effector_hal.recording._pressures import PressuresWriter

CHANNELS = ("bottom", "supply")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "pressures.csv"


def write(path, samples):
    with PressuresWriter(path, CHANNELS) as writer:
        return [writer.write(time_s, dict(zip(CHANNELS, values, strict=True))) for time_s, values in samples]


def test_what_is_read_is_what_was_written(path):
    write(path, [(0.0, (0.0, 600.0)), (0.02, (-12.345, None)), (0.04, (-30.0, 600.5))])
    assert (
        path.read_text()
        == "time_s,bottom_gauge_kpa,supply_gauge_kpa\n0.000000,0.00,600.00\n0.020000,-12.35,\n0.040000,-30.00,600.50\n"
    )
    log = read_pressures(path)
    assert log.channels == CHANNELS
    assert log.times_s == (0.0, 0.02, 0.04)
    assert log.curve("bottom") == (0.0, -12.35, -30.0)
    assert log.curve("supply") == (600.0, None, 600.5)
    assert log.note == ""


def test_a_steady_pressure_is_written_twice_a_second(path):
    write(path, [(n * 0.02, (-78.0 + 0.001 * (n % 3), 600.0)) for n in range(101)])
    assert read_pressures(path).times_s == (0.0, 0.5, 1.0, 1.5, 2.0)


def test_an_edge_keeps_its_steepness(path):
    write(path, [(n * 0.02, (0.0 if n < 10 else -50.0, 600.0)) for n in range(12)])
    # the last steady sample and the first after the edge stand 20 ms apart
    assert read_pressures(path).samples == (
        (0.0, (0.0, 600.0)),
        (0.18, (0.0, 600.0)),
        (0.2, (-50.0, 600.0)),
        (0.22, (-50.0, 600.0)),
    )


def test_never_more_than_fifty_a_second(path):
    assert sum(write(path, [(n / 1000, (float(n), 600.0)) for n in range(10_000)])) == 501


def test_every_sample_of_a_link_of_fifty_hertz_with_jitter(path):
    samples = [(n / 50 + 0.004 * (n % 3 - 1), (float(n), 600.0)) for n in range(1, 500)]
    assert sum(write(path, samples)) == len(samples)


def test_a_channel_that_becomes_invalid_is_written_at_once(path):
    assert write(path, [(0.0, (0.0, 600.0)), (0.001, (None, 600.0)), (0.002, (0.0, 600.0))]) == [True] * 3


@pytest.mark.parametrize("late_s", [0.05, 0.3, 0.39])
@pytest.mark.parametrize("value", [-50.0, None])
def test_a_frame_that_comes_late_does_not_let_time_run_backwards(path, late_s, value):
    """Two senders for a moment, or a frame that waited: its stamp is before that of a sample left out."""
    write(
        path, [(0.0, (0.0, 600.0)), (0.4, (0.0, 600.0)), (0.4 - late_s, (value, 600.0)), (0.5, (0.0, 600.0))]
    )
    assert read_pressures(path).times_s == (0.0, 0.4, 0.4, 0.5)


def test_missing_and_infinite_values_are_invalid(path):
    with PressuresWriter(path, CHANNELS) as writer:
        writer.write(0.0, {"bottom": float("nan")})
        writer.write(1.0, {"bottom": float("inf"), "other": 3.0})
    assert read_pressures(path).samples == ((0.0, (None, None)), (1.0, (None, None)))


def test_a_file_is_continued(path):
    write(path, [(1.0, (0.0, 600.0))])
    with PressuresWriter(path, CHANNELS) as writer:
        assert writer.write(1.1, {"bottom": 0.0, "supply": 600.0}) is False
        assert writer.write(1.2, {"bottom": -5.0, "supply": 600.0}) is True
    assert read_pressures(path).times_s == (1.0, 1.1, 1.2)


def test_another_header_is_refused(path):
    write(path, [])
    with pytest.raises(UsageError, match="another header"):
        PressuresWriter(path, ("bottom",))


def test_a_last_line_without_its_end_is_dropped_because_digits_may_be_missing(path):
    path.write_text("time_s,bottom_gauge_kpa,supply_gauge_kpa\n0,0,600\n1,-7,60")
    log = read_pressures(path)
    assert log.times_s == (0.0,)
    assert log.note == f"{path}:3: the last line is cut off and was dropped."


@given(
    st.lists(st.tuples(st.integers(0, 400), st.floats(-90, 10), st.none() | st.floats(0, 700)), max_size=60)
)
def test_no_written_curve_is_far_from_what_was_measured(tmp_path_factory, steps):
    path = tmp_path_factory.mktemp("curve") / "pressures.csv"
    samples, at = [], 0.0
    for millis, bottom, supply in steps:
        at += 0.02 + millis / 1000
        samples.append((round(at, 6), (bottom, supply)))
    write(path, samples)
    log = read_pressures(path)
    written = list(zip(log.times_s, log.curve("bottom"), strict=True))
    for time_s, (bottom, _) in samples:
        before = [value for at, value in written if at <= time_s]
        after = [value for at, value in written if at >= time_s]
        # every sample lies within the band of the last one written before it, and the curve ends where it ended
        assert abs(before[-1] - bottom) <= 0.21
        assert after
