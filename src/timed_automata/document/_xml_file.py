"""Reads UPPAAL's XML (the flat 1.x document type of UPPAAL 4 and 5) into a Document, and writes it back."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from html import escape
from pathlib import Path

from timed_automata._limits import FILE_BYTES
from timed_automata.document._document import (
    Document,
    DrawnEdge,
    DrawnLocation,
    Label,
    Note,
    Point,
    StoredQuery,
    Template,
)
from timed_automata.document._text import Span, Text, did_you_mean, fault, refused
from timed_automata.document._xml_tree import Element, read_xml
from timed_automata.errors import ModelError

_NO_MEANING = {"comments"}
_LOCATION_LABELS = {"invariant"} | _NO_MEANING
_EDGE_LABELS = {"select", "guard", "synchronisation", "assignment"} | _NO_MEANING
_IGNORED_LABELS = {
    "exponentialrate": "The rate is ignored: time may pass as the invariants allow.",
    "probability": "The weight is ignored: every branch may be taken.",
    **dict.fromkeys(("testcode", "testcodeEnter", "testcodeExit"), "The test code is ignored."),
}
_REFUSED_ELEMENTS = {
    "lsc": ("a live sequence chart", "Remove it: it changes no verdict about the network."),
    "dynamic": ("a dynamic template", "Put as many processes on the system line as there can be."),
}


def _point(element: Element | None) -> Point | None:
    if element is None or "x" not in element.attributes or "y" not in element.attributes:
        return None
    try:
        return Point(int(element.attributes["x"]), int(element.attributes["y"]))
    except ValueError:
        raise fault(element.place.whole, "The coordinates are no integers.") from None


def _check(element: Element, known: str, *, ordered: bool = True) -> None:
    """Check that all children of an element are known; UPPAAL reads those in ``known`` in this order only."""
    names, last = known.split(), ""
    for child in element.children:
        if child.tag in _REFUSED_ELEMENTS:
            construct, todo = _REFUSED_ELEMENTS[child.tag]
            raise refused(child.place.whole, f"<{child.tag}>, {construct}", todo)
        if child.tag not in names:
            todo = did_you_mean(child.tag, names) or f"Expected <{'>, <'.join(names)}>."
            raise fault(child.place.whole, f"<{child.tag}> is unknown inside <{element.tag}>.", todo)
        if ordered and last and names.index(child.tag) < names.index(last):
            what = f"<{child.tag}> stands behind <{last}> inside <{element.tag}>."
            raise fault(child.place.whole, what, f"UPPAAL reads it only before <{last}>: move it there.")
        last = child.tag


def _attribute(element: Element, name: str) -> str:
    value = element.attributes.get(name)
    if not value:
        raise fault(element.place.whole, f"<{element.tag}> has no attribute '{name}'.")
    return value


def _labels(element: Element, known: set[str]) -> dict[str, Label]:
    labels: dict[str, Label] = {}
    for child in element.all("label"):
        kind, place = _attribute(child, "kind"), child.place.whole
        if not child.text.content.strip():
            continue
        if kind in _IGNORED_LABELS:
            continue
        if kind not in known:
            todo = did_you_mean(kind, known) or f"Expected one of {', '.join(sorted(known))}."
            raise fault(place, f"A label of kind '{kind}' is unknown here.", todo)
        if kind in labels:
            raise fault(place, f"A second label of kind '{kind}'.", "Join the two.")
        labels[kind] = Label(kind, child.text, _point(child))
    return labels


def _location(element: Element) -> DrawnLocation:
    _check(element, "name label urgent committed")
    name = element.one("name")
    return DrawnLocation(
        id=_attribute(element, "id"),
        name=Label("name", name.text, _point(name)) if name and name.text.content.strip() else None,
        at=_point(element),
        labels=_labels(element, _LOCATION_LABELS),
        urgent=element.one("urgent") is not None,
        committed=element.one("committed") is not None,
        color=element.attributes.get("color"),
        place=element.place,
    )


def _reference(element: Element, tag: str, known: Collection[str]) -> str:
    child = element.one(tag)
    if child is None:
        raise fault(element.place.whole, f"<{element.tag}> has no <{tag}>.")
    name = _attribute(child, "ref")
    if name not in known:
        raise fault(child.place.whole, f"<{tag}> refers to the location '{name}', which does not exist.")
    return name


def _edge(element: Element, locations: Collection[str]) -> DrawnEdge:
    _check(element, "source target label nail")
    return DrawnEdge(
        source=_reference(element, "source", locations),
        target=_reference(element, "target", locations),
        labels=_labels(element, _EDGE_LABELS),
        nails=tuple(point for nail in element.all("nail") if (point := _point(nail))),
        color=element.attributes.get("color"),
        place=element.place,
    )


def _branched(edges: list[DrawnEdge], points: Mapping[str, Element]) -> Iterator[DrawnEdge]:
    """Yield every path through a branch point as one edge, and all other edges unchanged."""
    for edge in edges:
        if edge.source in points:
            if edge.target in points:
                raise fault(edge.place.whole, "An edge leads from a branch point to another one.")
            if wrong := edge.labels.keys() & {"select", "guard", "synchronisation"}:
                label = edge.labels[min(wrong)].text.whole
                raise fault(
                    label, f"A branch has a {min(wrong)}.", "Move it to the edge before the branch point."
                )
        elif edge.target not in points:
            yield edge
        else:
            branches = [each for each in edges if each.source == edge.target]
            if not branches:
                place = points[edge.target].place.whole
                raise fault(place, "Nothing leads away from this branch point.")
            for branch in branches:
                yield _way(edge, _point(points[edge.target]), branch)


def _way(first: DrawnEdge, point: Point | None, branch: DrawnEdge) -> DrawnEdge:
    both = first.labels.keys() & branch.labels.keys() & {"assignment"}
    if both:
        label = first.labels["assignment"].text.whole
        raise fault(
            label, "An update before a branch point, and another one behind it.", "Join the two there."
        )
    return DrawnEdge(
        source=first.source,
        target=branch.target,
        labels={**first.labels, **branch.labels},
        nails=(*first.nails, *((point,) if point else ()), *branch.nails),
        color=branch.color or first.color,
        place=branch.place,
    )


def _template(element: Element) -> Template:
    _check(element, "name parameter declaration location branchpoint init transition")
    name = element.one("name")
    if name is None or not name.text.content.strip():
        raise fault(element.place.whole, "A template has no name.")
    locations = tuple(map(_location, element.all("location")))
    points = {_attribute(each, "id"): each for each in element.all("branchpoint")}
    ids: dict[str, str] = {}
    for place, id_ in [
        *((location.place, location.id) for location in locations),
        *((each.place, _attribute(each, "id")) for each in element.all("branchpoint")),
    ]:
        if id_ in ids:
            what = f"A second location has the id '{id_}'; the first stands at {ids[id_]}."
            raise fault(place.whole, what, "Give every location of a template a different id.")
        ids[id_] = place.whole.where
    edges = [_edge(edge, ids.keys()) for edge in element.all("transition")]
    return Template(
        name=name.text,
        parameters=_text(element, "parameter"),
        declarations=_text(element, "declaration"),
        locations=locations,
        edges=tuple(_branched(edges, points)),
        initial=_reference(element, "init", ids.keys() - points.keys()),
        place=element.place,
    )


def _notes(templates: Iterable[Element]) -> Iterator[Note]:
    """Yield a note for every label that is ignored."""
    for template in templates:
        for part in template.children:
            for label in part.all("label"):
                said = _IGNORED_LABELS.get(label.attributes.get("kind", ""))
                if said and label.text.content.strip():
                    yield Note(said, label.place.whole.where)


def _text(element: Element, tag: str) -> Text | None:
    child = element.one(tag)
    return child.text if child else None


def _queries(element: Element | None) -> tuple[StoredQuery, ...]:
    if element is None:
        return ()
    _check(element, "query option", ordered=False)
    queries = []
    for query in element.all("query"):
        formula, comment = _text(query, "formula"), _text(query, "comment")
        if formula and (asked := formula.without_comments()).content.strip():
            queries.append(StoredQuery(asked, comment.content.strip() if comment else ""))
    return tuple(queries)


def read_document(source: bytes, path: str) -> Document:
    """Read a UPPAAL file from its bytes; messages use ``path`` as the name of the file.

    Raises:
        ModelError: the bytes are not XML, incomplete, not a UPPAAL file, or contain elements outside of the subset.
    """
    if len(source) > FILE_BYTES:
        what = f"The file has more than {FILE_BYTES} bytes."
        raise ModelError(what, where=path, todo="Split it, or remove what is not used.")
    root = read_xml(source, path)
    if root.tag != "nta":
        raise fault(root.place.whole, f"The file is <{root.tag}>, not a UPPAAL model.", "Expected <nta>.")
    _check(root, "imports declaration template instantiation system queries")
    imports, system = _text(root, "imports"), _text(root, "system")
    if imports and imports.content.strip():
        raise refused(imports.whole, "<imports>", "Write the declarations in the model.")
    if system is None:
        raise fault(root.place.whole, "The model has no <system>.")
    return Document(
        path=path,
        source=source,
        declarations=_text(root, "declaration"),
        templates=tuple(map(_template, root.all("template"))),
        instantiations=_text(root, "instantiation"),
        system=system,
        queries=_queries(root.one("queries")),
        notes=tuple(_notes(root.all("template"))),
    )


def load_source(path: str | Path) -> bytes:
    """Return the bytes of a UPPAAL file for :func:`read_document`, at most one byte more than that accepts.

    Raises:
        ModelError: the file cannot be read.
    """
    try:
        if Path(path).is_fifo() and not str(path).startswith(("/dev/", "/proc/")):
            raise ModelError("This is a named pipe, not a file.", where=str(path), todo="Give a file.")
        with Path(path).open("rb") as stream:
            return stream.read(FILE_BYTES + 1)
    except OSError as error:
        raise ModelError(f"The file cannot be read: {error.strerror}.", where=str(path)) from None


def load_document(path: str | Path) -> Document:
    """Read a UPPAAL file.

    Raises:
        ModelError: the file cannot be read, or see :func:`read_document`.
    """
    return read_document(load_source(path), str(path))


def write_document(document: Document, replaced: Iterable[tuple[Span, str]] = ()) -> bytes:
    """Return the file's bytes with the given parts of its texts replaced; the rest is unchanged.

    Args:
        document: the document as it was read.
        replaced: parts of its texts, which must not overlap, and their new text.
    """
    result, position = [], 0
    for span, new in sorted(replaced, key=lambda item: item[0].text.byte(item[0].start)):
        start, end = span.text.byte(span.start), span.text.byte(span.end)
        result += [
            document.source[position:start],
            escape(new, quote=False).encode(span.text.encoding, "xmlcharrefreplace"),
        ]
        position = end
    result.append(document.source[position:])
    return b"".join(result)
