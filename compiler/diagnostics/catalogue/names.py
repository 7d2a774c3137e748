"""Diagnostics: names, types, models and arguments."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from bgc.diagnostics.catalogue import Values, did_you_mean, error, nearest, quoted, respelt
from bgc.diagnostics.diagnostic import Edit
from bgc.diagnostics.source import Source, Span

_IMPORT = re.compile(r"^(?=import\b)", re.MULTILINE)
_AFTER_COMMENTS = re.compile(r"\ufeff?(?:[ \t]*//(?!/)[^\n]*\n)*(?:[ \t]*\n)*")

# --- declarations -----------------------------------------------------------------------


@error("BG200: `{name}` is declared twice", "rename one", labels={"first": "first declared here"})
def duplicate_name(span: Span, name: str, first: Span | None) -> None: ...


def import_place(source: Source) -> Span:
    """Return the place of a further import: before the first one, else where the text begins.

    Comments that begin the file stay above it.
    """
    found = _IMPORT.search(source.text) or _AFTER_COMMENTS.match(source.text)
    at = found.end() if found else 0
    return Span(source, at, at)


@error(
    "BG201: there is no element, model or interface called `{name}`",
    "import the file that declares it",
)
def unknown_type(
    span: Span, name: str, candidates: Iterable[str], library: str | None = None, advice: str = ""
) -> Values:
    # `advice` is that for a word of a textbook or of another tool, such as OneJunction.
    candidates = list(candidates)
    near = did_you_mean(name, candidates)
    edits = respelt(span, name, candidates)
    if library is not None:
        near = f"import it from the library: `import {library};`"
        if advice:
            near = f"{advice}; or import the library's `{name}`: `import {library};`"
        edits = [Edit(import_place(span.source), f"import {library};\n")]
    return {"help": near or advice, "edits": edits}


@error("BG202: there is no domain called `{name}`", "{there}")
def unknown_domain(
    span: Span, name: str, candidates: Iterable[str], library: Mapping[str, str]
) -> Values:
    if name in library:
        statement = f"import {library[name]};"
        edits = [Edit(import_place(span.source), f"{statement}\n")]
        return {"there": f"import it from the library: `{statement}`", "edits": edits}
    known = sorted(each for each, at in library.items() if not at.startswith("examples."))
    there = f"the library has {quoted(known)}; import the file that declares it, or omit the domain"
    return {"there": there, **nearest(name, candidates, span)}


@error("BG203: `{name}` is {what}, not a model", "name a model")
def not_a_model(span: Span, name: str, what: str) -> None: ...
@error("BG204: a model extends itself: {line}", "remove one `is`")
def inheritance_cycle(span: Span, names: Sequence[str]) -> Values:
    return {"line": " is ".join(names)}


@error(
    "BG205: `{name}` contains itself, {depth} levels deep",
    "end the nesting by a dimension and `if n > 1 { .. }`, or use `for`",
    note="in `{path}..`",
)
def contains_itself(span: Span, name: str, path: str, depth: int) -> None: ...
@error(
    "BG269: models are nested more than {most} levels deep",
    "write the parts of some models in those that hold them",
    note="in `{path}..`",
)
def nested_too_deeply(span: Span, most: int, path: str) -> None: ...
@error(
    "BG206: `{name}` takes {expected}, not {given}",
    "give as many dimensions in brackets as its declaration has",
)
def wrong_dimensions(span: Span, name: str, expected: str, given: int) -> None: ...
@error("BG207: `{name}` is the name of an element", "give the model another name")
def name_of_element(span: Span, name: str) -> None: ...


# --- names in expressions and paths -----------------------------------------------------


@error("BG210: {owner} has no `{name}`", "{there}")
def unknown_member(span: Span, name: str, owner: str, candidates: Iterable[str]) -> Values:
    names = list(candidates)
    there = f"use one of its members: {quoted(names[:12])}"
    if not names:
        there = "remove it: there are no members"
    return {"there": there, **nearest(name, names, span)}


@error("BG211: there is no `{name}` here", "declare it, or give its path, for example `boom.mass`")
def unknown_name(
    span: Span, name: str, candidates: Iterable[str], advice: str = "", otherwise: str = ""
) -> Values:
    # `advice` is given instead of a similar name, `otherwise` where there is no similar name.
    near = {"help": advice} if advice else nearest(name, candidates, span)
    return {**near, "help": near["help"] or otherwise}


@error("BG241: the part `{name}` is declared with `=`", "write `{name} : {type_name}(..);`")
def part_by_equals(span: Span, name: str, type_name: str) -> None: ...
@error(
    "BG212: `{name}[{at}]` does not exist: `{name}` has {have}",
    "use an index of the array: the first is 1; to make several parts use `for`, which "
    "includes both ends: `for i in 1..4 { mass[i] : I(m); }`",
)
def no_such_index(span: Span, name: str, index: Sequence[int], have: str) -> Values:
    return {"at": ", ".join(map(str, index))}


@error("BG213: `{name}` needs an index: it is {have}", "write `{name}[1]`")
def needs_index(span: Span, name: str, have: str) -> None: ...
@error(
    "BG214: a value is defined by itself: {names:path}",
    "make one of them a `state`, or an `unknown` with an `equation`",
)
def defined_by_itself(span: Span, names: Sequence[str]) -> None: ...
@error("BG218: {kind} `{name}` has no value", labels={"asked": "declared here"})
def no_value(span: Span, name: str, kind: str, asked: Span | None) -> Values:
    given = f"give it where the part is made: `({name} = ..)`"
    ways = {
        "param": f"{given}, or write a default",
        "const": f"{given}, or write its value",
        "input": f"{given}, by `drive` in a scene, or write a default",
        "output": f"write `{name} = ..;` in the model",
        "signal": f"write `{name} = ..;` in the model",
    }
    return {"help": ways.get(kind, f"write `{kind} {name} = ..;`")}


@error("BG220: `{name}` is given twice", "remove one of them", labels={"first": "first given here"})
def given_twice(span: Span, name: str, first: Span) -> None: ...


# --- arguments --------------------------------------------------------------------------


@error("BG230: {owner} takes no argument `{name}`", "{there}")
def unknown_argument(
    span: Span, name: str, owner: str, candidates: Iterable[str], advice: str = ""
) -> Values:
    names = list(candidates)
    there = f"use one of its arguments: {quoted(names[:12])}"
    if not names:
        there = "remove it: it takes no arguments"
    near = nearest(name, names, span)
    return {"there": there, **near, "help": advice or near["help"]}


@error(
    "BG231: `{name}` is {kind:an} of the model and cannot be given from outside",
    "declare a `param` in the model and use it there; only a param, const, input or slot "
    "can be given",
)
def cannot_be_given(span: Span, name: str, kind: str, candidates: Iterable[str]) -> Values:
    return nearest(name, candidates, span)


@error(
    "BG266: `{name}` must be {expected} as its default is, not {found}",
    "give a value in the unit of the default, or a number alone in SI units",
    labels={"default": "the default"},
)
def replaces_other_unit(
    span: Span, name: str, expected: str, found: str, default: Span
) -> None: ...
@error("BG232: the arguments of {owner} must be given by name", "remove it: it takes no arguments")
def positional_argument(span: Span, owner: str, candidates: Iterable[str]) -> Values:
    names = quoted(f"{name} = .." for name in list(candidates)[:6])
    return {"help": f"write the name: {names}" if names else ""}


@error(
    "BG238: {kind:an} cannot be declared inside `for`",
    "declare it before the loop with a dimension, as `state x[3] = 0;`",
)
def misplaced_in_loop(span: Span, kind: str) -> None: ...
@error(
    "BG215: this model has more than {most} ancestors by `is`",
    "write what they add as parts of one model",
)
def too_many_ancestors(span: Span, most: int) -> None: ...
@error(
    "BG249: the model's `{name}` has the name of a parameter that its parts use",
    "set the other one in the scene, `set {name} = ..;`, or rename the model's own",
    labels={"other": "the parts use this one"},
)
def hides_parameter_of_file(span: Span, name: str, other: Span) -> None: ...
