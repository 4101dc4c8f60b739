"""The site of the docs: ``make docs`` builds it. Its source is the whole repository: a link to a file there is one."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(Path(__file__).parent))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = PROJECT["name"]
release = version = PROJECT["version"]
author = project
project_copyright = "Apache-2.0"

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "_site"]
root_doc = "docs/index"
source_suffix = {".md": "markdown"}
include_patterns = ["docs/**", "[!R]*.md", "**/README.md"]
exclude_patterns = [".*", "docs/_*", "build", "ros", "runs", "src"]

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

autodoc_member_order = "groupwise"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True, "imported-members": True, "show-inheritance": True}
default_role = "literal"
suppress_warnings = ["ref.python"]  # two attributes of one name, and an annotation that may mean either
napoleon_use_ivar = True

smartquotes = False
html_theme = "furo"
html_title = f"{project} {version}"
html_extra_path = ["_root"]
html_show_sourcelink = False
html_copy_source = False
