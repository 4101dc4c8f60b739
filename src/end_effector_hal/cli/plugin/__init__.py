"""``eehal plugin``: packages of one's own in the environment of this product."""

from ._check import report

__all__ = ["report"]
