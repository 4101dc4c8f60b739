"""A proof that takes too much memory is stopped, and what it was asked is open: never true, never false."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.errors import StoppedError
from end_effector_hal.verification.proof import Proof, prove
from end_effector_hal.verification.proof import _memory as memory
from end_effector_hal.verification.proof._memory import GIB, MemoryBound
from tests.unit.timed_automata.explore.models import network
from timed_automata import Network

COUNTS = "P: a: x <= 1 | a -> a; guard: x >= 1; do: n = (n + 1) % 5000, x = 0"


def counting(*queries: tuple[str, str]) -> Network:
    return network("clock x; int[0,4999] n;", COUNTS, queries=queries)


@pytest.fixture
def system(tmp_path: Path) -> Callable[..., Path]:
    """The files of a system: ``proc/meminfo`` and so on, by their paths."""

    def made(**values: str) -> Path:
        files = {"proc/self/status": f"Name:\tpython\nVmRSS:\t{6 * 2**20} kB\n"}
        files |= {path.replace("__", "/"): text for path, text in values.items()}
        for path, text in files.items():
            file = tmp_path / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return tmp_path

    return made


def meminfo(gib: float) -> str:
    return f"MemTotal: 99999999 kB\nMemAvailable:   {round(gib * 2**20)} kB\n"


def stops(root: Path, most_bytes: int | None = None) -> bool:
    try:
        MemoryBound(most_bytes, root).check(1000)
    except StoppedError:
        return True
    return False


@pytest.mark.parametrize(("left_gib", "stopped"), [(2.1, False), (1.9, True)])
def test_three_times_what_the_machine_has_left(
    system: Callable[..., Path], left_gib: float, stopped: bool
) -> None:
    assert stops(system(proc__meminfo=meminfo(left_gib))) == stopped


@pytest.mark.parametrize(("most_gib", "stopped"), [(6.1, False), (5.9, True)])
def test_what_the_user_allows_counts_alone(
    system: Callable[..., Path], most_gib: float, stopped: bool
) -> None:
    assert stops(system(proc__meminfo=meminfo(0)), round(most_gib * GIB)) == stopped


@pytest.mark.parametrize("cached_gib", [0, 1])
@pytest.mark.parametrize("inside", ["/", "/machine/tool"])
def test_what_the_container_has_left(system: Callable[..., Path], inside: str, cached_gib: int) -> None:
    """Of the control group itself, or of one that it is in; what the kernel keeps of files is given up for it."""
    root = system(proc__meminfo=meminfo(100), proc__self__cgroup=f"1:cpu:/\n0::{inside}\n")
    group = root / "sys/fs/cgroup/machine" if inside != "/" else root / "sys/fs/cgroup"
    group.mkdir(parents=True)
    (group / "memory.max").write_text(f"{8 * GIB}\n")
    (group / "memory.current").write_text(f"{int(6.5 * GIB)}\n")
    (group / "memory.stat").write_text(f"anon 1\ninactive_file {cached_gib * GIB}\n")
    assert stops(root) == (not cached_gib)


def test_what_an_older_container_has_left(system: Callable[..., Path]) -> None:
    root = system(
        proc__meminfo=meminfo(100),
        proc__self__cgroup="4:memory:/docker/1\n",
        **{
            "sys__fs__cgroup__memory__memory.limit_in_bytes": str(8 * GIB),
            "sys__fs__cgroup__memory__memory.usage_in_bytes": str(7 * GIB),
            "sys__fs__cgroup__memory__memory.stat": "total_inactive_file 0\n",
        },
    )
    assert stops(root)
    (root / "sys/fs/cgroup/memory/memory.limit_in_bytes").write_text(str(2**63 - 4096))
    assert not stops(root)


@pytest.mark.parametrize("text", ["", "max\n"])
def test_without_a_limit_the_machine_alone_counts(system: Callable[..., Path], text: str) -> None:
    root = system(
        proc__meminfo=meminfo(3), proc__self__cgroup="0::/\n", **{"sys__fs__cgroup__memory.max": text}
    )
    assert not stops(root)


def test_where_nothing_is_said_nothing_stops(tmp_path: Path) -> None:
    assert not stops(tmp_path)
    assert not stops(tmp_path, 1)


def test_this_machine_says_it() -> None:
    assert memory._value(Path("/proc/self/status"), "VmRSS:") > 1_000_000
    assert not stops(Path("/"))
    assert stops(Path("/"), 1_000_000)


def test_nothing_of_a_proof_that_was_stopped_is_decided() -> None:
    proof = prove(counting(("A[] n < 5000", "[range] Small.")), executed=("P",), most_bytes=1)
    assert proof.stopped
    assert not proof.holds
    assert [each.id for each in proof.findings] == [
        "range", "locations", "edges", "channels", "names", "time",
    ]  # fmt: skip
    assert not any(each.decided or each.holds for each in proof.findings)
    assert proof.findings[0].remark.startswith("not decided: stopped after 1,000 states, ")


def test_a_model_without_a_query_does_not_hold_then() -> None:
    assert not prove(counting(), most_bytes=1).holds


def stopped_at(model: Network, words: str) -> Proof:
    def progress(what: str, states: int) -> None:
        if what == words and states:
            raise StoppedError(f"stopped after {states} states")

    return prove(model, progress)


def open_of(proof: Proof) -> list[str]:
    return [each.id for each in proof.findings if not each.decided]


def test_what_was_decided_before_it_was_stopped_stays() -> None:
    model = counting(("A[] n < 4000", "[few]"), ("A[] x <= 1", "[soon]"), ("E[] n <= 4999", "[ever]"))
    proof = stopped_at(model, "the shortest runs")
    assert proof.stopped
    assert open_of(proof) == ["few", "ever"]
    assert {each.id: each.holds for each in proof.findings if each.decided} == {
        "soon": True, "locations": True, "edges": True, "channels": True, "names": True, "time": True,
    }  # fmt: skip


def test_a_response_is_stopped_too() -> None:
    """What follows is looked for within the one exploration, and asked again alone."""
    model = counting(("n == 0 --> n == 4999", "[comes]"))
    assert open_of(stopped_at(model, "all requirements"))[0] == "comes"
    assert prove(model).holds


def test_a_run_out_of_its_range_is_refuted_without_its_run() -> None:
    counts = "P: a: x <= 1 | a -> a; guard: x >= 1; do: n = n + 1, x = 0"
    model = network("clock x; int[0,4999] n;", counts, queries=[("A[] n >= 0", "[least]")])
    proof = stopped_at(model, "the shortest run")
    assert [(each.id, each.decided, each.trace) for each in proof.findings[:1]] == [("ranges", True, None)]
