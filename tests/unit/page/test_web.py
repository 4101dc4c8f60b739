"""Who may ask the page for what, which files there are, and that one page commands at a time."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from end_effector_hal.page import static_file
from end_effector_hal.page.web import PageAddress
from end_effector_hal.page.web._control import ControlLease
from end_effector_hal.page.web._guard import Asked, Guard
from tests.unit.conftest import Whole

ADDRESS = PageAddress("127.0.0.1", 8137)
GUARD = Guard(ADDRESS)
OURS = {"host": "127.0.0.1:8137"}
GET = Asked("GET", "/", OURS, cookie=ADDRESS.session)
MAY = {**OURS, "origin": "http://127.0.0.1:8137", "x-eehal-csrf": ADDRESS.csrf}
POST = Asked("POST", "/command", MAY, cookie=ADDRESS.session)


def status_of(asked: Asked) -> int:
    refusal = GUARD.refuse(asked)
    return refusal.status if refusal else 200


def test_the_token_lets_one_in_and_then_the_cookie_does() -> None:
    assert status_of(replace(GET, cookie="")) == 401
    first = replace(GET, cookie="", token=ADDRESS.token)
    assert status_of(first) == 200
    assert GUARD.lets_in(first)
    assert status_of(GET) == 200
    assert not GUARD.lets_in(GET)


@pytest.mark.parametrize(
    ("asked", "status"),
    [
        (replace(GET, token="guess", cookie=""), 401),
        (replace(GET, cookie=ADDRESS.token), 401),
        (replace(GET, cookie="ü"), 401),
        (replace(GET, path="/events", cookie="", token=ADDRESS.token), 401),
        (replace(POST, cookie="", token=ADDRESS.token), 401),
        (replace(GET, headers={"host": "evil.example:8137"}), 421),
        (replace(GET, headers={"host": "127.0.0.1:80"}), 421),
        (replace(GET, headers={}), 421),
        (replace(GET, headers={**OURS, "origin": "http://evil.example"}), 403),
        (replace(GET, headers={**OURS, "origin": "null"}), 403),
        (replace(GET, headers={**OURS, "sec-fetch-site": "cross-site"}), 403),
        (replace(GET, headers={**OURS, "sec-fetch-site": "same-site", "sec-fetch-mode": "cors"}), 403),
        (replace(POST, headers={**POST.headers, "origin": "http://localhost:8137"}), 403),
        (replace(POST, headers={**POST.headers, "origin": "https://127.0.0.1:8137"}), 403),
        (replace(POST, headers={key: POST.headers[key] for key in ("host", "x-eehal-csrf")}), 403),
        (replace(POST, headers={**POST.headers, "x-eehal-csrf": "guess"}), 403),
        (replace(POST, headers={key: POST.headers[key] for key in ("host", "origin")}), 403),
        (replace(POST, headers={**POST.headers, "sec-fetch-site": "cross-site"}), 403),
        (replace(POST, method="PUT"), 405),
        (replace(POST, method="OPTIONS"), 405),
        (POST, 200),
        (replace(GET, headers={**OURS, "sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}), 200),
        (replace(GET, headers={"host": "localhost:8137"}), 200),
    ],
)
def test_every_rule_refuses(asked: Asked, status: int) -> None:
    assert status_of(asked) == status


SCRAPED = Guard(replace(ADDRESS, scraper="s" * 20))


@pytest.mark.parametrize(
    ("sent", "path", "method", "status"),
    [
        ("Bearer " + "s" * 20, "/metrics", "GET", 200),
        ("bearer " + "s" * 20, "/metrics", "GET", 200),
        ("Bearer " + "s" * 19, "/metrics", "GET", 401),
        ("Basic " + "s" * 20, "/metrics", "GET", 401),
        ("Bearer TOKEN", "/metrics", "GET", 401),
        ("Bearer ü", "/metrics", "GET", 401),
        ("", "/metrics", "GET", 401),
        ("Bearer " + "s" * 20, "/", "GET", 401),
        ("Bearer " + "s" * 20, "/events", "GET", 401),
        ("Bearer " + "s" * 20, "/metrics", "POST", 401),
        ("Bearer " + "s" * 20, "/command", "POST", 401),
    ],
)
def test_a_scraper_reads_the_metrics_and_nothing_else(sent: str, path: str, method: str, status: int) -> None:
    asked = Asked(method, path, {**OURS, "authorization": sent.replace("TOKEN", ADDRESS.token)})
    refusal = SCRAPED.refuse(asked)
    assert (refusal.status if refusal else 200) == status
    assert (refusal is None) or "--metrics-token" in refusal.why or path != "/metrics"
    assert GUARD.refuse(asked) is not None  # none may, unless it was declared
    foreign = replace(asked, headers={**asked.headers, "host": "evil.example:8137"})
    found = SCRAPED.refuse(foreign)
    assert found.status == 421


@pytest.mark.parametrize("content", [b"", b"short", b"two words of a secret\n", b"\xff" * 40, b"x" * 201])
def test_a_secret_is_one_word_of_a_sufficient_length(content: bytes, whole: Whole, tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_bytes(content)
    code, _, err = whole("page", profile_path(), "--metrics-token", secret)
    assert code == 2
    assert "one word of 16 to 200 ASCII characters" in err
    code, _, err = whole("page", profile_path(), "--metrics-token", tmp_path / "none")
    assert code == 2
    assert "cannot be read" in err


@pytest.mark.parametrize(("mode", "warned"), [(0o666, True), (0o604, True), (0o640, False), (0o600, False)])
def test_a_secret_that_every_user_can_read_is_mentioned(
    mode: int, warned: bool, whole: Whole, tmp_path: Path
) -> None:
    secret = tmp_path / "secret"
    secret.write_bytes(b"short")
    secret.chmod(mode)
    _, _, err = whole("page", profile_path(), "--metrics-token", secret)
    assert ("every user of this machine can read the secret" in err) is warned


def test_a_secret_in_a_pipe_or_a_folder_is_refused(whole: Whole, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path):
        code, _, err = whole("page", profile_path(), "--metrics-token", path)
        assert code == 2
        assert "This is no regular file." in err


def test_an_empty_secret_lets_nobody_in() -> None:
    for sent in ("Bearer ", "Bearer"):
        asked = Asked("GET", "/metrics", {**OURS, "authorization": sent})
        assert status_of(asked) == 401
    assert status_of(replace(GET, path="/metrics")) == 200  # a browser with the cookie


def test_beyond_loopback_only_the_names_that_were_given_count() -> None:
    guard = Guard(PageAddress("0.0.0.0", 80, ("cell-7",)))
    for host, served in (
        ("cell-7:80", True),
        ("0.0.0.0:80", True),
        ("localhost:80", False),
        ("10.0.0.9:80", False),
    ):
        refusal = guard.refuse(Asked("GET", "/", {"host": host}))
        assert (refusal is not None and refusal.status != 421) is served


def test_secrets_are_new_at_each_start_and_in_no_repr() -> None:
    one, other = PageAddress("127.0.0.1", 1), PageAddress("127.0.0.1", 1)
    secrets = {one.token, one.session, one.csrf, other.token, other.session, other.csrf}
    assert len(secrets) == 6
    assert not any(secret in repr((one, other)) for secret in secrets)


S = 1_000_000


def test_one_page_at_a_time_until_it_gives_back_or_is_silent() -> None:
    control = ControlLease()
    assert control.take("a", "Page 1", 0).accepted
    refused = control.take("b", "Page 2", 4 * S)
    assert not refused.accepted
    assert refused.reason.startswith("Page 1 has the control")
    assert control.renew("a", 9 * S)
    assert not control.renew("b", 9 * S)
    assert control.holder(18 * S) == "a"
    assert control.shown(18 * S)["name"] == "Page 1"
    assert control.holder(19 * S) == ""
    assert not control.renew("a", 19 * S)
    assert control.take("b", "Page 2", 19 * S).accepted
    control.release("a", 20 * S)
    assert control.holder(20 * S) == "b"
    control.release("b", 20 * S)
    assert control.take("a", "Page 1", 20 * S).accepted


def test_a_file_of_the_page() -> None:
    assert b"import" in (static_file("recording.js") or b"")


@pytest.mark.parametrize(
    "name",
    ["a" * 60_000 + ".js", "no.js", "", ".", "..", "../_html.py", "a\0.js", "\udcff.js", "recording.js/"],
)
def test_there_is_no_such_file(name: str) -> None:
    assert static_file(name) is None
