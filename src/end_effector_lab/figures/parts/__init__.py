"""What the figures of runs are made of: a heading, lanes, events, panels, and the page that they stand on."""

from ._events import FOOT_IN, ROW_IN, Event, draw_events, line_of, lined, place_events
from ._heading import SUBTITLE, TITLE, Heading, draw_heading, heading_of, sources
from ._lanes import GAP_IN, Lane, Segment, all_lanes_of, draw_lane, lanes_of, write_lane
from ._page import EDGE_IN, WIDTH_IN, Page, page_of, span_of
from ._panels import Panel, draw_panel, labels_width, panels_of
from ._switches import draw_steps, switch_lanes
from ._watched import CLOCK_IN, clock_labels_width, draw_clock, watched_clocks, watched_lanes
