from __future__ import annotations

import pytest

from end_effector_hal.description import Description, load, profile_path


@pytest.fixture(scope="session")
def verdin() -> Description:
    return load(profile_path())
