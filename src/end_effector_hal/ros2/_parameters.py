"""Parameters: declared by each node, read-only, whatever type they were given as."""

from __future__ import annotations

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from end_effector_hal.nodes.interface import Parameter


def declared(node: Node, parameter: Parameter, default: str = "") -> str:
    """Declare a parameter; its value."""
    descriptor = ParameterDescriptor(description=parameter.about, read_only=True, dynamic_typing=True)
    value = node.declare_parameter(parameter.name, default, descriptor).value
    return "" if value is None else str(value)
