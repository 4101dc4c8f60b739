"""The hardware abstraction layer for robot end-effectors whose UPPAAL file is the program."""
