"""What the nodes report to people: lines of the log, and ``/diagnostics``."""

from ._health import ERROR, OK, WARN, Health, publish_health
from ._status_lines import StatusLines, transition

__all__ = ["ERROR", "OK", "WARN", "Health", "StatusLines", "publish_health", "transition"]
