"""Apply a function to many items on the processors of this machine or a cluster of dask.distributed."""

from ._workers import LocalWorkers, ShippedAutomata, Workers, open_workers
