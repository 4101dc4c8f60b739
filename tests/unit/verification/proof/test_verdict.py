"""The verdict that is kept: found again for exactly the tool that was proven, by nobody else."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import UsageError
from end_effector_hal.verification.proof import (
    Finding,
    Proof,
    keep_verdict,
    kept_verdict,
    proof_verdict,
)


def proof(*holds: bool | None) -> Proof:
    """One finding each; None: not decided."""
    findings = tuple(
        Finding(f"r{n}", "So.", "", each is True, 1, 0.1, decided=each is not None)
        for n, each in enumerate(holds)
    )
    return Proof(findings, 10, 0.1)


def test_it_is_found_again_for_the_same_tool_only(verdin: Description) -> None:
    assert kept_verdict(verdin) is None
    verdict = proof_verdict(content_hash(verdin), proof(True, True))
    path = keep_verdict(verdict)
    assert kept_verdict(verdin) == verdict
    assert [each.name for each in path.parent.iterdir()] == [f"{content_hash(verdin)}.json"]
    vacuum, *rest = verdin.actuators
    slower = verdin.actuators[vacuum].model_copy(update={"timeout_s": 3.0})
    other = verdin.model_copy(
        update={"actuators": {vacuum: slower, **{each: verdin.actuators[each] for each in rest}}}
    )
    assert kept_verdict(other) is None
    at_another_port = verdin.model_copy(
        update={"link": verdin.link.model_copy(update={"port": "/dev/ttyS9"})}
    )
    assert kept_verdict(at_another_port) == verdict, "a port is no part of what is proven"


def test_what_it_says(verdin: Description) -> None:
    good = replace(proof_verdict(content_hash(verdin), proof(True, True)), at="2026-11-22T10:00:00+01:00")
    assert (good.holds, str(good)) == (True, "All 2 requirements hold (2026-11-22 10:00:00+01:00).")
    bad = replace(proof_verdict(content_hash(verdin), proof(True, False, None)), at="NOW")
    assert (bad.holds, str(bad)) == (False, "Of 3 requirements 1 fail (r1) and 1 are not decided (r2) (NOW).")
    assert not proof_verdict(content_hash(verdin), proof()).holds, "nothing was proven"


@pytest.mark.parametrize(
    "change", [{"hash": "0"}, {"version": "0.0.1"}, {"requirements": "many"}, {"failed": None}]
)
def test_one_that_does_not_fit_is_none(verdin: Description, change: dict[str, object]) -> None:
    path = keep_verdict(proof_verdict(content_hash(verdin), proof(True)))
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    assert kept_verdict(verdin) is None


def test_garbage_and_a_folder_are_none(verdin: Description) -> None:
    path = keep_verdict(proof_verdict(content_hash(verdin), proof(True)))
    for content in (b"", b"\xff" * 200_000, b"[1"):
        path.write_bytes(content)
        assert kept_verdict(verdin) is None
    path.unlink()
    path.mkdir()
    assert kept_verdict(verdin) is None


def test_where_nothing_can_be_written_it_is_said(
    verdin: Description, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    with pytest.raises(UsageError, match="The verdict cannot be stored: it is a link, or no directory"):
        keep_verdict(proof_verdict(content_hash(verdin), proof(True)))
