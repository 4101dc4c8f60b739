"""The command on a changed description, and what is said of the shipped one."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli import _check
from end_effector_hal.description import profile_path

SHIPPED = profile_path().read_text(encoding="utf-8")
Check = Callable[..., Result]

EXCERPT = re.compile(r" *\d* \|( |$)")


def sentences(result: Result) -> list[str]:
    """What is wrong, without the lines of the file and the marks below."""
    return [line for line in result.stderr.splitlines() if not EXCERPT.match(line)]


NO_E_STOP = "no e-stop in the description: IL-13 covers only the software stop"

NIBBLE = {
    "codec: ees1-ascii ": "codec: legacy-nibble ",
    "channel: cylinder\n": "channel: none\n    retracted_bit: none\n",
    "  service: SetToolChanger": "  stand_bit: none\n  present_bit: none",
    "supply:\n": "supply:\n  channel: none\n",
}
"""The shipped tool with the prototype's byte: what that does not carry is declared as none."""
TRANSMITTERS = {
    "codec: ees1-ascii ": "codec: modbus-rtu-transmitters ",
    "channel: cylinder\n": "channel: cylinder\n    extended_bit: none\n    retracted_bit: none\n",
    "  service: SetToolChanger": "  locked_bit: none\n  unlocked_bit: none\n  stand_bit: none\n  present_bit: none",
}


# The command on a changed description.


@pytest.fixture
def check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Check:
    """Runs the command on the shipped description with a text replaced in it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def run(*options: str, replace: dict[str, str] | None = None) -> Result:
        text = SHIPPED
        for old, new in (replace or {}).items():
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        Path("tool.yaml").write_text(text, encoding="utf-8")
        return CliRunner().invoke(_check.command, ["tool.yaml", *options], catch_exceptions=False)

    return run
