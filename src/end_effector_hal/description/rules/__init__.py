"""Rules that no single value can break: between stanzas, and between a description and its codec."""
