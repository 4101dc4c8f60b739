"""The same function on many items at once, on the processors of this machine."""

from ._local import local_workers
from ._open import open_workers
from ._workers import Workers

__all__ = ["Workers", "local_workers", "open_workers"]
