"""The commands that the development tools add to ``eehal``."""

from ._demo import (
    chosen,
    console,
    json_option,
    no_figures_option,
    only_option,
    tell,
)
