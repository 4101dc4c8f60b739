"""The commands that the development tools add to ``eehal``."""
