"""What every line back-end must do: the virtual one, gpiod on a fake kernel and on a real one."""

import errno
import glob
import os
import re
import struct
from types import SimpleNamespace

import gpiod
import pytest

from end_effector_hal.errors import LineBusyError, LineNotFoundError, WireError
from end_effector_hal.wires.lines import GpiodLines, VirtualChip, VirtualLines
from end_effector_hal.wires.lines._gpiod import stop_holders
from tests.support.line_backend_tests import LineBackendConformance

A, B, C = "SODIMM_206", "SODIMM_208", "SODIMM_210"


class TestVirtual(LineBackendConformance):
    @pytest.fixture
    def make(self, tmp_path):
        path = VirtualChip.create(tmp_path / "chip", self.names, {B: "up"}).path
        return lambda: VirtualLines(path)


class FakeKernel:
    """The documented API of gpiod 2 on lines that behave like gpio-mxc's: registers outlive requests."""

    line, LineSettings, api_version = gpiod.line, gpiod.LineSettings, "2.3"

    def __init__(self, **chips):
        self.chips = {
            path: [{"name": name, "out": False, "level": name == B, "by": ""} for name in names]
            for path, names in chips.items()
        }
        self.requests, self.labels = [], {}

    def is_gpiochip_device(self, path):
        return path in self.chips

    def Chip(self, path):
        return FakeChip(self, path)


class FakeContext:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.release()

    def release(self):
        pass


class FakeChip(FakeContext):
    def __init__(self, kernel, path):
        self.kernel, self.path, self.lines = kernel, path, kernel.chips[path]

    def get_info(self):
        return SimpleNamespace(label=self.kernel.labels.get(self.path, ""), num_lines=len(self.lines))

    def get_line_info(self, offset):
        line, direction = self.lines[offset], gpiod.line.Direction
        return SimpleNamespace(
            name=line["name"],
            used=bool(line["by"]),
            consumer=line["by"],
            direction=direction.OUTPUT if line["out"] else direction.INPUT,
        )

    def request_lines(self, config, consumer):
        flat = {
            offset: settings
            for key, settings in config.items()
            for offset in (key if isinstance(key, tuple) else (key,))
        }
        if any(self.lines[offset]["by"] for offset in flat):
            raise OSError(errno.EBUSY, "Device or resource busy")
        self.kernel.requests.append((self.path, sorted(flat), consumer))
        for offset in flat:
            self.lines[offset]["by"] = consumer
        request = FakeRequest(self, list(flat))
        request.reconfigure_lines(config)
        return request


class FakeRequest(FakeContext):
    def __init__(self, chip, offsets):
        self.chip, self.offsets = chip, offsets

    def get_values(self, offsets):
        value = gpiod.line.Value
        return [value.ACTIVE if self.chip.lines[offset]["level"] else value.INACTIVE for offset in offsets]

    def reconfigure_lines(self, config):
        flat = {o: s for key, s in config.items() for o in (key if isinstance(key, tuple) else (key,))}
        assert sorted(flat) == sorted(self.offsets), "what is not named is reset"
        for offset, settings in flat.items():
            if settings.direction == gpiod.line.Direction.OUTPUT:
                level = settings.output_value == gpiod.line.Value.ACTIVE
                self.chip.lines[offset] |= {"out": True, "level": level}

    def set_values(self, values):
        for offset, value in values.items():
            assert offset in self.offsets
            assert self.chip.lines[offset]["out"]
            self.chip.lines[offset]["level"] = value == gpiod.line.Value.ACTIVE

    def release(self):
        for offset in self.offsets:
            self.chip.lines[offset]["by"] = ""


@pytest.fixture
def kernel(monkeypatch, tmp_path):
    """Puts a fake kernel under the back-end: ``kernel(chip=[names])`` gives it, and what makes back-ends."""

    def build(**chips):
        for name in chips:
            (tmp_path / name).touch()
        fake = FakeKernel(**{str(tmp_path / name): names for name, names in chips.items()})
        monkeypatch.setitem(__import__("sys").modules, "gpiod", fake)
        return fake, lambda: GpiodLines(f"{tmp_path}/*")

    return build


class TestGpiodOnFakeKernel(LineBackendConformance):
    @pytest.fixture
    def make(self, kernel):
        return kernel(gpiochip0=[A, B, "", "other", "", C])[1]


def test_adoption_is_one_request_of_outputs_by_the_name_of_the_product(kernel, tmp_path):
    fake, make = kernel(gpiochip0=[A, B, "", C])
    make().request([B, A])
    chip = str(tmp_path / "gpiochip0")
    assert fake.requests == [(chip, [0, 1], "end-effector-hal")]
    assert [line["out"] for line in fake.chips[chip]] == [True, True, False, False]


def test_a_chip_with_more_lines_than_the_kernel_allows_in_a_request_gets_two(kernel, tmp_path):
    names = [f"L{n}" for n in range(130)]
    fake, make = kernel(gpiochip0=names)
    lines = make()
    assert list(lines.request(names[1:])) == names[1:]
    chip, name = str(tmp_path / "gpiochip0"), "end-effector-hal"
    assert fake.requests == [(chip, [*span], name) for span in (range(1, 65), range(65, 129), [129])]
    lines.set({"L1": True, "L129": True})
    assert [name for name, level in lines.levels().items() if level] == ["L1", "L129"]


@pytest.fixture
def descriptors(monkeypatch):
    """Gives requests of the fake kernel descriptors that are known to ioctl, as copies are; counts what is open."""
    requests = {}

    def open_one(request):
        request.fd = os.memfd_create("gpio-line")
        requests[os.fstat(request.fd).st_ino] = request

    def ioctl(fd, number, values):
        request = requests[os.fstat(fd).st_ino]
        bits, mask = struct.unpack("=QQ", values)
        lines = [request.chip.lines[offset] for offset in request.offsets]
        assert mask < 1 << len(lines)
        if number == 0xC010B40F:
            for index, line in enumerate(lines):
                if mask >> index & 1:
                    line["level"] = bool(bits >> index & 1)
            return values
        assert number == 0xC010B40E
        bits = sum(line["level"] << index for index, line in enumerate(lines) if mask >> index & 1)
        return struct.pack("=QQ", bits, mask)

    made = FakeChip.request_lines

    def request_lines(self, config, consumer):
        request = made(self, config, consumer)
        open_one(request)
        return request

    monkeypatch.setattr(FakeChip, "request_lines", request_lines)
    monkeypatch.setattr("fcntl.ioctl", ioctl)


def test_a_request_is_handed_on_by_its_descriptor(kernel, descriptors, tmp_path):
    fake, make = kernel(gpiochip0=[A, B, "", "other", "", C])
    first = make()
    first.request([C, A, B])
    first.set({C: True})
    (name, fd), *more = first.descriptors().items()
    assert (name, more) == ("gpiochip0.5.0.1", [])
    kept = os.dup(fd)
    # the first one dies; its lines stay claimed
    second = make()
    second.restore({name: kept})
    assert second.request([C, A, B]) == {C: True, A: False, B: False}
    assert len(fake.requests) == 1
    second.set({A: True, C: False})
    assert second.levels() == {C: False, A: True, B: False}
    assert [line["level"] for line in fake.chips[str(tmp_path / "gpiochip0")]][::5] == [True, False]
    assert second.descriptors() == {name: kept}
    file = os.fstat(kept).st_ino
    second.close()
    assert not is_open(kept, file)
    assert second.descriptors() == {}


def is_open(fd, file):
    try:
        return os.fstat(fd).st_ino == file
    except OSError:
        return False


def test_a_request_of_other_lines_is_given_back_before_the_lines_are_asked_for(
    kernel, descriptors, monkeypatch
):
    fake, make = kernel(gpiochip0=[A, B, C])
    first = make()
    first.request([A, B])
    ((name, fd),) = first.descriptors().items()
    kept, file = os.dup(fd), os.fstat(fd).st_ino
    first.close()
    second = make()
    second.restore({name: kept})
    # what is closed has a number that the next descriptor may have
    given_back, asked = [], FakeChip.request_lines

    def request_lines(self, **how):
        given_back.append(not is_open(kept, file))
        return asked(self, **how)

    monkeypatch.setattr(FakeChip, "request_lines", request_lines)
    second.request([A, B, C])
    assert given_back == [True]
    assert len(fake.requests) == 2


def test_a_chip_that_fails_in_the_middle_is_given_back(kernel, monkeypatch, tmp_path):
    fake, make = kernel(gpiochip0=[A, B])

    def fail(self, config):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(FakeRequest, "get_values", fail)
    with pytest.raises(
        WireError, match=r"gpiochip0: the lines cannot be claimed: Input/output error\. `gpioinfo`"
    ):
        make().request([A, B])
    assert [line["by"] for line in fake.chips[str(tmp_path / "gpiochip0")]] == ["", ""]


@pytest.mark.parametrize("use", ["levels", "set"])
def test_a_chip_that_goes_is_a_sentence(kernel, monkeypatch, use):
    _, make = kernel(gpiochip0=[A])
    lines = make()
    lines.request([A])

    def gone(self, values):
        raise OSError(errno.ENODEV, "No such device")

    monkeypatch.setattr(FakeRequest, "get_values" if use == "levels" else "set_values", gone)
    with pytest.raises(WireError, match="do not work any more: No such device"):
        lines.levels() if use == "levels" else lines.set({A: True})


def test_processes_that_hold_lines_are_named(tmp_path):
    for pid, target in {f"{os.getpid()}": "anon_inode:gpio-line", "2": "/dev/null"}.items():
        (tmp_path / pid / "fd").mkdir(parents=True)
        (tmp_path / pid / "fd" / "7").symlink_to(target)
    assert re.fullmatch(rf".*; pid {os.getpid()} \(.+\) holds lines\.", stop_holders(str(tmp_path)))


def test_lines_on_two_chips(kernel):
    _, make = kernel(gpiochip0=[A], gpiochip1=["x", B])
    lines = make()
    assert lines.request([A, B]) == {A: False, B: False}
    lines.set({A: True, B: True})
    assert lines.levels() == {A: True, B: True}


def test_busy_on_the_second_chip_gives_the_first_back(kernel, tmp_path):
    fake, make = kernel(gpiochip0=[A], gpiochip1=["x", B])
    fake.chips[str(tmp_path / "gpiochip1")][1]["by"] = "gpioset"
    with pytest.raises(LineBusyError, match="SODIMM_208 is held by gpioset"):
        make().request([A, B])
    assert fake.chips[str(tmp_path / "gpiochip0")][0]["by"] == ""


def test_ambiguous_name(kernel, tmp_path):
    _, make = kernel(gpiochip0=[A], gpiochip1=["", A])
    with pytest.raises(LineNotFoundError, match=r"gpiochip0 line 0 and .*gpiochip1 line 1"):
        make().request([A])


def test_no_chip(tmp_path):
    with pytest.raises(WireError, match="no GPIO chip") as caught:
        GpiodLines(f"{tmp_path}/gpiochip*").request([A])
    assert "CONFIG_GPIO_CDEV" in str(caught.value)


def test_permission_denied(kernel, monkeypatch):
    fake, make = kernel(gpiochip0=[A])

    def deny(path):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(fake, "Chip", deny)
    with pytest.raises(WireError, match="group gpio"):
        make().request([A])


def test_debians_old_gpiod_is_refused(kernel, monkeypatch):
    fake, make = kernel(gpiochip0=[A])
    monkeypatch.setattr(fake, "api_version", "1.6.3")
    with pytest.raises(WireError, match=r"API 1\.6\.3, needed is 2"):
        make().request([A])


@pytest.mark.skipif(not glob.glob("/dev/gpiochip*"), reason="no GPIO chip on this machine")
def test_the_real_kernel_names_its_chips():
    with pytest.raises(LineNotFoundError, match="gpiochip"):
        GpiodLines().request(["no such line, surely"])


@pytest.mark.parametrize("chip", ["gpiochip3", "mcp23017", "{folder}/by-name"])
def test_a_line_without_a_name_is_found_by_chip_and_offset(kernel, tmp_path, chip):
    fake, make = kernel(gpiochip0=[A, ""], gpiochip3=["", "", ""])
    fake.labels[str(tmp_path / "gpiochip3")] = "mcp23017"
    (tmp_path / "link").mkdir()
    (tmp_path / "link" / "by-name").symlink_to(tmp_path / "gpiochip3")
    line = f"{chip.format(folder=tmp_path / 'link')}:2"
    lines = make()
    assert lines.request([A, line]) == {A: False, line: False}
    lines.set({line: True})
    assert lines.levels() == {A: False, line: True}
    assert [each["level"] for each in fake.chips[str(tmp_path / "gpiochip3")]] == [False, False, True]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("gpiochip7:1", "no chip gpiochip7; there is gpiochip0 [soc], 2 lines; gpiochip1 [exp], 1 lines"),
        ("exp:1", "no offset 1; there is gpiochip1 [exp], 1 lines"),
    ],
)
def test_a_missing_chip_or_offset_is_said_with_what_there_is(kernel, tmp_path, line, said):
    fake, make = kernel(gpiochip0=[A, B], gpiochip1=[""])
    fake.labels |= {str(tmp_path / "gpiochip0"): "soc", str(tmp_path / "gpiochip1"): "exp"}
    with pytest.raises(LineNotFoundError, match=re.escape(f"there is no line {line} ({said}).")):
        make().request([A, line])


def test_two_chips_of_one_label_are_ambiguous(kernel, tmp_path):
    fake, make = kernel(gpiochip1=["", ""], gpiochip2=["", ""])
    fake.labels = dict.fromkeys(fake.chips, "mcp23017")
    with pytest.raises(LineNotFoundError, match=r"mcp23017:1 is ambiguous: .*gpiochip1 line 1 and .*chip2"):
        make().request(["mcp23017:1"])


@pytest.mark.parametrize(
    ("lines", "inputs"),
    [([A, "gpiochip0:0"], []), (["soc:0", "gpiochip0:0"], []), (["gpiochip0:0"], ["absent", A])],
)
def test_one_line_under_two_texts_is_refused_before_anything_is_claimed(kernel, tmp_path, lines, inputs):
    fake, _ = kernel(gpiochip0=[A, B])
    fake.labels[str(tmp_path / "gpiochip0")] = "soc"
    with pytest.raises(WireError, match=r" and .* are one line: .*gpiochip0 line 0\. Give each device"):
        GpiodLines(f"{tmp_path}/*", inputs=inputs).request([B, *lines])
    assert fake.requests == []
