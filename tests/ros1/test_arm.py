"""``/ArmToolChanger``, the first of two steps of an unlock, where a sensor shows the tool's stand."""

from __future__ import annotations

from typing import Any

import pytest

pytestmark = pytest.mark.ros


def test_arming_is_refused_where_a_sensor_shows_the_stand(system: Any) -> None:
    import rospy
    from std_srvs.srv import Trigger

    answer = rospy.ServiceProxy("ArmToolChanger", Trigger)()
    why = "A sensor (in_stand) shows where the tool is: an unlock needs no arming."
    assert (answer.success, answer.message) == (False, why)
