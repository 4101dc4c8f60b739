"""The recordings that the live page lists: newest first, bounded, whatever stands in the folder; no path leads out."""

from __future__ import annotations

import asyncio
import json
import os
from pathlib import Path
from typing import Any

import pytest
from starlette.applications import Starlette
from starlette.types import ASGIApp

from end_effector_hal.description import profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.page.recorded import _folder
from end_effector_hal.page.recorded._folder import MOST_TABLE_BYTES, list_recordings
from end_effector_hal.page.web import PageAddress, _past
from end_effector_hal.page.web._past import PastRecordings, past_routes
from end_effector_hal.page.web._recordings import make_recordings_app
from end_effector_hal.recording import StatesLog
from tests.support.recorded_tool import RecordedTool
from tests.support.trace_recordings import NEVER, NOMINAL, written


def written_at(folder: Path, log: StatesLog, changed: float) -> Path:
    os.utime(written(folder, log) / "states.csv", (changed, changed))
    return folder


async def asked(app: ASGIApp, path: str, cookie: str = "") -> tuple[int, bytes]:
    """A GET, without a server."""
    headers = [(b"host", b"127.0.0.1:1"), (b"cookie", cookie.encode())]
    scope = {
        "type": "http",
        "http_version": "1.1",
        "method": "GET",
        "path": path,
        "raw_path": path.encode(),
        "root_path": "",
        "query_string": b"",
        "headers": headers,
        "scheme": "http",
        "server": ("127.0.0.1", 1),
    }
    sent: list[Any] = []

    async def receive() -> Any:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Any) -> None:
        sent.append(message)

    await app(scope, receive, send)
    return sent[0]["status"], b"".join(each.get("body", b"") for each in sent[1:])


async def finished(app: ASGIApp, path: str) -> tuple[int, bytes]:
    while (answer := await asked(app, path))[0] == 202:
        await asyncio.sleep(0.05)
    return answer


def test_newest_first_with_how_it_went_and_how_long(tmp_path: Path) -> None:
    written_at(tmp_path / "old", NEVER, 1000.0)
    written_at(tmp_path / "new", NOMINAL, 2000.0)
    found = list_recordings(tmp_path)
    assert found["folder"] == str(tmp_path)
    told = [(each["name"], each["changed"], each["tool"], each["length_s"]) for each in found["recordings"]]
    assert told == [
        ("new", 2000.0, "verdin_gripper", NOMINAL.rows[-1].time_s),
        ("old", 1000.0, "verdin_gripper", NEVER.rows[-1].time_s),
    ]
    stories = [each["story"] for each in found["recordings"]]
    assert stories[0].startswith("Nominal: GRIPPED")
    assert stories[1].startswith("Cylinder never confirmed: grip ABORTED")


def test_a_folder_that_is_a_recording_itself_is_listed(tmp_path: Path) -> None:
    written_at(tmp_path / "run", NOMINAL, 2000.0)
    assert [each["name"] for each in list_recordings(tmp_path / "run")["recordings"]] == ["run"]


def test_what_is_broken_hides_nothing_else(tmp_path: Path) -> None:
    written_at(tmp_path / "good", NOMINAL, 2000.0)
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("x")
    for name, content in (("noise", os.urandom(3000)), ("nothing", b""), ("deep", b"[" * 100_000)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "states.csv").write_bytes(content)
        (tmp_path / name / "run.json").write_bytes(content)
    (tmp_path / "huge").mkdir()
    with (tmp_path / "huge" / "states.csv").open("wb") as file:
        file.truncate(MOST_TABLE_BYTES + 1)
    (tmp_path / "waits").mkdir()
    os.mkfifo(tmp_path / "waits" / "states.csv")
    (tmp_path / "traces").mkdir()
    (tmp_path / "traces" / "hal.mcap").write_bytes(b"x")
    found = {each["name"]: each["story"] for each in list_recordings(tmp_path)["recordings"]}
    assert found.pop("good").startswith("Nominal")
    assert found == {
        "noise": "its states cannot be read: open it",
        "nothing": "its states cannot be read: open it",
        "deep": "its states cannot be read: open it",
        "huge": "long: open it",
        "waits": "long: open it",
        "traces": "only traces: open it",
    }


def test_links_are_not_followed(tmp_path: Path) -> None:
    outside = written_at(tmp_path / "outside", NOMINAL, 2000.0)
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "link").symlink_to(outside)
    (tmp_path / "runs" / "inner").mkdir()
    (tmp_path / "runs" / "inner" / "states.csv").symlink_to(outside / "states.csv")
    (found,) = list_recordings(tmp_path / "runs")["recordings"]
    assert (found["name"], found["length_s"]) == ("inner", None)


def test_hundreds_are_listed_in_bounded_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_folder, "MOST_LISTED", 20)
    for number in range(30):
        written_at(tmp_path / f"run-{number:02}", NOMINAL, 1000.0 + number)
    found = list_recordings(tmp_path, budget_s=0.0)["recordings"]
    assert [each["name"] for each in found] == [f"run-{number:02}" for number in range(29, 9, -1)]
    assert {each["story"] for each in found} == {"not read: there are too many"}
    assert {each["length_s"] for each in list_recordings(tmp_path)["recordings"]} == {NOMINAL.rows[-1].time_s}


def test_a_folder_that_is_not_there_has_none(tmp_path: Path) -> None:
    assert list_recordings(tmp_path / "none")["recordings"] == []


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("past")
    tool = RecordedTool(folder / "runs" / "traced", "nominal")
    tool.run(0.5)
    tool.close()
    written_at(folder / "runs" / "tables", NOMINAL, 1000.0)
    written_at(folder / "secret", NEVER, 1000.0)
    (folder / "runs" / "linked").mkdir()
    (folder / "runs" / "linked" / "states.csv").symlink_to(folder / "secret" / "states.csv")
    return folder / "runs"


@pytest.fixture
def app(runs: Path) -> ASGIApp:
    return Starlette(routes=past_routes(PastRecordings(runs, profile_path())))


@pytest.mark.wall
def test_each_is_opened_by_its_id(app: ASGIApp) -> None:
    async def run() -> None:
        status, body = await asked(app, "/past")
        assert status == 200
        ids = {each["name"]: each["id"] for each in json.loads(body)["recordings"]}
        assert sorted(ids) == ["linked", "tables", "traced"]
        status, body = await asked(app, "/history")
        found = json.loads(body)
        assert (status, found["tool"], found["grips"]) == (200, "verdin_gripper", 1)
        assert "linked" not in str(found["notes"])
        status, body = await asked(app, f"/past/{ids['traced']}/")
        assert status == 200
        assert b"/static/recording.js" in body
        for name in ("traced", "tables"):
            status, body = await finished(app, f"/past/{ids[name]}/recording/0")
            assert status == 200
            assert json.loads(body)["recording"]["name"] == name
        status, body = await finished(app, f"/past/{ids['traced']}/recording/0/verdict")
        assert status == 200
        assert json.loads(body)["traces"]
        status, body = await finished(app, f"/past/{ids['linked']}/recording/0")
        assert (status, body) == (500, b"The recording contains symbolic links, which are not followed.\n")

    asyncio.run(run())


@pytest.mark.wall
@pytest.mark.parametrize("id_", ["0" * 24, "f" * 24])
def test_an_id_that_nothing_has_leads_nowhere(app: ASGIApp, id_: str) -> None:
    async def run() -> tuple[int, bytes]:
        return await finished(app, f"/past/{id_}/recording/0")

    assert asyncio.run(run()) == (404, b"There is no such recording.\n")


@pytest.mark.parametrize(
    "path",
    [
        "/past/../secret/recording/0",
        "/past/..%2fsecret/recording/0",
        "/past/secret/recording/0",
        "/past/%00/recording/0",
        f"/past/{'9' * 5000}/recording/0",
        f"/past/{'0' * 24}/recording/1",
        f"/past/{'0' * 24}/recording/{'9' * 5000}",
        f"/past/{'٠' * 24}/recording/0",
    ],
)
def test_no_address_leads_out_of_the_folder(app: ASGIApp, path: str) -> None:
    assert asyncio.run(asked(app, path))[0] == 404


@pytest.mark.parametrize("number", ["1", "-1", "01", "0x0", "٠", "9" * 5000])
def test_a_recording_that_is_none_is_not_found(number: str) -> None:
    address = PageAddress("127.0.0.1", 1)
    app = make_recordings_app(address, [])
    status, _ = asyncio.run(asked(app, f"/recording/{number}", f"{address.cookie}={address.session}"))
    assert status == 404


@pytest.mark.wall
@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("import time; time.sleep(600)", "The recording was not read within 0.5 s."),
        ("import os; os.abort()", "The recording cannot be read: the process that reads it has ended."),
        ("raise SystemError('x' * 100_000)", "The recording cannot be read: the process that reads it has ended."),
    ],
)  # fmt: skip
def test_a_reader_that_hangs_or_dies_ends_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, said: str
) -> None:
    (tmp_path / "reader_of_this_test.py").write_text(script)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(_past, "_MODULE", "reader_of_this_test")
    monkeypatch.setattr(_past, "READ_S", 0.5 if "sleep" in script else 60.0)

    async def run() -> None:
        past = PastRecordings(tmp_path, profile_path())
        task = past.reading("0" * 24, verdict=False)
        turns = 0
        while not task.done():  # the page goes on meanwhile
            await asyncio.sleep(0.01)
            turns += 1
        assert turns > 1
        with pytest.raises(UsageError, match=said):
            task.result()
        assert not past._children

    asyncio.run(run())


@pytest.mark.wall
def test_how_far_it_is_read_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Until the test has seen it; what is no number is none, and the answer is what was printed."""
    seen = tmp_path / "seen"
    (tmp_path / "reader_of_this_test.py").write_text(
        f"""
import sys, time
from pathlib import Path
for text in ("0.1", "x", "0.42"):
    print("progress", text, file=sys.stderr, flush=True)
while not Path({str(seen)!r}).exists():
    time.sleep(0.01)
print("done", end="")
"""
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(_past, "_MODULE", "reader_of_this_test")

    async def run() -> None:
        past = PastRecordings(tmp_path, profile_path())
        task = past.reading("0" * 24, verdict=False)
        assert task is not None
        while past.progress("0" * 24, verdict=False) != 0.42:
            await asyncio.sleep(0.01)
        app = Starlette(routes=past_routes(past))
        assert await asked(app, f"/past/{'0' * 24}/recording/0") == (202, b'{"progress":0.42}')
        seen.touch()
        assert await task == b"done"
        assert past.progress("0" * 24, verdict=False) is None

    asyncio.run(run())


@pytest.mark.wall
def test_a_reader_that_computes_for_ever_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "reader_of_this_test.py").write_text("while True: pass")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(_past, "_MODULE", "reader_of_this_test")
    monkeypatch.setattr(_past, "MOST_CPU_S", 1)

    async def run() -> bytes:
        return await PastRecordings(tmp_path, profile_path()).listing()

    with pytest.raises(UsageError, match=r"s of processor time\."):
        asyncio.run(run())


READER = """
import os, resource, sys, time
from pathlib import Path
if sys.argv[1] == "list":
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    session = Path("/proc/self/autogroup")  # as not every kernel has it
    print(os.nice(0), 2 ** 28 < limit < 2 ** 33, not session.exists() or session.read_text().endswith(" nice 10\\n"))
else:
    time.sleep(600)
"""


@pytest.mark.wall
def test_a_list_waits_for_no_verdict_and_a_reader_stands_behind_the_tool(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "reader_of_this_test.py").write_text(READER)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(_past, "_MODULE", "reader_of_this_test")

    async def run() -> None:
        past = PastRecordings(tmp_path, profile_path())
        judging = past.reading("0" * 24, verdict=True)
        assert judging is not None
        while not past._children:
            await asyncio.sleep(0.01)
        assert (await past.listing()).split() == [b"%d" % max(os.nice(0), 10), b"True", b"True"]
        assert not judging.done()
        past.close()
        with pytest.raises((asyncio.CancelledError, UsageError)):
            await judging

    asyncio.run(run())
