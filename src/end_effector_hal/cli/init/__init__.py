"""``eehal init``: writes a folder with a description to start from."""
