"""Several sensor links: what a description may say of them, and what each is refused with."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import carrier_of, codec_of, match_codec, period_of, sources_of
from end_effector_hal.description import Description, content_hash, examine_text
from end_effector_hal.signals import Frame, Kind

TEXT = "{port: /dev/a, frame: {text: {}}}"
BUS = "{port: /dev/b, period_ms: 40, stale_s: 0.4, frame: {modbus: {}}}"
CUP = "{link: one, text: {field: 1}, unit: kPa}"
JAW = "{link: two, modbus: {address: 3}}"


def written(links: str, channels: str, more: str = "") -> str:
    return (
        f"name: tool\n{links}\nchannels:\n  {channels}\nsequence: [cup]\n"
        f"actuators: {{cup: {{kind: vacuum, line: A, channel: cup}}}}\nsupply: {{channel: none}}\n{more}"
    )


def tool(links: str, channels: str) -> Description:
    examination = examine_text(written(links, channels), "tool.yaml")
    assert examination.description is not None, examination.lines()
    assert match_codec(examination.description).faults == ()
    return examination.description


def faults(links: str, channels: str) -> list[str]:
    examination = examine_text(written(links, channels), "tool.yaml")
    lines = examination.lines()
    if examination.description is not None:
        lines += [str(each.diagnostic("tool.yaml")) for each in match_codec(examination.description).faults]
    return lines


BOTH = f"links: {{one: {TEXT}, two: {BUS}}}"


def test_each_link_has_its_channels_its_period_and_its_freshness() -> None:
    two = tool(BOTH, f"cup: {CUP}\n  jaw: {JAW}\n  door: {{digital: {{line: B}}}}")
    sources = {source.link: source for source in sources_of(carrier_of(two))}
    assert {link: set(source.channels) for link, source in sources.items()} == {
        "one": {"cup"}, "two": {"jaw"}, None: {"door"}
    }  # fmt: skip
    assert [period_of(carrier_of(two), name) for name in ("cup", "jaw")] == [20_000, 40_000]
    assert [two.freshness_of(link).stale_s for link in ("one", "two", None)] == [0.15, 0.4, 0.15]
    assert two.sensors_are("down", "two") == "sensor link two (/dev/b) is down"
    assert two.sensors_are("down") == "inputs of the board are down"


def test_where_there_is_one_link_a_channel_need_not_say_it() -> None:
    one = tool(f"links: {{left: {TEXT}}}", "cup: {text: {field: 1}, unit: kPa}")
    assert set(codec_of(one).channels) == {"cup"}
    assert one.sensors == "sensor link left (/dev/a)"


def test_two_codecs_of_the_same_name_never_collide() -> None:
    channels = "cup: {link: one, codec: {channel: bottom}}\n  other: {link: two, codec: {channel: bottom}}"
    both = tool("links: {one: {port: /dev/a}, two: {port: /dev/b}}", channels)
    assert dict(carrier_of(both).channels) == {"cup": Kind.PRESSURE, "other": Kind.PRESSURE}
    for link, name in (("one", "cup"), ("two", "other")):
        codec = codec_of(both, link)
        data = codec.encode(Frame(0, 3, 60, {name: -70_000}))
        assert codec.decoder().feed(data, 5) == [Frame(5, 3, 60, {name: -70_000})]


def test_the_only_codec_brings_what_has_no_other_name_under_its_own() -> None:
    one = tool("link: {port: /dev/a}", "cup: {codec: {channel: bottom}}")
    assert set(codec_of(one).channels) == {"cup", "cylinder", "top", "supply", "locked", "unlocked",
        "tool_present", "in_stand", "cylinder_extended", "cylinder_retracted", "estop_ok"}  # fmt: skip


def test_a_polled_codec_asks_by_other_names_too() -> None:
    channels = "cup: {link: one, codec: {channel: vacuum}}\n  other: {link: two, codec: {channel: vacuum}}"
    epick = "codec: modbus-rtu-epick"
    both = tool(f"links: {{one: {{port: /dev/a, {epick}}}, two: {{port: /dev/b, {epick}}}}}", channels)
    codec = codec_of(both, "two")
    decoder = codec.decoder()
    request, _ = decoder.poll(0)  # type: ignore[attr-defined]
    answer = codec.device().answer(request, {"other": -60_000, "cup": -1000})  # type: ignore[attr-defined]
    (frame,) = decoder.feed(answer, 9_000)
    assert frame.values == {"other": -60_000}


def test_fingerprints_of_tools_with_one_link_know_no_names() -> None:
    one = tool("link: {port: /dev/a, frame: {text: {}}}", "cup: {text: {field: 1}, unit: kPa}")
    dumped = one.model_dump(mode="json", by_alias=True)
    assert "links" not in dumped
    assert not {"link", "codec"} & dumped["channels"]["cup"].keys()
    named = tool(f"links: {{left: {TEXT}}}", "cup: {text: {field: 1}, unit: kPa}")
    assert "left" in named.model_dump(mode="json", by_alias=True)["links"]
    assert named.fingerprint() != one.fingerprint()
    virtual = named.with_virtual("/x/chip", "/x/uart")
    assert virtual.links["left"].port == "/x/uart_left"
    assert content_hash(virtual) == content_hash(named)
    assert virtual.fingerprint() != named.fingerprint()


@pytest.mark.parametrize(
    ("links", "channels", "sentence"),
    [
        (f"link: {TEXT}\n{BOTH}", f"cup: {CUP}", "'link' and 'links' exclude each other"),
        ("links: {}", "cup: {digital: {line: B}}", "'links' names no link"),
        ("links:", "cup: {digital: {line: B}}", "'links' has no value"),
        (BOTH, "cup: {text: {field: 1}, unit: kPa}", "the link is missing over which 'cup' comes, expected "
         "link: one or two"),
        (BOTH, f"cup: {{link: onne, text: {{field: 1}}, unit: kPa}}\n  jaw: {JAW}",
         "there is no such link (onne), expected one of one, two; did you mean 'one'?"),
        (f"link: {TEXT}", f"cup: {CUP}", "there is one link, and it has no name"),
        (BOTH, f"cup: {CUP}", "no channel comes over the link, expected channels: {a_name: {link: two, modbus"),
        (BOTH, f"cup: {CUP}\n  jaw: {{link: two, text: {{field: 2}}}}",
         "channel 'jaw' does not fit the frame of the link (text), expected modbus, as links.two.frame declares"),
        (BOTH, f"cup: {CUP}\n  jaw: {JAW}\n  door: {{link: one, digital: {{line: B}}}}",
         "channel 'door' is an input of the board and comes over no link"),
        ("links: {one: {port: /dev/a, frame: {text: {}}}, two: {port: /dev/./a, frame: {modbus: {}}}}",
         f"cup: {CUP}\n  jaw: {JAW}",
         "this port already belongs to link 'one' (/dev/./a), expected a port of its own; devices on one bus "
         "differ by 'unit'"),
        ("links: {one: {port: /dev/a}, two: {port: /dev/b}}",
         "cup: {link: one, codec: {channel: botom}}\n  jaw: {link: two, codec: {channel: locked}}",
         "ees1-ascii carries no such channel (botom)"),
        ("link: {port: /dev/a}", "cup: {codec: {channel: bottom}, unit: kPa}",
         "the codec says what 'cup' means: it has no 'unit'"),
        (f"link: {TEXT}", "cup: {codec: {channel: bottom}}", "does not fit the frame of the link (codec)"),
        ("link: {port: /dev/a}", "cup: {codec: {channel: bottom}}\n  two: {codec: {channel: bottom}}",
         "its place already belongs to 'cup'"),
        ("links: {one: {port: /dev/a, codec: ees2}}", "cup: {codec: {channel: bottom}}", "there is no such codec"),
        (f"links: {{Left: {TEXT}}}", "cup: {text: {field: 1}, unit: kPa}", "Left"),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_one_sentence(links: str, channels: str, sentence: str) -> None:
    found = faults(links, channels)
    assert any(sentence in line for line in found), found
    assert not any("Traceback" in line for line in found)


def test_the_same_place_on_two_links_is_two_places() -> None:
    other = "{port: /dev/c, frame: {text: {}}}"
    two = tool(
        f"links: {{one: {TEXT}, two: {other}}}", f"cup: {CUP}\n  part: {{link: two, text: {{field: 1}}}}"
    )
    assert set(carrier_of(two).channels) == {"cup", "part"}
