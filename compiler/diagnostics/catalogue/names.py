"""Diagnostics of names, types, models, slots and their arguments."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Edit, Label
from bgc.diagnostics.source import Source, Span

_IMPORT = re.compile(r"^(?=import\b)", re.MULTILINE)
_AFTER_COMMENTS = re.compile(r"\ufeff?(?:[ \t]*//(?!/)[^\n]*\n)*(?:[ \t]*\n)*")

# --- declarations -----------------------------------------------------------------------


def duplicate_name(span: Span, name: str, first: Span | None) -> Diagnostic:
    """BG200: a name declared twice"""
    labels = [Label(first, "first declared here")] if first else []
    return error("BG200", f"`{name}` is declared twice", span, labels=labels, help="rename one")


def import_place(source: Source) -> Span:
    """Return the place of a further import: before the first one, else where the text begins.

    Comments that begin the file stay above it.
    """
    found = _IMPORT.search(source.text) or _AFTER_COMMENTS.match(source.text)
    at = found.end() if found else 0
    return Span(source, at, at)


def unknown_type(
    span: Span,
    name: str,
    candidates: Iterable[str],
    library: str | None = None,
    advice: str = "",
) -> Diagnostic:
    """BG201: a type that is not declared"""
    # `advice` is that for a word of a textbook or of another tool, such as OneJunction.
    candidates = list(candidates)
    near = did_you_mean(name, candidates)
    edits = respelt(span, name, candidates)
    if library is not None:
        near = f"import it from the library: `import {library};`"
        if advice:
            near = f"{advice}; or import the library's `{name}`: `import {library};`"
        edits = [Edit(import_place(span.source), f"import {library};\n")]
    return error(
        "BG201",
        f"there is no element, model or interface called `{name}`",
        span,
        help=near or advice or "import the file that declares it",
        edits=edits,
    )


def unknown_domain(
    span: Span, name: str, candidates: Iterable[str], library: Mapping[str, str]
) -> Diagnostic:
    """BG202: a domain that is not declared"""
    candidates = list(candidates)
    help, edits = did_you_mean(name, candidates), respelt(span, name, candidates)
    if name in library:
        statement = f"import {library[name]};"
        help = f"import it from the library: `{statement}`"
        edits = [Edit(import_place(span.source), f"{statement}\n")]
    elif not help:
        known = [each for each, module in library.items() if not module.startswith("examples.")]
        listed = ", ".join(f"`{each}`" for each in sorted(known))
        help = f"the library has {listed}; import the file that declares it, or omit the domain"
    return error("BG202", f"there is no domain called `{name}`", span, help=help, edits=edits)


def not_a_model(span: Span, name: str, what: str) -> Diagnostic:
    """BG203: something other than a model where a model is needed"""
    return error("BG203", f"`{name}` is {what}, not a model", span, help="name a model")


def inheritance_cycle(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG204: a model that extends itself"""
    return error(
        "BG204", f"a model extends itself: {' is '.join(names)}", span, help="remove one `is`"
    )


def contains_itself(span: Span, name: str, path: str, depth: int) -> Diagnostic:
    """BG205: a model that contains itself endlessly"""
    return error(
        "BG205",
        f"`{name}` contains itself, {depth} levels deep",
        span,
        note=f"in `{path}..`",
        help="end the nesting by a dimension and `if n > 1 { .. }`, or use `for`",
    )


def wrong_dimensions(span: Span, name: str, expected: str, given: int) -> Diagnostic:
    """BG206: the wrong number of dimensions"""
    return error(
        "BG206",
        f"`{name}` takes {expected}, not {given}",
        span,
        help="give as many dimensions in brackets as its declaration has",
    )


def name_of_element(span: Span, name: str) -> Diagnostic:
    """BG207: a model with the name of an element"""
    return error(
        "BG207", f"`{name}` is the name of an element", span, help="give the model another name"
    )


# --- names in expressions and paths -----------------------------------------------------


def unknown_member(span: Span, name: str, owner: str, candidates: Iterable[str]) -> Diagnostic:
    """BG210: a part, value or port that does not exist"""
    candidates = list(candidates)
    listing = ", ".join(f"`{c}`" for c in candidates[:12])
    near = did_you_mean(name, candidates) or (
        f"use one of its members: {listing}" if listing else "remove it: there are no members"
    )
    edits = respelt(span, name, candidates)
    return error("BG210", f"{owner} has no `{name}`", span, help=near, edits=edits)


def unknown_name(
    span: Span, name: str, candidates: Iterable[str], advice: str = "", otherwise: str = ""
) -> Diagnostic:
    """BG211: a name that is not declared"""
    # `advice` is given instead of a similar name, `otherwise` where there is no similar name.
    candidates = list(candidates)
    near = did_you_mean(name, candidates)
    way_out = advice or near or otherwise
    way_out = way_out or "declare it, or give its path, for example `boom.mass`"
    edits = [] if advice else respelt(span, name, candidates)
    return error("BG211", f"there is no `{name}` here", span, help=way_out, edits=edits)


def part_by_equals(span: Span, name: str, type_name: str) -> Diagnostic:
    """BG241: a part declared with `=`"""
    return error("BG241", f"the part `{name}` is declared with `=`", span,
                 help=f"write `{name} : {type_name}(..);`")  # fmt: skip


def no_such_index(span: Span, name: str, index: Sequence[int], have: str) -> Diagnostic:
    """BG212: an index that an array does not have"""
    at = ", ".join(str(i) for i in index)
    return error("BG212", f"`{name}[{at}]` does not exist: `{name}` has {have}", span,
                 help="use an index of the array: the first is 1; to make several parts use `for`, "
                 "which includes both ends: `for i in 1..4 { mass[i] : I(m); }`")  # fmt: skip


def needs_index(span: Span, name: str, have: str) -> Diagnostic:
    """BG213: an array of parts where one part is needed"""
    return error("BG213", f"`{name}` needs an index: it is {have}", span, help=f"write `{name}[1]`")


def defined_by_itself(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG214: a value that is defined in terms of itself"""
    return error(
        "BG214",
        f"a value is defined by itself: {' -> '.join(names)}",
        span,
        help="make one of them a `state`, or an `unknown` with an `equation`",
    )


def no_value(span: Span, name: str, kind: str, asked: Span | None) -> Diagnostic:
    """BG218: a value that is not given"""
    way = {
        "param": f"give it where the part is made: `({name} = ..)`, or write a default",
        "const": f"give it where the part is made: `({name} = ..)`, or write its value",
        "input": f"give it where the part is made: `({name} = ..)`, by `drive` in a scene, "
        "or write a default",
        "output": f"write `{name} = ..;` in the model",
        "signal": f"write `{name} = ..;` in the model",
    }.get(kind, f"write `{kind} {name} = ..;`")
    labels = [Label(asked, "declared here")] if asked else []
    return error("BG218", f"{kind} `{name}` has no value", span, labels=labels, help=way)


def given_twice(span: Span, name: str, first: Span) -> Diagnostic:
    """BG220: a value given twice"""
    return error(
        "BG220",
        f"`{name}` is given twice",
        span,
        labels=[Label(first, "first given here")],
        help="remove one of them",
    )


# --- arguments --------------------------------------------------------------------------


def unknown_argument(
    span: Span, name: str, owner: str, candidates: Iterable[str], advice: str = ""
) -> Diagnostic:
    """BG230: an argument that the type does not have"""
    candidates = list(candidates)
    near = did_you_mean(name, candidates)
    listing = ", ".join(f"`{c}`" for c in candidates[:12])
    return error(
        "BG230",
        f"{owner} takes no argument `{name}`",
        span,
        help=advice
        or near
        or (
            f"use one of its arguments: {listing}"
            if listing
            else "remove it: it takes no arguments"
        ),
        edits=respelt(span, name, candidates),
    )


def cannot_be_given(span: Span, name: str, kind: str, candidates: Iterable[str]) -> Diagnostic:
    """BG231: an argument for something that cannot be given"""
    candidates = list(candidates)
    return error(
        "BG231",
        f"`{name}` is {with_article(kind)} of the model and cannot be given from outside",
        span,
        help=did_you_mean(name, candidates)
        or "declare a `param` in the model and use it there; only a param, const, input or slot "
        "can be given",
        edits=respelt(span, name, candidates),
    )


def replaces_other_unit(
    span: Span, name: str, expected: str, found: str, default: Span
) -> Diagnostic:
    """BG266: a value whose unit does not measure the quantity of the default"""
    return error(
        "BG266",
        f"`{name}` must be {expected} as its default is, not {found}",
        span,
        labels=[Label(default, "the default")],
        help="give a value in the unit of the default, or a number alone in SI units",
    )


def positional_argument(span: Span, owner: str, candidates: Iterable[str]) -> Diagnostic:
    """BG232: an argument without its name"""
    names = [f"`{c} = ..`" for c in list(candidates)[:6]]
    return error(
        "BG232",
        f"the arguments of {owner} must be given by name",
        span,
        help=f"write the name: {', '.join(names)}" if names else "remove it: it takes no arguments",
    )


def misplaced_in_loop(span: Span, kind: str) -> Diagnostic:
    """BG238: a declaration that is not allowed in a `for`"""
    return error(
        "BG238",
        f"{with_article(kind)} cannot be declared inside `for`",
        span,
        help="declare it before the loop with a dimension, as `state x[3] = 0;`",
    )


def too_many_ancestors(span: Span, most: int) -> Diagnostic:
    """BG215: a model with too many ancestors"""
    return error(
        "BG215",
        f"this model has more than {most} ancestors by `is`",
        span,
        help="write what they add as parts of one model",
    )


def hides_parameter_of_file(span: Span, name: str, other: Span) -> Diagnostic:
    """BG249: two parameters of one name, of the scene's model and of a file"""
    return error(
        "BG249",
        f"the model's `{name}` has the name of a parameter that its parts use",
        span,
        labels=[Label(other, "the parts use this one")],
        help=f"set the other one in the scene, `set {name} = ..;`, or rename the model's own",
    )
