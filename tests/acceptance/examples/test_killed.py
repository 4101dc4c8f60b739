"""Tools that are not the paper's are killed: the program, the line arbiter, both at once.

What has to follow is computed from each description by the rules of the kill matrix. Each process dies once in each
state, each time of another tool. CI takes coils over Modbus TCP, two coils, a bistable valve, a tool changer of two
coils and a commanded device, `make nightly` the others. All of it:
`python -m tests.acceptance.kill_matrix.run --ros none --description FILE`.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from tests.acceptance.kill_matrix.cells import BOTH, Cell
from tests.acceptance.kill_matrix.play import Play, Row
from tests.acceptance.kill_matrix.system_plain import PlainSystem
from tests.support.nightly import first_of

from .conftest import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.thinned, pytest.mark.timeout(600)]
KILLED = {
    "remote_io": (("HAL", "GRIPPED"), ("LineArbiter", "GRIPPED"), (BOTH, "RELEASING")),
    "double_acting_jaw": (("HAL", "GRIPPING jaw"), (BOTH, "GRIPPED"), ("LineArbiter", "RELEASING")),
    "bistable_and_magnet": ((BOTH, "GRIPPING magnet"), ("LineArbiter", "GRIPPED"), ("HAL", "RELEASING")),
    "two_coil_changer": (("HAL", "unlocking"), (BOTH, "unlocking")),
    "epick_commanded": (
        ("HAL", "GRIPPED"),
        ("LineArbiter", "RELEASING"),
    ),  # held: it would hear nothing for a second
    "six_cups": (("LineArbiter", "GRIPPING cup_6"), ("HAL", "GRIPPED"), (BOTH, "RELEASING")),
    "two_links": (("HAL", "GRIPPING jaw"), (BOTH, "GRIPPED")),
    "diy_text": (("HAL", "GRIPPED"), ("LineArbiter", "RELEASING")),
    "diy_record": (("HAL", "GRIPPING cups"), (BOTH, "GRIPPED")),
    "diy_vacuum": (("LineArbiter", "GRIPPED"), ("HAL", "RELEASING")),
    "two_epick": (("HAL", "GRIPPING right"), ("LineArbiter", "GRIPPED")),
    "area_gripper": (("HAL", "GRIPPING row_5"), (BOTH, "GRIPPED")),
    "gripper_2f85": (("HAL", "GRIPPED"), (BOTH, "GRIPPED")),
}


def played(name: str, folder: Path) -> list[Row]:
    description = load_tool(ROOT / "examples/tools" / name / "end_effector.yaml")
    with PlainSystem(folder, description) as system:
        return [Play(system, Cell(process, "SIGKILL", state)).run() for process, state in KILLED[name]]


@pytest.fixture(scope="module")
def rows(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[dict[str, list[Row]]]:
    """Of the tools that this run asks for, two at once: most of the time is waiting."""
    folder = tmp_path_factory.mktemp("killed")
    asked = [name for name in KILLED if any(f"[{name}]" in item.nodeid for item in request.session.items)]
    with ThreadPoolExecutor(2) as pool:
        found = pool.map(lambda name: played(name, folder / name), asked)
        yield dict(zip(asked, found, strict=True))


@pytest.mark.parametrize("name", first_of(KILLED, 4, 0))
def test_what_is_declared_happens_and_the_tool_is_usable(name: str, rows: dict[str, list[Row]]) -> None:
    for row in rows[name]:
        assert row.ok, f"{row.cell}: expected {row.expected}; observed {row.observed}"
