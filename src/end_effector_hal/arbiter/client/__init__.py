"""Clients of the arbiter's socket: for programs that write lines, and for the process that reads the sensors."""
