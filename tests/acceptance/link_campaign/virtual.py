"""Many tools in virtual time, on all processors."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache

from end_effector_hal.control import network_of
from end_effector_hal.description import Description, load, profile_path
from tests.acceptance.link_campaign.episode import Episode, Found
from timed_automata import Network

EACH = 20
CODECS = ("ees1-ascii", "ees1-cobs")


def in_virtual_time(faults: int, seed: int, jobs: int) -> Found:
    """So many faults on as many tools as it takes."""
    found = Found()
    seeds = [seed + number for number in range(-(-faults // EACH))]
    for each in _all(seeds, jobs):
        found.add(each)
    return found


def _all(seeds: list[int], jobs: int) -> Iterator[Found]:
    if jobs == 1:
        yield from map(_episode, seeds)
        return
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(_episode, seeds, chunksize=8)


def _episode(seed: int) -> Found:
    description, network = _tool(CODECS[seed % len(CODECS)])
    return Episode(description, network, seed, EACH).play()


@cache
def _tool(codec: str) -> tuple[Description, Network]:
    shipped = load(profile_path())
    description = shipped.model_copy(update={"link": shipped.link.model_copy(update={"codec": codec})})
    return description, network_of(description)
