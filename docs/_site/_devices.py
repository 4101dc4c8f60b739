"""The library of devices: each with its registers, and the documents that confirm them."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description import CONFIRMED, DeviceLibrary, LibraryDevice

from ._markdown import plain, table


def devices() -> str:
    """A table of all shipped devices, then one section for each."""
    found = [
        each for each in map(DeviceLibrary().get, DeviceLibrary().names()) if isinstance(each, LibraryDevice)
    ]
    rows = [
        (f"[`{each.name}`](#{each.name})", plain(each.about.title), each.kind, each.about.confirmed)
        for each in found
    ]
    words = "\n".join(f"- `{word}`: {what}." for word, what in CONFIRMED.items())
    head = table(("Name", "Device", "Kind", "Confirmed"), rows)
    return "\n\n".join([head, words, *(part for each in found for part in _section(each))])


def _section(device: LibraryDevice) -> Iterator[str]:
    about = device.about
    yield f"## {device.name}"
    unit = "" if about.unit is None else f" Unit {about.unit}."
    yield plain(f"{about.title} ({about.maker}): {about.summary or device.kind}.{unit}")
    yield table(
        ("Register", "What", "Document", "Page", "Confirmed"),
        (
            (
                f"`0x{each.address:04X}`"
                + (f" to `0x{each.address + each.count - 1:04X}`" if each.count > 1 else ""),
                plain(each.what),
                str(each.document),
                plain(each.page),
                about.confirmation(each),
            )
            for each in about.registers
        ),
    )
    documents = enumerate(about.documents, start=1)
    yield "Documents:\n\n" + "\n".join(
        f"{number}. [{plain(each.title)}]({each.url})" if each.url else f"{number}. {plain(each.title)}"
        for number, each in documents
    )
    if about.not_confirmed:
        yield "Not confirmed:\n\n" + "\n".join(f"- {plain(each)}" for each in about.not_confirmed)
