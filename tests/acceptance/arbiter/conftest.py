"""A chip and the path of a socket, for each test."""

import pytest

from tests.acceptance.arbiter.bench import Bench


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)
