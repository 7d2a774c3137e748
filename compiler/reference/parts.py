"""Declarations of `.bg` files as entries of the reference: models, interfaces, domains, functions.

Ports, parameters, inputs and outputs take their texts from their own `///` comments, else from
those of the interface or model that theirs extends.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence

from bgc.grammar import syntax
from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Code, Entry, Heading, Text, first_sentence, paragraphs
from bgc.resolution.modules import Declared, Module, ancestors, flatten

_MOST_CHARACTERS = 125  # characters of an equation that is shown
_MOST_EQUATIONS = 36  # equations that are shown
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


def declaration_entry(
    declaration: syntax.Declaration, module: Module, name: str, home: str
) -> Entry:
    """Describe a declaration of a file under a name; `home` says where it is declared."""
    body: list[Block]
    match declaration:
        case syntax.Model():
            return _model(module.models[declaration.name], name, home)
        case syntax.Domain():
            body = [variables(declaration)]
            kind = "pseudo domain" if declaration.pseudo else "domain"
        case syntax.Function():
            body = [Code(_statement(declaration))]
            kind = "function"
        case syntax.Value():
            body = [Code(_statement(declaration))] if _is_short(declaration) else []
            kind = "parameter" if declaration.kind == "param" else "constant"
        case syntax.Scene():
            body = [Code(declaration.span.text)]
            kind = "scene"
    return Entry(
        kind,
        name,
        first_sentence(declaration.doc),
        (*paragraphs(declaration.doc), *body, Text(home)),
    )


def _is_short(declaration: syntax.Declaration) -> bool:
    return len(flat_text(declaration.span.text)) <= _MOST_CHARACTERS


def flat_text(text: str) -> str:
    """Return a text of a file on one line, its comments left out."""
    line = " ".join(_COMMENT.sub(" ", text).split())
    return line.replace("( ", "(").replace(" )", ")")


# --- models -----------------------------------------------------------------------------


def _model(declared: Declared[syntax.Model], name: str, home: str) -> Entry:
    model = declared.syntax
    kind = "interface" if model.interface else "model"
    body: list[Block] = [Code(heading(model)), *paragraphs(model.doc)]
    body += [table for table in tables(declared) if table.rows]
    lines = equations(model)
    if lines:
        body += [Heading("parts, bonds and equations"), Code("\n".join(lines))]
    body.append(Text(home))
    return Entry(kind, name, first_sentence(model.doc), tuple(body), _related(declared))


def heading(model: syntax.Model) -> str:
    """Return the first line of a model: `model Compliant[n] is Lock[n]`."""
    text = flat_text(model.span.text).partition("{")[0]
    return text[text.index("interface " if model.interface else "model ") :].strip()


def _related(declared: Declared[syntax.Model]) -> tuple[str, ...]:
    """The model that it extends, the types of its slots, and the domains of its ports."""
    found = [base.syntax.name for base in ancestors(declared)][1:]
    for item, owner in members(declared):
        match item:
            case syntax.Part() if is_slot(item, owner):
                found += [item.type.name, *([item.default.name] if item.default else [])]
            case syntax.Port() if item.domain:
                found.append(item.domain)
            case _:
                pass
    return tuple(dict.fromkeys(found))


def members(
    declared: Declared[syntax.Model],
) -> Iterator[tuple[syntax.Item, Declared[syntax.Model]]]:
    """Yield the items of a model and of the models it extends, those of interfaces left out."""
    line = list(ancestors(declared))
    for owner in reversed(line):
        if owner.syntax.interface and owner is not line[0]:
            continue
        for item in flatten(owner.syntax.items):
            yield item, owner


def is_slot(part: syntax.Part, owner: Declared[syntax.Model]) -> bool:
    """Test for a replaceable part: its type is an interface, or it declares a default."""
    found = owner.module.models.get(part.type.name)
    return part.default is not None or (found is not None and found.syntax.interface)


def text_of(
    item: syntax.Value | syntax.Port | syntax.Part, declared: Declared[syntax.Model]
) -> str:
    """Return the comment of an item, else that of the same name further up the line of `is`."""
    if item.doc:
        return flat_text(item.doc)
    for owner in ancestors(declared):
        for other in owner.syntax.items:
            if (
                isinstance(other, syntax.Value | syntax.Port | syntax.Part)
                and other.name == item.name
                and other.doc
            ):
                return flat_text(other.doc)
    return ""


def tables(declared: Declared[syntax.Model]) -> tuple[Table, ...]:
    """Return ports, parameters, constants, inputs, slots, outputs and states as tables."""
    found = list(members(declared))

    def values(kind: str) -> Iterator[tuple[str, ...]]:
        const = kind == "const"  # those without a comment are not for users
        for item, _ in found:
            if isinstance(item, syntax.Value) and item.kind == kind and (item.doc or not const):
                yield (*_value(item), text_of(item, declared))

    ports = ((*_port(i), text_of(i, declared)) for i, _ in found if isinstance(i, syntax.Port))
    slots = (
        (*_slot(item), text_of(item, declared))
        for item, owner in found
        if isinstance(item, syntax.Part) and is_slot(item, owner)
    )
    shapes = ((_statement(item),) for item, _ in found if isinstance(item, syntax.Shape))
    return (
        Table("ports", ("name", "direction", "domain", "meaning"), tuple(ports)),
        _columns("parameters", values("param"), _VALUE),
        _columns("constants, known when compiled", values("const"), _VALUE),
        _columns("inputs", values("input"), _VALUE),
        Table("slots", ("name", "interface", "default", "meaning"), tuple(slots)),
        _columns("outputs", values("output"), ("name", "unit", "", "", "meaning")),
        _columns("states", values("state"), ("name", "unit", "start", "", "meaning")),
        Table("shapes", ("drawn as",), tuple(shapes)),
    )


_VALUE = ("name", "unit", "default", "range", "meaning")


def _columns(title: str, rows: Iterable[tuple[str, ...]], header: Sequence[str]) -> Table:
    """Make a table of values without the columns that no row fills, or that have no heading."""
    rows = tuple(rows)
    kept = [
        k for k, name in enumerate(header) if name and (name == "name" or any(r[k] for r in rows))
    ]
    return Table(
        title, tuple(header[k] for k in kept), tuple(tuple(r[k] for k in kept) for r in rows)
    )


def _port(port: syntax.Port) -> tuple[str, str, str]:
    direction = port.direction.value if port.direction else "either"
    main = ", main" if port.main else ""
    return port.name + _dims(port.dims), direction + main, port.domain or "any"


def _slot(part: syntax.Part) -> tuple[str, str, str]:
    return part.name, _use(part.type), _use(part.default) if part.default else "must be filled"


def _value(value: syntax.Value) -> tuple[str, str, str, str]:
    within = " .. ".join(flat_text(end.span.text) for end in value.range or ())
    missing = "must be given" if value.kind == "param" else ""
    default = flat_text(value.value.span.text) if value.value is not None else missing
    return value.name + _dims(value.dims), value.unit or "", default, within


def _dims(dims: Sequence[syntax.Expr]) -> str:
    return f"[{', '.join(flat_text(size.span.text) for size in dims)}]" if dims else ""


def _use(use: syntax.TypeUse) -> str:
    return flat_text(use.span.text)


def equations(model: syntax.Model) -> list[str]:
    """Return parts, bonds, laws and definitions of a model, one a line.

    None where they are too many or too long to show.
    """
    lines = [line for item in flatten(model.items) if (line := _equation(item))]
    return (
        lines
        if len(lines) <= _MOST_EQUATIONS and all(len(line) <= _MOST_CHARACTERS for line in lines)
        else []
    )


def _equation(item: syntax.Item) -> str:
    match item:
        case (
            syntax.Chain()
            | syntax.Assign()
            | syntax.Derivative()
            | syntax.Equation()
            | syntax.Project()
        ):
            return _statement(item)
        case syntax.Value() if item.kind in {"let", "signal", "output"} and item.value is not None:
            return _statement(item)
        case syntax.Part() if item.law:
            laws = " ".join(map(_statement, item.law))
            return f"{item.name}{_dims(item.index)} : {_use(item.type)} {{ {laws} }}"
        case syntax.Part():
            filled = f" = {_use(item.default)}" if item.default else ""
            return f"{item.name}{_dims(item.index)} : {_use(item.type)}{filled};"
        case _:
            return ""


def _statement(item: syntax.Item | syntax.LawEquation | syntax.Function) -> str:
    return flat_text(item.span.text).rstrip(";") + ";"


def variables(domain: syntax.Domain) -> Table:
    """Return the efforts, flows and signals of a domain as a table."""
    rows = tuple((v.kind, v.name + _dims(v.dims), v.unit or "") for v in domain.variables)
    return Table("variables of its bonds", ("kind", "name", "unit"), rows)


# --- files --------------------------------------------------------------------------------


def file_doc(text: str) -> str:
    """Return the comment at the head of a file, which an empty line parts from what follows."""
    lines: list[str] = []
    for line in text.splitlines():
        if not line.startswith("///"):
            return "\n".join(lines) if not line.strip() else ""
        lines.append(line.removeprefix("///").strip())
    return ""


def file_entry(module: Module, home: str, title: str) -> Entry:
    """Describe a file: its comment, what it imports and what it declares."""
    doc = file_doc(module.file.source.text)
    body: list[Block] = [*paragraphs(doc)]
    imports = [flat_text(item.span.text) for item in module.file.imports]
    if imports:
        body.append(Code("\n".join(imports)))
    for title_of_kind, of_kind in _KINDS.items():
        rows = tuple(
            (declaration.name, first_sentence(declaration.doc))
            for declaration in module.file.declarations
            if of_kind(declaration)
        )
        body += [Table(title_of_kind, (), rows)] if rows else []
    return Entry(title, home, first_sentence(doc), tuple(body))


_KINDS: dict[str, Callable[[syntax.Declaration], bool]] = {
    "interfaces": lambda d: isinstance(d, syntax.Model) and d.interface,
    "models": lambda d: isinstance(d, syntax.Model) and not d.interface,
    "domains": lambda d: isinstance(d, syntax.Domain),
    "functions": lambda d: isinstance(d, syntax.Function),
    "constants": lambda d: isinstance(d, syntax.Value),
    "scenes": lambda d: isinstance(d, syntax.Scene),
}
