"""The shell completes commands, options and values, by the script that `eehal completion` prints; and the help."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import _COMMANDS, _OTHERS, eehal
from end_effector_hal.description import profile_path
from tests.support.nightly import first_of
from tests.unit.conftest import Whole

TOOL = str(profile_path())


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """``eehal`` in the PATH, as a shell calls it."""
    file = tmp_path / "bin" / "eehal"
    file.parent.mkdir()
    file.write_text(f"#!{sys.executable}\nfrom end_effector_hal.cli import main\nmain()\n")
    file.chmod(0o755)
    return file


def completed(program: Path, *words: str) -> set[str]:
    """What bash proposes for the last word."""
    script = f"""
        PATH={program.parent}:$PATH
        eval "$(eehal completion bash)"
        COMP_WORDS=(eehal {shlex.join(words)}) COMP_CWORD={len(words)}
        _eehal_completion eehal
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=60, check=True)
    assert done.stderr == ""
    return set(done.stdout.split())


@pytest.mark.skipif(not shutil.which("bash"), reason="no bash")
@pytest.mark.parametrize(
    "case",
    first_of([
        (("ver",), {"verify"}),
        (("testbench", "--scenario", "leak:"), {"leak:bottom_vacuum", "leak:top_vacuum"}),
        (("testbench", TOOL, "--scenario", "stuck-release:cylinder,lea"), {"stuck-release:cylinder,leak:top_vacuum"}),
        (("run", TOOL, "--scenario", "leak:"), {"leak:bottom_vacuum", "leak:top_vacuum"}),
        (("run", "--script", "lock;sc"), {"lock;scenario"}),
        (("demo", "--only", "n"), {"nominal", "never-confirms"}),
        (("init", "x", "--actuators", "a:vacuum,b:gr"), {"a:vacuum,b:gripper"}),
        (("init", "x", "--link", "front:mod"), {"front:modbus", "front:modbus-rtu-epick"}),
        (("doctor", "--only", "python,l"), {"python,lines", "python,link"}),
        (("arbiter", "--profile", ""), {"verdin_gripper"}),
        (("completion", ""), {"bash", "zsh", "fish"}),
    ], 2),
)  # fmt: skip
def test_bash_proposes_values(program: Path, case: tuple[tuple[str, ...], set[str]]) -> None:
    words, among = case
    found = completed(program, *words)
    assert among <= found
    assert all(each.startswith(words[-1]) for each in found)


def test_a_description_that_cannot_be_read_has_no_proposals_and_no_traceback(
    program: Path, tmp_path: Path
) -> None:
    (tmp_path / "bad.yaml").write_text("actuators: {")
    assert completed(program, "testbench", str(tmp_path / "bad.yaml"), "--scenario", "leak") == set()


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_have_a_script(shell: str) -> None:
    result = CliRunner().invoke(eehal, ["completion", shell])
    assert (result.exit_code, "_EEHAL_COMPLETE" in result.output) == (0, True)


def test_the_help_is_grouped_by_who_uses_a_command_and_leaves_none_out() -> None:
    lines = CliRunner().invoke(eehal, ["--help"]).output.splitlines()
    titles = [line[:-1] for line in lines if line.endswith(":") and not line.startswith(" ")]
    assert [title for title in titles if title != "Options"] == list(_COMMANDS)
    assert _OTHERS not in titles
    grouped = [name for group in _COMMANDS.values() for name in group]
    assert len(grouped) == len(set(grouped))


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("chek", "check"), ("figure", "plot"), ("tesbench", "testbench"), ("prove", "verify")],
)
def test_a_command_that_is_misspelt_or_called_otherwise_is_guessed(
    typed: str, meant: str, whole: Whole
) -> None:
    code, _, err = whole(typed)
    assert code == 2
    assert f"No such command '{typed}'. Did you mean '{meant}'?" in err


def test_a_name_far_from_all_is_only_refused() -> None:
    result = CliRunner().invoke(eehal, ["xyzzy"])
    assert (result.exit_code, "Did you mean" in result.output) == (2, False)


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (
            ["demo", "--only", "nomnal"],
            "There is no scenario nomnal. Did you mean 'nominal'? There are: nominal, ",
        ),
        (["doctor", "--only", "lin"], "lin (did you mean 'link'?); there are python, "),
    ],
)
def test_a_value_that_is_misspelt_is_guessed(typed: list[str], said: str, whole: Whole) -> None:
    code, _, err = whole(*typed)
    assert code == 2
    assert said in err
