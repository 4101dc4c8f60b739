"""Runs the same function on many items at once: on the processors of this machine, or on a cluster of
dask.distributed.
"""

from ._workers import ShippedAutomata, Workers, cluster_workers, local_workers, open_workers
