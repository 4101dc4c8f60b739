"""``eehal doctor``: what this machine lacks to run a tool."""
