"""A program: checks one subject, and prints a JSON line for each query as soon as it is answered.

``requirements 0``, ``fischer N`` or ``steps N``. A process of its own, so that its peak memory is that of the
subject, and so that it can be ended. Seconds are of the processor: what else the machine does hardly disturbs them.
"""

from __future__ import annotations

import json
import resource
import sys
import time

from end_effector_hal.automata import Network, load_network, make_network, read_document
from end_effector_hal.automata.explore import Explorer
from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path

from ._fischer import fischer

Queries = list[tuple[str, str]]
ATTEMPTS, CONFIRM_MS, RESET_MS, GONE_MS = 3, 5000, 1000, 2000


def main(subject: str, size: str) -> None:
    begun = time.process_time()
    network, queries = _fischer(int(size)) if subject == "fischer" else _tool(int(size))
    explorer = Explorer(network)
    _say(load_s=time.process_time() - begun)
    # the one that takes longest comes last
    for query, sentence in sorted(queries, key=lambda entry: "deadlock" in entry[0]):
        begun, wall = time.process_time(), time.perf_counter()
        verdict = explorer.check(query)
        _say(
            query=query,
            sentence=sentence,
            holds=verdict.holds,
            states=verdict.states,
            seconds=time.process_time() - begun,
            wall_s=time.perf_counter() - wall,
        )


def _fischer(count: int) -> tuple[Network, Queries]:
    text, query = fischer(count)
    return make_network(read_document(text, "fischer.xml")), [(query, "mutual exclusion")]


def _tool(count: int) -> tuple[Network, Queries]:
    """The shipped tool; with ``count`` steps, 0: with its own."""
    description = load(profile_path())
    constants = model_constants(description)
    if count:
        late = description.bounds.reaction_ms
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
    network = load_network(description.automata_path, constants)
    return network, [(query.formula.content, query.comment.strip()) for query in network.document.queries]


def _say(**fields: object) -> None:
    peak_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(json.dumps(fields | {"peak_kib": peak_kib}), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
