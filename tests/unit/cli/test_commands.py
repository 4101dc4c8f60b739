"""What only another command needs is not loaded; the shell completes commands, options and values; and the help."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._arbiter import arbiter
from end_effector_hal.cli._main import _COMMANDS, _OTHERS, eehal
from end_effector_hal.description import profile_path, tool_path
from end_effector_hal.errors import UsageError
from tests.support.nightly import first_of
from tests.unit.conftest import Whole

HEAVY = {"matplotlib", "numpy", "pydantic", "rich", "ruamel.yaml"}
PROGRAM = {"end_effector_hal.runtime", "end_effector_hal.recording", "timed_automata.execute"}
OURS = {"end_effector_hal.description", "end_effector_lab.figures", *PROGRAM}
CODE = """\
import sys
from end_effector_hal.cli import main
try: main()
except SystemExit as end: code = end.code
print(f"\\n{code}", *sys.modules)
"""


def loaded(*arguments: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", CODE, *arguments], capture_output=True, text=True, check=True
    )
    code, *modules = done.stdout.splitlines()[-1].split()
    assert code == "0", done.stderr
    return set(modules)


@pytest.mark.parametrize("arguments", [("--help",), ("--version",), ("verify", "--help"), ("plot", "--help")])
def test_help_reads_no_description(arguments: tuple[str, ...]) -> None:
    assert not loaded(*arguments) & (HEAVY | OURS)


@pytest.mark.parametrize("package", ["end_effector_hal.arbiter", "end_effector_lab.testbench"])
def test_what_executes_no_automata_does_not_load_them(package: str) -> None:
    code = f"import sys, {package}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert package in done.stdout.split()
    assert PROGRAM.isdisjoint(done.stdout.split())


def test_a_check_loads_nothing_that_draws_or_runs() -> None:
    runs = {"asyncio", "end_effector_hal.arbiter", "end_effector_hal.recording", "end_effector_hal.runtime"}
    assert not loaded("check") & {"matplotlib", "numpy", "end_effector_lab.figures", *runs}


def test_the_styles_are_those_of_the_figures() -> None:
    from end_effector_lab import figures
    from end_effector_lab.commands import _plot

    assert _plot.STYLES == figures.STYLES


LAMP = Path(__file__).parents[1] / "timed_automata" / "models" / "lamp.xml"
POINTS = """\
[end_effector_hal.commands]
absent = nowhere:command
wrong = json:dumps
good = added_command:command
"""
COMMAND = """\
import click
@click.command(short_help="says hello")
def command():
    click.echo("hello")
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    metadata = tmp_path / "added-1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: added\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text(POINTS)
    (tmp_path / "added_command.py").write_text(COMMAND)
    return tmp_path


def run_with(site: Path, *arguments: str) -> tuple[int, str, str]:
    program = [sys.executable, "-c", "from end_effector_hal.cli import main; main()", *arguments]
    env = {**os.environ, "PYTHONPATH": str(site)}
    done = subprocess.run(program, env=env, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def test_the_help_names_all_and_says_which_cannot_be_loaded(site: Path) -> None:
    code, out, err = run_with(site, "--help")
    assert (code, err) == (0, "")
    found = (
        line.split(maxsplit=1)
        for line in out.partition("Added by other distributions:")[2].splitlines()
        if line.split()[1:]
    )
    lines = dict(found)
    assert lines["good"] == "says hello"
    assert lines["absent"].startswith("(the command absent cannot be loaded")
    assert lines["wrong"].startswith("(the command wrong: the entry point must name a click.Command")


def test_one_that_works_runs(site: Path) -> None:
    assert run_with(site, "good") == (0, "hello\n", "")


@pytest.mark.parametrize(
    ("name", "why"), [("absent", "No module named 'nowhere'"), ("wrong", "must name a click.Command")]
)
def test_one_that_is_broken_is_refused_in_a_sentence(site: Path, name: str, why: str) -> None:
    code, _, err = run_with(site, name)
    assert code == 2
    assert why in err
    assert "Traceback" not in err


@pytest.mark.thinned
def test_broken_figures_of_another_hide_not_ours(site: Path, tmp_path: Path) -> None:
    code, _, err = run_with(site, "model", "show", "--model", str(LAMP), "-o", str(tmp_path / "drawings"))
    assert (code, err) == (0, "")


HOW = "DESCRIPTION or --profile NAME"


def test_without_a_tool_it_drives_none() -> None:
    ended = CliRunner().invoke(arbiter, [])
    assert str(ended.exception) == (
        "No tool is named: exactly one tool is needed. Give DESCRIPTION or --profile NAME; "
        "shipped profiles: verdin_gripper."
    )


def test_two_tools_are_one_too_many() -> None:
    ended = CliRunner().invoke(arbiter, ["tool.yaml", "--profile", "verdin_gripper"])
    assert str(ended.exception).startswith("Two tools are named: exactly one tool is needed.")


def test_a_profile_is_named_instead(monkeypatch: pytest.MonkeyPatch) -> None:
    driven: list[Path] = []
    monkeypatch.setattr(
        "end_effector_hal.cli._arbiter.run_arbiter", lambda description, *_: driven.append(description.source)
    )
    assert CliRunner().invoke(arbiter, ["--profile", "verdin_gripper"]).exit_code == 0
    assert driven == [profile_path()]


def test_a_path_becomes_absolute_where_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", "/home/me")
    assert tool_path("tool.yaml", "", how=HOW) == tmp_path / "tool.yaml"
    assert tool_path("~/tool.yaml", "", how=HOW) == Path("/home/me/tool.yaml")
    assert tool_path("", "verdin_gripper", how=HOW) == profile_path()
    with pytest.raises(UsageError, match="no profile is named 'verdin_griper'"):
        tool_path("", "verdin_griper", how=HOW)


# The shell completes commands, options and values, by the script that `eehal completion` prints; and the help.


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
        (("init", "x", "--link", "mod"), {"modbus"}),
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
        (["demo", "--only", "nomnal"], "There is no scenario nomnal. Did you mean 'nominal'? There are: nominal, "),
        (["doctor", "--only", "lin"], "lin (did you mean 'link'?); there are python, "),
    ],
)  # fmt: skip
def test_a_value_that_is_misspelt_is_guessed(typed: list[str], said: str, whole: Whole) -> None:
    code, _, err = whole(*typed)
    assert code == 2
    assert said in err
