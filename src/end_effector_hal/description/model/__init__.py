"""The frozen, typed stanzas of a description."""
