"""Write recordings to one HTML file, and try other thresholds and time-outs on recorded grips."""

from ._attempts import GripCollector
from ._report_html import report_data, report_html, runs_html
from ._tune import Tried, Tuning, tune
