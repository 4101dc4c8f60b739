"""The whole program ``eehal`` in this process."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from end_effector_hal.cli import main

Whole = Callable[..., tuple[int, str, str]]


@pytest.fixture
def whole(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Whole:
    """Runs ``eehal`` with arguments; returns its exit code, output and error output, which is never a traceback."""

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["eehal", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return int(ended.value.code or 0), out, err

    return call
