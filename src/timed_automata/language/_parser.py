"""Reads declarations, statements and labels by recursive descent, one method for each construct."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from timed_automata._limits import NESTING, TEXT_CHARACTERS
from timed_automata.document import Span, Text, fault, refused
from timed_automata.language import ast
from timed_automata.language._expressions import OPERAND, ExpressionParser, too_deep
from timed_automata.language._tokens import END, NAME, NO_NAMES

_DEPTH = re.compile(
    rf"//[^\n]*|/\*.*?(?:\*/|\Z)|[([{{}}\])]|(?P<signs>(?:[-+!]\s*|\bnot\s+){{{NESTING + 1}}})", re.DOTALL
)
_PREFIXES = frozenset(("const", "urgent", "broadcast", "meta"))
_TYPES = _PREFIXES | {"bool", "clock", "chan", "void", "int", "scalar", "struct"}
_TYPE = "a type"


class _Parser(ExpressionParser):
    """What the parts of a model are read with; a public method for each kind of text."""

    def declarations(self) -> tuple[ast.Declaration, ...]:
        """Read a section of declarations."""
        found = []
        while not self._at(END):
            found.append(self._declaration())
        return tuple(found)

    def instantiations(self, end: str = END) -> tuple[ast.Declaration | ast.Instantiation, ...]:
        """Read declarations and instantiations: those that older files have before the system section."""
        found: list[ast.Declaration | ast.Instantiation] = []
        while not self._at(end):
            instance = self._followed_by("(", "=")
            found.append(self._instantiation() if instance else self._declaration())
        return tuple(found)

    def system(self) -> ast.System:
        """Read the system section."""
        start = self._token.start
        items = self.instantiations("system")
        self._next()
        processes = self._separated(self._process)
        self._take(";")
        return ast.System(self._span(start), items, processes)

    def _process(self) -> ast.Name:
        name = self._name()
        if self._token.kind in ("<", "<=", ">", ">="):
            self._next()
            span = Span(self._text, self._tokens[self._index - 1].start, self._end)
            raise refused(span, "'<' between processes, a priority", "Separate processes with ','.")
        return name

    def _name(self) -> ast.Name:
        start, word = self._token.start, self._take(NAME)
        return ast.Name(self._span(start), word)

    def _instantiation(self) -> ast.Instantiation:
        start, name = self._token.start, self._next()
        parameters = self._in_brackets(self.parameters) if self._at("(") else ()
        self._take("=")
        template = self._name()
        arguments = self._in_brackets(self.items)
        self._take(";")
        return ast.Instantiation(self._span(start), name, parameters, template, arguments)

    def _declaration(self) -> ast.Declaration:
        if self._at("typedef"):
            return self._typedef()
        start, type_ = self._token.start, self._type()
        if not self._followed_by("("):
            return self._variables(start, type_, self._declarator)
        name, parameters, body = self._next(), self._in_brackets(self.parameters), self._block()
        return ast.FunctionDefinition(self._declared(start, name), type_, name, parameters, body)

    def _variables(
        self, start: int, type_: ast.TypeName, declarator: Callable[[], ast.Declarator]
    ) -> ast.Variables:
        declarators = self._separated(declarator)
        self._take(";")
        return ast.Variables(self._span(start), type_, declarators)

    def _typedef(self) -> ast.TypeDefinition:
        start = self._token.start
        self._next()
        type_, declarators = self._type(), self._separated(self._declarator)
        self._take(";")
        return ast.TypeDefinition(self._span(start), type_, declarators)

    def _declarator(self) -> ast.Declarator:
        start, plain = self._token.start, self._plain()
        if not self._skip("="):
            return plain
        initialiser = self._initialiser()
        return ast.Declarator(self._span(start), plain.name, plain.dimensions, initialiser)

    def _plain(self, start: int | None = None) -> ast.Declarator:
        """Read a declarator without an initialiser."""
        start = self._token.start if start is None else start
        name, dimensions = self._take(NAME), self._dimensions()
        return ast.Declarator(self._declared(start, name), name, dimensions)

    def _dimensions(self) -> tuple[Any, ...]:
        found = []
        while self._skip("["):
            whole = self._token.kind == "int"
            found.append(self._integer(self._token.start) if whole else self.expression())
            self._take("]")
        return tuple(found)

    def _initialiser(self) -> Any:
        start = self._token.start
        if not self._skip("{"):
            return self.expression()
        names, values = zip(*self._separated(self._item), strict=True)
        self._take("}")
        return ast.Braces(self._span(start), values, names)

    def _item(self) -> tuple[str | None, Any]:
        name = None
        if self._followed_by(":"):
            name = self._next()
            self._next()
        return name, self._initialiser()

    def parameters(self) -> tuple[ast.Parameter, ...]:
        """Read any number of parameters."""
        if self._token.kind in _TYPES or self._token.kind == NAME:
            return self._separated(self._parameter)
        self._wanted |= {NAME, _TYPE}
        return ()

    def _parameter(self) -> ast.Parameter:
        start, type_, reference = self._token.start, self._type(), self._skip("&")
        declarator = self._plain(start)
        return ast.Parameter(declarator.span, type_, reference, declarator)

    def _type(self) -> ast.TypeName:
        start, prefixes = self._token.start, []
        while self._token.kind in _PREFIXES:
            prefixes.append(self._next())
        kinds = frozenset(prefixes)
        if self._token.kind == "int":
            return self._integer(start, kinds)
        if self._token.kind not in _TYPES and self._token.kind != NAME:
            raise self._unexpected(NAME, _TYPE)
        word, high = self._next(), None
        fields: tuple[ast.Variables, ...] = ()
        if word == "scalar":
            self._take("[")
            high = self.expression()
            self._take("]")
        elif word == "struct":
            self._take("{")
            fields = (self._field(),)
            while not self._skip("}"):
                fields += (self._field(),)
        return ast.TypeName(self._span(start), word, kinds, None, high, fields)

    def _field(self) -> ast.Variables:
        return self._variables(self._token.start, self._type(), self._plain)

    def _integer(self, start: int, prefixes: frozenset[str] = frozenset()) -> ast.TypeName:
        self._next()
        low = high = None
        if self._skip("["):
            low = self.expression()
            self._take(",")
            high = self.expression()
            self._take("]")
        return ast.TypeName(self._span(start), "int", prefixes, low, high)

    def _bound_variable(self) -> tuple[str, ast.TypeName]:
        name = self._take(NAME)
        self._take(":")
        return name, self._type()

    def selects(self) -> tuple[ast.Select, ...]:
        """Read a select label."""
        return self._separated(self._select)

    def _select(self) -> ast.Select:
        start, (name, type_) = self._token.start, self._bound_variable()
        return ast.Select(self._declared(start, name), name, type_)

    def synchronisation(self) -> ast.Synchronisation:
        """Read a synchronisation label."""
        start, channel = self._token.start, self._postfix()
        if self._token.word not in ("!", "?"):
            raise self._unexpected("!", "?")
        direction = self._next()
        return ast.Synchronisation(self._span(start), channel, direction)

    # Statements

    def _block(self) -> ast.Block:
        start = self._token.start
        self._take("{")
        declarations: list[ast.Declaration] = []
        while self._token.kind in _TYPES or self._token.kind == "typedef" or self._followed_by(NAME):
            declarations.append(self._typedef() if self._at("typedef") else self._local())
        statements = []
        while not self._skip("}"):
            statements.append(self._statement())
        return ast.Block(self._span(start), tuple(declarations), tuple(statements))

    def _local(self) -> ast.Variables:
        return self._variables(self._token.start, self._type(), self._declarator)

    def _statement(self) -> ast.Statement:
        start, kind = self._token.start, self._token.kind
        if kind == "{":
            return self._block()
        if kind == ";" or kind in OPERAND:
            expression = None if kind == ";" else self.expression()
            self._take(";")
            return ast.Evaluate(self._span(start), expression)
        if kind not in ("if", "for", "while", "do", "return"):
            raise self._unexpected("a statement")
        self._next()
        if kind == "if":
            test, yes = self._in_brackets(self.expression), self._statement()
            no = self._statement() if self._skip("else") else None
            return ast.If(self._span(start), test, yes, no)
        if kind == "for":
            return self._for(start)
        if kind == "while":
            test, body = self._in_brackets(self.expression), self._statement()
            return ast.For(self._span(start), (), test, (), body)
        if kind == "do":
            body = self._statement()
            self._take("while")
            test = self._in_brackets(self.expression)
            self._take(";")
            return ast.DoWhile(self._span(start), body, test)
        value = None if self._at(";") else self.expression()
        self._take(";")
        return ast.Return(self._span(start), value)

    def _for(self, start: int) -> ast.For | ast.Iterate:
        self._take("(")
        if self._followed_by(":"):
            variable, type_ = self._bound_variable()
            self._take(")")
            body = self._statement()
            return ast.Iterate(self._span(start), variable, type_, body)
        first = self.items()
        self._take(";")
        test = None if self._at(";") else self.expression()
        self._take(";")
        then = self.items()
        self._take(")")
        body = self._statement()
        return ast.For(self._span(start), first, test, then, body)

    def take_end(self) -> None:
        """Refuse what is left."""
        if not self._at(END):
            raise self._unexpected()


def _check_size(text: Text) -> None:
    """Refuse a text that is too long or too deeply nested before it is parsed."""
    if len(text.content) > TEXT_CHARACTERS:
        what = f"This text has {len(text.content)} characters, more than {TEXT_CHARACTERS}."
        raise fault(text.whole, what, "Break it into parts.")
    depth = 0
    for found in _DEPTH.finditer(text.content):
        token = found.group()
        depth += (token in "([{") - (token in ")]}")
        if depth > NESTING or found.lastgroup == "signs":
            where = Span(text, found.start(), found.start() + 1)
            raise fault(
                where, f"This is nested too deeply, more than {NESTING} deep.", "Break it into parts."
            )


def _name_of_part(text: Text) -> str:
    """Return the name of a template or a location; raise ModelError if UPPAAL does not accept it."""
    name = text.content.strip()
    span = Span(text, at := text.content.find(name), at + len(name))
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_$#]*", name):
        raise fault(span, f"'{span.snippet}' is no name.", "Expected a letter, then letters and digits.")
    if name in NO_NAMES:
        raise fault(span, f"'{name}' is a keyword of UPPAAL, not a name.", "Choose another name.")
    return name


def parse(text: Text, start: str) -> Any:
    """Parse a text as ``start``, a public method of the parser; raise ModelError if the text does not match it."""
    _check_size(text)
    if start == "name_of_part":  # of a template or a location: a word, of no language
        return _name_of_part(text)
    parser = _Parser(text)
    try:
        found = getattr(parser, start)()
        parser.take_end()
    except RecursionError:
        raise too_deep(text) from None
    return found
