"""A chip of gpio-sim, as the kernel makes it through configfs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

CONFIG = Path("/sys/kernel/config/gpio-sim")


class SimulatedChip:
    """Lives from entering to leaving, or to `unplug`."""

    def __init__(self, names: Sequence[str], name: str = "chip", label: str = "") -> None:
        self.names, self._chip, self._label = tuple(names), CONFIG / name, label
        self._bank = self._chip / "bank0"

    def __enter__(self) -> SimulatedChip:
        self._bank.mkdir(parents=True)
        (self._bank / "num_lines").write_text(str(len(self.names)))
        if self._label:
            (self._bank / "label").write_text(self._label)
        for number, name in enumerate(self.names):
            (self._bank / f"line{number}").mkdir()
            (self._bank / f"line{number}" / "name").write_text(name)
        (self._chip / "live").write_text("1")
        self.device = Path("/dev") / _text(self._bank / "chip_name")
        platform = Path("/sys/devices/platform") / _text(self._chip / "dev_name")
        self._lines = platform / _text(self._bank / "chip_name")
        return self

    def __exit__(self, *_: object) -> None:
        remove(self._chip)

    def unplug(self) -> None:
        """The chip goes, whoever holds its lines."""
        (self._chip / "live").write_text("0")

    def pull(self, name: str, level: bool) -> None:
        """What an input reads, and an output falls to when it is given back."""
        (self._line(name) / "pull").write_text("pull-up" if level else "pull-down")

    def level(self, name: str) -> bool:
        """Of the pin."""
        return _text(self._line(name) / "value") == "1"

    def _line(self, name: str) -> Path:
        return self._lines / f"sim_gpio{self.names.index(name)}"


def remove(chip: Path) -> None:
    """What stands in configfs, so that another may be made."""
    if _text(chip / "live") == "1":
        (chip / "live").write_text("0")
    for line in chip.glob("bank0/line*"):
        line.rmdir()
    (chip / "bank0").rmdir()
    chip.rmdir()


def _text(path: Path) -> str:
    return path.read_text().strip()
