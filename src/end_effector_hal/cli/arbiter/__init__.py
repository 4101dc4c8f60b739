"""The line arbiter from any terminal: it is started, and asked for a stop, a reset, a reload."""
