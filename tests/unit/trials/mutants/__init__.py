"""The product with one mistake each, which a campaign or the matrix finds."""

from collections.abc import Mapping

from .arbiter import ARBITER
from .controller import CONTROLLER
from .wrong_product import WrongProduct

MUTANTS: Mapping[str, WrongProduct] = {**CONTROLLER, **ARBITER}

__all__ = ["ARBITER", "CONTROLLER", "MUTANTS", "WrongProduct"]
