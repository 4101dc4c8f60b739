"""Bags of rosbag and rosbag2, read into recordings."""

from ._bag import open_bag
from ._import import ImportedBag, import_bag, record_bag

__all__ = ["ImportedBag", "import_bag", "open_bag", "record_bag"]
