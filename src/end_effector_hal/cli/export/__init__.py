"""``eehal export``: writes files about the tool for other programs."""
