"""A GPIO chip for a virtual machine: the device side of the guest's gpio-virtio driver, over vhost-user.

Sources: virtio 1.2, sections 2.7 (split virtqueues) and 5.18 (GPIO device); QEMU's vhost-user specification.
"""

from ._inputs import VirtioGpioInputs
from ._pins import Pins
