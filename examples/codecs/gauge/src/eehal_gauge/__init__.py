"""A vacuum gauge on Modbus RTU: unit 5, 10 Pa per count in register 0x0100."""

from end_effector_hal.codecs.modbus import ModbusRtu, Read, Register

cup = Register("cup", scale_pa=10.0, signed=True)
gauge = ModbusRtu(
    "gauge", [Read(unit=5, address=0x0100, registers=(cup,))], baudrate=19_200, period_us=50_000
)
