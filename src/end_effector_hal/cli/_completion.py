"""``eehal schema`` and ``eehal completion``: proposals for editors and shells, and the completed values of options."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem, get_completion_class

from end_effector_hal.errors import ReportedError, UsageError

if TYPE_CHECKING:
    from end_effector_hal.description import Description


SHELLS = ("bash", "zsh", "fish")
Names = Callable[[click.Context], Iterable[str]]
Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


@click.command("completion")
@click.argument("shell", type=click.Choice(SHELLS), required=False)
def command(shell: str | None) -> None:
    """Print a script for shell completion of commands, options, files and values; SHELL defaults to $SHELL.

    \b
    bash: add to ~/.bashrc    eval "$(eehal completion bash)"
    zsh:  add to ~/.zshrc     eval "$(eehal completion zsh)"
    fish: eehal completion fish > ~/.config/fish/completions/eehal.fish
    """
    from ._main import eehal

    name = shell or Path(os.environ.get("SHELL", "")).name
    if name not in SHELLS:
        raise UsageError(f"The shell {name!r} is not known.", todo=f"Name one of {', '.join(SHELLS)}.")
    found = get_completion_class(name)
    assert found is not None
    if name == "bash":  # else it would complete what follows a colon as a word of its own
        click.echo("COMP_WORDBREAKS=${COMP_WORDBREAKS//:}")
    click.echo(found(eehal, {}, "eehal", "_EEHAL_COMPLETE").source())


def completed(names: Names, *, separator: str = "", after_colon: bool = False) -> Complete:
    """Return a completion function that proposes the names that begin with the typed text.

    Args:
        names: returns all possible names.
        separator: separates the names of a list, of which the last one is completed; "" for a single name.
        after_colon: whether a name that the user chooses and a colon precede the completed name.
    """

    def complete(context: click.Context, _: click.Parameter, typed: str) -> list[CompletionItem]:
        start = typed.rfind(separator) + 1 if separator else 0
        start += len(typed[start:]) - len(typed[start:].lstrip())
        start = max(start, typed.rfind(":") + 1 if after_colon else 0)
        kept, begun = typed[:start], typed[start:]
        try:
            return [CompletionItem(kept + name) for name in names(context) if name.startswith(begun)]
        except (ReportedError, ImportError, OSError):  # a shell wants proposals, no errors
            return []

    return complete


def typed_tool(context: click.Context) -> Description:
    """Return the description that is already typed on the command line, else the shipped one; raises
    DescriptionError.
    """
    from end_effector_hal.description import load, profile_path

    # behind an option without its value, which is being typed, click leaves the arguments as they are
    given = context.params.get("description") or next(iter(context.args), None)
    return load(Path(str(given)) if given else profile_path())


def profiles(_: click.Context) -> Iterable[str]:
    """Propose the names of the shipped tools."""
    from end_effector_hal.description import profile_names

    return profile_names()


def session_words(_: click.Context) -> Iterable[str]:
    """Propose the words of the prompt of `eehal run`."""
    from end_effector_hal.runtime import WORDS

    return WORDS


def client_words(_: click.Context) -> Iterable[str]:
    """Propose the commands of `eehal do`: those of the prompt that do not concern the prompt itself."""
    from end_effector_hal.runtime import WORDS

    return [word for word in WORDS if word not in ("exit", "quit", "reload", "scenario")]


def scenarios(context: click.Context) -> Iterable[str]:
    """Propose the scenarios that the simulated tool can have; none if the simulator is not installed."""
    from .run import possible_scenarios

    return possible_scenarios(typed_tool(context))


@click.command(name="schema")
@click.option(
    "--markdown", "as_markdown", is_flag=True, help="Tables of all keys, as in docs/reference/keys.md."
)
def schema(as_markdown: bool) -> None:
    """Print the JSON Schema (draft 2020-12) of a description.

    An editor uses it when the first line of the YAML file names it: `# yaml-language-server: $schema=FILE`.
    """
    from end_effector_hal.description import markdown, schema_text

    click.echo(markdown() if as_markdown else schema_text(), nl=False)
