"""A program that checks one subject and prints a JSON line for each query as soon as it is answered.

``together 0`` (the shipped tool, as in ``eehal verify``), ``alone 0`` (each of its requirements separately), ``fischer
N`` or ``steps N``. It is a separate process, so that its peak memory is that of the subject, and so that it can be
ended. Seconds are processor time, which other load hardly affects.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.verification.proof import prove, requirements_of
from timed_automata import Network, load_network, make_network, read_document
from timed_automata.explore import Explorer

_MODEL = """<nta>
<declaration>int[0, {count}] id;</declaration>
<template><name>P</name><parameter>const int[1, {count}] pid</parameter>
<declaration>clock x;</declaration>
<location id="a"><name>Idle</name></location>
<location id="b"><name>Request</name><label kind="invariant">x &lt;= 2</label></location>
<location id="c"><name>Wait</name></location>
<location id="d"><name>Critical</name></location>
<init ref="a"/>
<transition><source ref="a"/><target ref="b"/>
<label kind="guard">id == 0</label><label kind="assignment">x = 0</label></transition>
<transition><source ref="b"/><target ref="c"/>
<label kind="guard">x &lt;= 2</label><label kind="assignment">x = 0, id = pid</label></transition>
<transition><source ref="c"/><target ref="b"/>
<label kind="guard">id == 0</label><label kind="assignment">x = 0</label></transition>
<transition><source ref="c"/><target ref="d"/>
<label kind="guard">x &gt; 2 &amp;&amp; id == pid</label></transition>
<transition><source ref="d"/><target ref="a"/>
<label kind="assignment">id = 0</label></transition>
</template>
<system>system P;</system>
</nta>"""

"""Fischer's protocol for mutual exclusion, written from the literature (Lamport 1987), in UPPAAL's format."""

EXCLUSION = "A[] forall (i : int[1, {count}]) forall (j : int[1, {count}]) P(i).Critical && P(j).Critical imply i == j"


ATTEMPTS, CONFIRM_MS, RESET_MS, GONE_MS = 3, 5000, 1000, 2000


class Task(NamedTuple):
    """A query to answer: ``run`` returns whether it holds, and the number of states."""

    query: str
    sentence: str
    run: Callable[[], tuple[bool, int]]


def main(subject: str, size: str) -> None:
    begun = time.process_time()
    tasks = list({"fischer": _fischer, "alone": _alone}.get(subject, _together)(int(size)))
    _say(load_s=time.process_time() - begun)
    for query, sentence, run in tasks:
        begun, wall = time.process_time(), time.perf_counter()
        holds, states = run()
        _say(
            query=query,
            sentence=sentence,
            holds=holds,
            states=states,
            seconds=time.process_time() - begun,
            wall_s=time.perf_counter() - wall,
        )


def _fischer(count: int) -> Iterator[Task]:
    network = make_network(read_document(_MODEL.format(count=count).encode(), "fischer.xml"))
    yield _task(network, EXCLUSION.format(count=count), "mutual exclusion")


def _alone(count: int) -> Iterator[Task]:
    network = _tool(count)
    for requirement in requirements_of(network):
        yield _task(network, str(requirement.query), requirement.sentence)


def _task(network: Network, query: str, sentence: str) -> Task:
    def run() -> tuple[bool, int]:
        verdict = Explorer(network).check(query)
        return verdict.holds, verdict.states

    return Task(query, sentence, run)


def _together(count: int) -> Iterator[Task]:
    network = _tool(count)

    def run() -> tuple[bool, int]:
        proof = prove(network)
        return proof.holds, proof.states

    yield Task("", "all requirements, in one exploration", run)


def _tool(count: int) -> Network:
    """Return the shipped tool with ``count`` steps; 0: with its own."""
    description = load(profile_path())
    constants = model_constants(description)
    if count:
        late = description.bounds.reaction_ms
        constants |= {name: each[:1] * count for name, each in constants.items() if isinstance(each, list)}
        constants |= {
            "N": count,
            "ATTEMPTS": [ATTEMPTS] * count,
            "T_CONFIRM": [CONFIRM_MS] * count,
            "T_RESET": [RESET_MS] * count,
            "T_GONE": [GONE_MS] * count,
            "RELEASE_ORDER": list(range(count))[::-1],
        }
        waits = ATTEMPTS * (CONFIRM_MS + late) + (ATTEMPTS - 1) * (RESET_MS + late)
        release = count * (GONE_MS + late)
        bounds = {"GRIP": count * waits + release, "RELEASE": release, "CANCEL": release}
        declared = description.automata_path.read_text(encoding="utf-8")
        # with so many steps a grip may take longer than the shipped tool's
        constants |= {f"{name}_BOUND": ms for name, ms in bounds.items() if f"{name}_BOUND" in declared}
    return load_network(description.automata_path, constants)


def _say(**fields: object) -> None:
    print(json.dumps(fields | {"peak_kib": _peak_kib()}), flush=True)


def _peak_kib() -> int:
    """Return the peak memory of this program; `getrusage` would include the memory of its parent."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))


if __name__ == "__main__":
    main(*sys.argv[1:])
