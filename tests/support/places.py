"""Where the files of the project stand."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[2]
DEPLOY = ROOT / "deploy"
DOCS = ROOT / "docs"
WRITTEN_OUT = Path(__file__).with_name("written_out")
"""Two examples with the registers of their devices written out: a simulation plays what they say, not the device."""
