"""``eehal export``: the tool for other programs."""
