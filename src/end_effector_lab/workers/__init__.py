"""The same function on many items at once: on the processors of this machine, or on a cluster of dask.distributed."""

from ._automata import ShippedAutomata
from ._in_a_copy import in_a_copy
from ._local import local_workers
from ._open import cluster_workers, open_workers
from ._workers import Workers
