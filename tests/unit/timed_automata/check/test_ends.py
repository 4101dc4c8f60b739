"""Who stands at the ends of a channel."""

from __future__ import annotations

import tracemalloc

from end_effector_hal.description import profile_path
from tests.unit.timed_automata.explore.models import Template, network
from timed_automata import load_network
from timed_automata.check import channel_ends


def test_both_ends_are_told_by_template():
    model = network(
        "broadcast chan b[3]; urgent chan u; chan unused;",
        Template(
            "P",
            ["a -> b; select: n : int[0,1]; sync: b[n]!", "b -> a; sync: u!", "a -> a; sync: b[id]?"],
            parameters="const int[0,1] id",
        ),
        Template("Q", ["a -> b; sync: u?", "a -> a; select: n : int[0,2]; sync: b[n]?"]),
    )
    b, u, unused = channel_ends(model)
    assert (b.name, b.broadcast, b.urgent, b.senders, b.receivers) == (
        "b[3]",
        True,
        False,
        ("P",),
        ("P", "Q"),
    )
    assert (b.unsent, b.unreceived) == (("b[2]",), ())
    assert (u.name, u.broadcast, u.urgent, u.senders, u.receivers) == ("u", False, True, ("P",), ("Q",))
    assert (unused.senders, unused.receivers, unused.unsent) == ((), (), ("unused",))


def test_many_edges_that_may_use_any_of_many_channels_take_little_memory():
    edge = "a -> a; select: i : int[0,63]; sync: call[x][y]"
    model = network(
        "chan call[64][64]; int[0,63] x, y;", Template("P", [f"{edge}!"]), Template("Q", [f"{edge}?"])
    )
    tracemalloc.start()
    (call,) = channel_ends(model)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (call.senders, call.receivers, call.unsent, call.unreceived) == (("P",), ("Q",), (), ())
    assert peak < 5_000_000


def test_every_channel_of_the_shipped_model_has_both_ends():
    ends = channel_ends(load_network(profile_path().with_name("end_effector.xml")))
    assert [each.name for each in ends if each.unsent or each.unreceived] == []
    names = [each.name for each in ends]
    assert names[:3] == ["confirmed[3]", "partial[3]", "gone[3]"]
