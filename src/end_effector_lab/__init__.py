"""The workshop of the hardware abstraction layer: what is not needed on the robot."""
