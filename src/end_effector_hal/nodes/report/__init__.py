"""Reports of the nodes for people: ``/diagnostics``."""

from ._health import ERROR, OK, WARN, Health, publish_health, standing
