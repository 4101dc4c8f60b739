"""``eehal doctor``: lists what this machine lacks to run a tool."""
