"""A hardware abstraction layer for robot end-effectors that executes its UPPAAL file as the program."""
