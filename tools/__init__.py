"""Development tools of this product: they run in a checkout and are in no distribution."""

import sys
from collections.abc import Callable

import click

from end_effector_hal.errors import ReportedError


def run(command: Callable[[], object]) -> None:
    """Run a click command; print an expected error as one sentence."""
    try:
        command()
    except ReportedError as error:
        click.echo(str(error), err=True)
        sys.exit(error.exit_code)
