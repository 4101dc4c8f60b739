"""The development tools of the hardware abstraction layer; they are not installed on the robot."""
