"""Access to the ROS master; it needs no package of ROS."""

from ._calls import NoSuchMethod, ask_master, ask_node, ask_pid, master_uri
from ._watch import MasterWatch
