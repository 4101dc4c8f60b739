"""A whole tool in virtual time: the program, the line arbiter with its records, sensors and testbench, from one seed.

>>> from end_effector_hal.description import load, profile_path
>>> tool = VirtualTool(load(profile_path()))
>>> tool.run(1.0)
>>> tool.command("grip").accepted
True
>>> tool.run_until(60_000_000, lambda: tool.status.held)
True
"""

from ._arbiter import Edge, Switching, switchings
from ._tool import VirtualTool, Watch
