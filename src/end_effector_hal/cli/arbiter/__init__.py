"""Commands for the line arbiter, usable from any terminal: start it, and request a stop, a reset or a reload."""
