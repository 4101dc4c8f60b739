"""Runs as root on a machine that systemd has booted with the shipped unit; what it saw is written as JSON."""

import json
import os
import stat
import subprocess
import sys
import time
from itertools import pairwise

from end_effector_hal.arbiter import HAL, ArbiterClient, PredicateSender
from end_effector_hal.description import load
from end_effector_hal.errors import ReportedError
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import read_chip

CHIP, SOCKET, UNIT = "/bench/chip", "/run/eehal/verdin_gripper.sock", "eehal-arbiter@tool"
BOTTOM, CYLINDER, TOP = [actuator.line for _, actuator in load("/etc/eehal/tool.yaml").ordered]
WILL = [(TOP, False, 0), (CYLINDER, False, 600_000), (BOTTOM, False, 1_200_000)]
ACTIVE = dict.fromkeys((BOTTOM, CYLINDER, TOP), True)


def shown(name):
    command = ["systemctl", "show", "-P", name, UNIT]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def levels():
    return {name: state.level for name, state in read_chip(CHIP).lines.items()}


def serves(other_than):
    """Seconds until an arbiter with another pid answers."""
    begin = time.monotonic()
    while time.monotonic() < begin + 30:
        try:
            with ArbiterClient(SOCKET, "check", patience_s=0) as client:
                if client.status()["pid"] != other_than:
                    return time.monotonic() - begin
        except ReportedError:
            pass
        time.sleep(0.05)
    return None


def engage(client, will):
    """What an arbiter does only where the sensors are said to prove it."""
    teller, begin = PredicateSender(SOCKET), time.monotonic()
    while time.monotonic() < begin + 30:
        teller.send({"locked": True, "nothing_gripped": True, "parked": True}, now_us())
        if client.status()["told"]:
            break
    client.set(ACTIVE, will=will)
    teller.close()


def replaced(signal_name):
    """What the death or the standstill of the arbiter does while lines are active."""
    pid = int(shown("MainPID"))
    with ArbiterClient(SOCKET, HAL, ACTIVE) as client:
        engage(client, ())
        subprocess.run(["systemctl", "kill", "-s", signal_name, UNIT], check=True)
        seconds = serves(other_than=pid)
        time.sleep(0.5)
        return {
            "seconds": seconds,
            "levels": levels(),
            "pid_shown": int(shown("MainPID")) != pid,
            "stored": int(shown("NFileDescriptorStore")),
        }


def die():
    """A client that leaves a will that takes 1.2 s, and dies."""
    client = ArbiterClient(SOCKET, HAL, ACTIVE)
    engage(client, WILL)
    os._exit(0)


def stopped():
    """A stop while the will of a client runs."""
    subprocess.run([sys.executable, __file__, "die"], check=True)
    begin = time.monotonic()
    subprocess.run(["systemctl", "stop", UNIT], check=True)
    seconds = time.monotonic() - begin
    with open(CHIP) as log:
        records = [json.loads(line) for line in log if line.strip()][-3:]
    return {
        "seconds": seconds,
        "levels": levels(),
        "order": [record["line"] for record in records],
        "gaps_ms": [round((b["t"] - a["t"]) / 1000) for a, b in pairwise(records)],
        "result": shown("Result"),
    }


def main():
    seen = {"serves": serves(other_than=0), "status": shown("StatusText"), "active": shown("ActiveState")}
    served_at = time.monotonic() - (time.time() - os.stat(SOCKET).st_ctime)
    seen["active_after_ms"] = int(shown("ActiveEnterTimestampMonotonic")) / 1000 - 1000 * served_at
    for path in (SOCKET, "/run/eehal"):
        status = os.stat(path)
        seen[path] = [stat.filemode(status.st_mode), status.st_gid]
    seen["stored"], seen["journal"] = int(shown("NFileDescriptorStore")), os.listdir("/var/lib/eehal-arbiter")
    seen["SIGKILL"] = replaced("KILL")
    seen["SIGSTOP"] = replaced("STOP")
    seen["stop"] = stopped()
    return seen


if __name__ == "__main__":
    if sys.argv[1] == "die":
        die()
    with open(sys.argv[1], "w") as file:
        json.dump(main(), file)
