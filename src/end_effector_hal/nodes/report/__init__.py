"""What the nodes report to people: ``/diagnostics``."""

from ._health import ERROR, OK, WARN, Health, publish_health, standing
