"""The node Supervisor: gives the commands of Table II, from a prompt or a script."""

from ._supervisor import run_supervisor
