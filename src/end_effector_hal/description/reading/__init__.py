"""Reads a description from YAML, or finds every fault that it has, with its place and a helpful message."""
