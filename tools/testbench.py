"""``python -m tools.testbench``: the testbench on the wires of a virtual machine."""

from pathlib import Path

import click

from end_effector_hal.cli import PathName
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_lab.testbench import chosen_models, lines_of, open_ports, open_sensors, run_testbench
from end_effector_lab.testbench.inputs import LineInputs
from tools import run
from tools.board import QemuInputs, pins_of
from tools.virtio_gpio import VirtioGpioInputs


def inputs_of(text: str, tool: Description) -> LineInputs:
    """Return the lines of a virtual machine (``virtio-gpio:SOCKET``) or of the emulated Verdin (``qemu:SOCKET``)."""
    kind, _, socket = text.partition(":")
    if kind == "virtio-gpio" and socket:
        return VirtioGpioInputs(socket, lines_of(tool))
    if kind == "qemu" and socket:
        return QemuInputs(socket, pins_of(tool))
    raise UsageError(
        f"lines cannot be seen at {text!r}.", todo="Expected: virtio-gpio:SOCKET or qemu:SOCKET."
    )


@click.command()
@click.argument("description", type=PathName())
@click.option("--scenario", default="nominal")
@click.option("--events", type=PathName(), required=True)
@click.option("--lines", metavar="virtio-gpio:SOCKET|qemu:SOCKET", required=True)
@click.option("--port", metavar="pty:PATH", required=True)
def command(description: Path, scenario: str, events: Path, lines: str, port: str) -> None:
    """Simulate the tool that DESCRIPTION describes, until SIGTERM."""
    tool = load_tool(description)
    run_testbench(
        tool,
        inputs_of(lines, tool),
        open_ports(port, tool, lines),
        open_sensors(lines, tool),
        models=chosen_models(None, tool),
        scenario=scenario,
        seed=0,
        verbose=False,
        as_json=False,
        events=events,
        for_pages=False,
    )


if __name__ == "__main__":
    run(command)
