"""The nodes of Fig. 4 of the paper, for either ROS: each translates between messages and the core, and decides
nothing.

A transport (``ros1``) starts them and moves their messages; ``transport`` defines the protocol that it must implement.
"""

from ._start import PROGRAMS, start_node
