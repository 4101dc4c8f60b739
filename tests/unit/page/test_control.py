"""One page commands at a time."""

from __future__ import annotations

from end_effector_hal.page.web._control import ControlLease

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
