"""The nodes of Fig. 4 of the paper, for either ROS: each translates between messages and the core, and decides
nothing.

A transport (``ros1``) starts them and moves their messages; ``transport`` defines the protocol that it must implement.
The nodes of a process share its tool: HALMain's process runs it, and every other one talks to it over its socket.
"""
