"""The second coil of a valve has bits for the values of both commands."""

from __future__ import annotations

import pytest

from end_effector_hal.description import examine_text

TEXT = """
name: lift
link: {{port: /dev/ttyS0, frame: {{modbus: {{}}}}}}
channels: {{up: {{modbus: {{address: 0, register_type: discrete_input}}}}}}
sequence: [lift]
actuators:
  lift:
    kind: cylinder
    channel: none
    extended_bit: up
    retracted_bit: none
    modbus: {{address: 10, bitmask: 3, use_mask_write: true, command_on: [2], command_off: [0],
      opposite: {{address: 20, bitmask: {mask}}}, on_link_loss: hold}}
supply: {{channel: none}}
"""


@pytest.mark.parametrize(("mask", "fits"), [(0x10, False), (0x30, True), (0x70, True)])
def test_bits_of_the_second_coil_that_lack_a_value_of_a_command_are_refused(mask: int, fits: bool) -> None:
    told = "\n".join(examine_text(TEXT.format(mask=mask), "tool.yaml").lines())
    assert ("the commands do not fit into these bits (16)" in told) is not fits
    assert "EE-2" not in told or not fits
