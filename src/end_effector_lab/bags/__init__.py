"""Import bags of rosbag and rosbag2 as recordings."""

from ._bag import Bag
from ._import import ImportedBag, import_bag, record_bag

__all__ = ["Bag", "ImportedBag", "import_bag", "record_bag"]
