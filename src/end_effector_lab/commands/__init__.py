"""The commands that the development tools add to ``eehal``."""

from ._demo import (
    chosen,
    console,
    figures_wanted,
    json_option,
    no_figures_option,
    only_option,
    tell,
)
