"""The nodes of the HAL in the generation of ROS that this environment has, started once for all checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from end_effector_lab.demo._world import World
from tests.acceptance.contract.driver import Driver
from tests.acceptance.contract.hal import GENERATION, LAYOUTS, Hal, Ros, quick

IN_FIVE = ("test_surface", "test_services", "test_nodes")
"""What depends on whether the nodes share a process: these run in five processes of ROS 2 as well."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    chosen, others = list[pytest.Item](), list[pytest.Item]()
    for item in items:
        layout = getattr(item, "callspec", None) and item.callspec.params.get("running")  # type: ignore[attr-defined]
        if layout == "none":
            item.add_marker(pytest.mark.skip(reason="no ROS here, or its workspace is not sourced"))
        twice = layout == "five" and GENERATION == 2 and item.path.stem not in IN_FIVE
        (others if twice else chosen).append(item)
    config.hook.pytest_deselected(items=others)
    items[:] = chosen


@pytest.fixture(scope="package", params=LAYOUTS.get(GENERATION, ["none"]))
def running(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hal]:
    """The nodes, in one process or in five."""
    folder = tmp_path_factory.mktemp("contract")
    with World(quick(), "nominal", folder) as world:
        ros = Ros(world, folder)
        driver = Driver(GENERATION, {**world.children.env, **ros.env}, folder / "driver.log")
        hal = Hal(world, ros, request.param, driver)
        hal.start_all()
        hal.connect()
        yield hal
        hal.end_all()
        driver.close()


@pytest.fixture
def hal(running: Hal) -> Hal:
    """The running HAL, wherever the check before has left it: a check begins with `rest` or `hold`."""
    running.start_all()
    return running


@pytest.fixture
def resting(hal: Hal) -> Hal:
    """Standing by, with nothing wrong."""
    hal.rest()
    return hal


@pytest.fixture
def holding(hal: Hal) -> Hal:
    """With a part that is held, and nothing wrong."""
    hal.hold()
    return hal


@pytest.fixture
def client(running: Hal) -> Iterator[Callable[[], Driver]]:
    """Starts another client, which is there from then on."""
    drivers: list[Driver] = []

    def start() -> Driver:
        env = {**running.world.children.env, **running.ros.env}
        drivers.append(Driver(GENERATION, env, running.world.folder / f"client-{len(drivers)}.log"))
        return drivers[-1]

    yield start
    for driver in drivers:
        driver.close()
