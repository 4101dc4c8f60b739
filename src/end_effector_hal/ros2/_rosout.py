"""What is logged goes to the logger of a node, and from there to /rosout."""

from __future__ import annotations

import logging
from collections.abc import Callable

from rclpy.node import Node


def writer_of(node: Node) -> Callable[[int, str], None]:
    """A function that writes a text at a level of `logging`."""
    # each place of the code may log at one level only
    logger = node.get_logger()

    def write(level: int, text: str) -> None:
        if level >= logging.ERROR:
            logger.error(text)
        elif level >= logging.WARNING:
            logger.warning(text)
        else:
            logger.info(text)

    return write
