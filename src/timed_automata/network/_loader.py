"""Makes a network from a file with given constants, and writes it back."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import islice
from pathlib import Path

from timed_automata.compiler import Alias, Constant, GeneratedCode, Scope, Type
from timed_automata.document import Document, did_you_mean, fault, load_document, write_document
from timed_automata.errors import ModelError, UsageError
from timed_automata.language import ast, parse_declarations, parse_instantiations, parse_system
from timed_automata.network._declarations import Declarations, Places
from timed_automata.network._definitions import Definitions
from timed_automata.network._network import Given, Network, State
from timed_automata.network._templates import ParsedTemplate


def load_network(path: str | Path, constants: Mapping[str, Given] | None = None) -> Network:
    """Read a UPPAAL file, check it, and replace the initialisers of its global constants by ``constants``.

    Args:
        path: a UPPAAL XML file.
        constants: values by name; a list (of lists) for an array, in its declared shape. They are inserted before
            sizes are computed: an array whose size depends on a given constant changes its shape.

    Raises:
        ModelError: the file is not valid, or outside of the supported subset; with ``file:line:column``.
        UsageError: a given constant does not exist, or does not fit its declaration.
    """
    return make_network(load_document(path), constants)


def make_network(document: Document, constants: Mapping[str, Given] | None = None) -> Network:
    """Make a network from a document; see :func:`load_network`."""
    try:
        return _make(document, constants or {})
    except (RecursionError, MemoryError, SyntaxError):  # Python's own limits, for generated code as well
        what = "An expression or a function is nested too deeply."
        raise ModelError(what, where=document.path, todo="Break it into parts.") from None


def export(network: Network) -> bytes:
    """Return the network as a UPPAAL file with the given constants inserted; the result is reproducible."""
    return write_document(network.document, network.replaced)


_PREDEFINED = {
    "int8_t": ("INT8", -(1 << 7), (1 << 7) - 1),
    "uint8_t": ("UINT8", 0, (1 << 8) - 1),
    "int16_t": ("INT16", -(1 << 15), (1 << 15) - 1),
    "uint16_t": ("UINT16", 0, (1 << 16) - 1),
    "int32_t": ("INT32", -(1 << 31), (1 << 31) - 1),
}


def _predefined() -> Scope:
    """Return the types that UPPAAL declares before every model, and their limits."""
    scope = Scope()
    for name, (limit, low, high) in _PREDEFINED.items():
        scope.symbols[name] = Alias(name, Type("int", low, high, name=name))
        for suffix, value in (("_MIN", low), ("_MAX", high)) if low else (("_MAX", high),):
            scope.symbols[limit + suffix] = Constant(limit + suffix, Type("int", value, value), (value,), "")
    return scope


def _make(document: Document, given: Mapping[str, Given]) -> Network:
    code, places, globals_ = GeneratedCode(), Places(), Scope(_predefined())
    declarations = Declarations(code, places, globals_, given=given)
    for declaration in parse_declarations(document.declarations) if document.declarations else ():
        declarations.declare(declaration)
    _check_given(given, globals_, document.path)
    definitions = Definitions(code, places)
    for template in document.templates:
        definitions.add_template(ParsedTemplate(template), globals_)
    system = Scope(globals_)
    _instantiate(document, definitions, system)
    definitions.check_unused()
    constants = {
        name: _nested(symbol.values, symbol.type)
        for name, symbol in globals_.symbols.items()
        if isinstance(symbol, Constant)
    }
    globals_.symbols |= system.symbols  # now: no template sees them
    return Network(
        document=document,
        processes=tuple(definitions.processes),
        variables=tuple(places.variables),
        clocks=tuple(places.clocks),
        channels=tuple(places.channels),
        initial=State(tuple(process.initial for process in definitions.processes), tuple(places.initial)),
        offsets=places.offsets,
        constants=constants,
        replaced=tuple(declarations.replaced),
        scope=globals_,
        code=code,
    )


def _check_given(given: Collection[str], scope: Scope, path: str) -> None:
    for name in given:
        symbol = scope.symbols.get(name)
        if symbol is None:
            known = [other for other, found in scope.symbols.items() if isinstance(found, Constant)]
            raise UsageError(f"{path} declares no global constant '{name}'.", todo=did_you_mean(name, known))
        if not isinstance(symbol, Constant):
            raise UsageError(f"'{name}' is not a constant in {path}: it cannot be given.")


def _instantiate(document: Document, definitions: Definitions, scope: Scope) -> None:
    """Process the instantiations and the ``system`` line; only they and queries see the section's own declarations."""
    system = parse_system(document.system)
    older = parse_instantiations(document.instantiations) if document.instantiations else ()
    declarations = Declarations(definitions.code, definitions.places, scope)
    for item in (*older, *system.items):
        if isinstance(item, ast.Instantiation):
            definitions.add_instantiation(item, scope)
        else:
            declarations.declare(item)
    seen: set[str] = set()
    for name in system.processes:
        if name.name in seen:
            raise fault(name.span, f"'{name.name}' stands twice on the system line.")
        seen.add(name.name)
        definitions.instantiate(name, scope)


def _nested(values: tuple[int, ...], type_: Type) -> Given:
    if type_.single:
        return values[0]
    left = iter(values)
    return [_nested(tuple(islice(left, part.size)), part) for _, part in type_.parts]
