"""From YAML to a description, or to every fault that it has, with its place and in words that help."""

from ._examine import examine, examine_text, load
