"""The development tools of the hardware abstraction layer: what is not installed on the robot."""
