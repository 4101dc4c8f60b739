"""Reports of the nodes for people: ``/diagnostics``, and the log line about a refused command."""

from ._health import ERROR, OK, WARN, Health, level_of, publish_health, silence
from ._refusals import logged
