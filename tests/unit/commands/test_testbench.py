"""`eehal testbench`: what it lists."""

from __future__ import annotations

import json

from click.testing import CliRunner

from end_effector_lab.commands._testbench import command
from end_effector_lab.testbench import FAULTS


def test_the_list_of_scenarios_is_json_where_that_is_asked() -> None:
    words = CliRunner().invoke(command, ["--list"])
    assert [line.split()[0] for line in words.output.splitlines()] == [fault.usage for fault in FAULTS]
    told = json.loads(CliRunner().invoke(command, ["--list", "--json"]).output)
    assert told["schema_version"] == 1
    assert [each["usage"] for each in told["scenarios"]] == [fault.usage for fault in FAULTS]
