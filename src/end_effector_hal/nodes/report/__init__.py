"""Reports of the nodes for people: ``/diagnostics``, and the log line about a refused command."""

from ._health import ERROR, OK, WARN, Health, publish_health, silence, standing
from ._refusals import log_refusal
