"""The parts of the figures of runs: a heading, lanes, events, panels, and the sheet that holds them."""

from ._events import FOOT_IN, ROW_IN, Event, place_events
from ._heading import draw_heading, heading_of
from ._lanes import Lane, Segment, all_lanes_of, lanes_of, write_lane
from ._page import EDGE_IN, WIDTH_IN, Page, need_rows, page_of, span_of
from ._panels import draw_panel, labels_width, panels_of
from ._sheet import AXIS_IN, PANEL_GAP_IN, FigureSheet, draw_lanes, draw_plots
from ._switches import last_switched_s, switch_lanes
from ._watched import CLOCK_IN, clock_labels_width, draw_clock, watched_clocks, watched_lanes
