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
    """BG200: a name declared twice

    What: two declarations in the same place have the same name, or one repeats an imported name.
    Why: the name is ambiguous.
    Example: `mass : I(m); mass : C(c);`
    Way out: rename one of them. A model that extends another cannot replace what it inherits: give
    the inherited part other arguments instead.
    """
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
    """BG201: a type that is not declared

    What: the name after the colon is not an element, model or interface visible in this file.
    Why: a file sees its own declarations and those of the files and library modules that it
    imports.
    Example: `boom : Beem(length = 12 m);`
    Way out: correct the name, or import the file that declares it.
    """
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
    """BG202: a domain that is not declared

    What: the name after a port's colon is not a domain visible in this file.
    Why: a domain gives a port its width, its units and the signals that it carries.
    Example: `port tip out : Fram;`
    Way out: correct the name, import the file that declares it, or omit the domain: the port then
    takes it from its bonds. The message lists the domains of the library.
    """
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
    """BG203: something other than a model where a model is needed

    What: a scene, or a model after `is`, names something that is not a model.
    Why: only a model can be run or extended; an interface only lists the members that a model must
    have.
    Example: `scene s of Frame { }` where Frame is a domain.
    Way out: name a model.
    """
    return error("BG203", f"`{name}` is {what}, not a model", span, help="name a model")


def inheritance_cycle(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG204: a model that extends itself

    What: the chain of `is` from a model leads back to the model itself.
    Why: the model would have infinitely many parts.
    Example: `model A is B { } model B is A { }`
    Way out: remove one `is`.
    """
    return error(
        "BG204", f"a model extends itself: {' is '.join(names)}", span, help="remove one `is`"
    )


def contains_itself(span: Span, name: str, path: str, depth: int) -> Diagnostic:
    """BG205: a model that contains itself endlessly

    What: a model has a part of its own type, and the nesting never ends.
    Why: the model would have infinitely many parts.
    Example: `model Link { next : Link; }`
    Way out: end the nesting with a dimension and a compile-time `if`: `model Link[n] { if n > 1 {
    next : Link[n - 1]; } }`, or use an array of parts in a `for`.
    """
    return error(
        "BG205",
        f"`{name}` contains itself, {depth} levels deep",
        span,
        note=f"in `{path}..`",
        help="end the nesting by a dimension and `if n > 1 { .. }`, or use `for`",
    )


def wrong_dimensions(span: Span, name: str, expected: str, given: int) -> Diagnostic:
    """BG206: the wrong number of dimensions

    What: a type is used with more or fewer dimensions in brackets than its declaration has.
    Why: `Lock[5]` sets the model's `n` to 5; each dimension needs one value.
    Example: `lock : Lock[5, 2];` of `interface Lock[n]`
    Way out: give as many dimensions as the declaration has.
    """
    return error(
        "BG206",
        f"`{name}` takes {expected}, not {given}",
        span,
        help="give as many dimensions in brackets as its declaration has",
    )


def name_of_element(span: Span, name: str) -> Diagnostic:
    """BG207: a model with the name of an element

    What: a model, interface or domain has the name of a basic element: `R`, `C`, `J0`.

    Why: all parts of that type would silently change their meaning.

    Example: `model R { }`

    Way out: choose another name. Values and parts may have these names: `param R = 2 ohm;`.
    """
    return error(
        "BG207", f"`{name}` is the name of an element", span, help="give the model another name"
    )


# --- names in expressions and paths -----------------------------------------------------


def unknown_member(span: Span, name: str, owner: str, candidates: Iterable[str]) -> Diagnostic:
    """BG210: a part, value or port that does not exist

    What: the part has no member with the name after the dot.
    Why: a path such as `crane.boom.mass` leads from a part to its members.
    Example: `observe crane.bom.mass;`
    Way out: correct the name; the model's declaration lists its members.
    """
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
    """BG211: a name that is not declared

    What: a name in an expression, a chain or a path is not visible here.
    Why: a model sees its own values, parts and ports, and the constants of its file. The members of
    a part are reached by their path.
    Example: `supply -> lop;`
    Way out: correct the name, declare it, or give its path, for example `boom.mass`.
    """
    # `advice` is given instead of a similar name, `otherwise` where there is no similar name.
    candidates = list(candidates)
    near = did_you_mean(name, candidates)
    way_out = advice or near or otherwise
    way_out = way_out or "declare it, or give its path, for example `boom.mass`"
    edits = [] if advice else respelt(span, name, candidates)
    return error("BG211", f"there is no `{name}` here", span, help=way_out, edits=edits)


def part_by_equals(span: Span, name: str, type_name: str) -> Diagnostic:
    """BG241: a part declared with `=`

    What: an undeclared name is given a type with `=`.
    Why: `=` gives a value to a declared name; a part is declared by its name, a colon and its type.
    Example: `damper = R(3 N*s/m);`
    Way out: write `damper : R(3 N*s/m);`.
    """
    return error("BG241", f"the part `{name}` is declared with `=`", span,
                 help=f"write `{name} : {type_name}(..);`")  # fmt: skip


def no_such_index(span: Span, name: str, index: Sequence[int], have: str) -> Diagnostic:
    """BG212: an index that an array does not have

    What: the array has no part with this index.
    Why: indices run from 1 to the last part made. `mass[4] : I(m);` makes the single part
    `mass[4]`, not four parts.
    Example: `mass[0]`, or `mass[21]` of 20.
    Way out: keep the index within the array; a `for` includes both ends of its range.
    """
    at = ", ".join(str(i) for i in index)
    return error("BG212", f"`{name}[{at}]` does not exist: `{name}` has {have}", span,
                 help="use an index of the array: the first is 1; to make several parts use `for`, "
                 "which includes both ends: `for i in 1..4 { mass[i] : I(m); }`")  # fmt: skip


def needs_index(span: Span, name: str, have: str) -> Diagnostic:
    """BG213: an array of parts where one part is needed

    What: an array of parts is used without an index.
    Why: each part is bonded and read separately.
    Example: `rail -> mass;` with parts `mass[1]` to `mass[20]`.
    Way out: write an index; to use all parts, write a `for`.
    """
    return error("BG213", f"`{name}` needs an index: it is {have}", span, help=f"write `{name}[1]`")


def defined_by_itself(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG214: a value that is defined in terms of itself

    What: the definition of a value leads back to the value itself.
    Why: no order exists in which to compute the values.
    Example: `let a = b + 1; let b = a;`
    Way out: break the circle: make one of them a `state` with its `der`, or an `unknown` with an
    `equation`.
    """
    return error(
        "BG214",
        f"a value is defined by itself: {' -> '.join(names)}",
        span,
        help="make one of them a `state`, or an `unknown` with an `equation`",
    )


def no_value(span: Span, name: str, kind: str, asked: Span | None) -> Diagnostic:
    """BG218: a value that is not given

    What: a `param` or `input` has neither a default nor an argument, or a `let`, `signal` or
    `output` has no definition.
    Why: the model cannot be computed without it.
    Example: `model Beam { param length : m; }` used as `boom : Beam;`
    Way out: give it where the part is made, `boom : Beam(length = 12 m);`, or write a default.
    """
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
    """BG220: a value given twice

    What: an argument, a definition, a `set`, `use` or `drive` gives the same thing again.
    Why: the two may contradict each other.
    Example: `R(2 ohm, resistance = 3 ohm)`
    Way out: remove one.
    """
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
    """BG230: an argument that the type does not have

    What: the name before `=` is not a parameter, input or slot of the model, or not an argument of
    the element.
    Why: arguments are matched by name.
    Example: `Beam(lenght = 12 m)`
    Way out: correct the name. A law of an element stands in braces: `C { e = k*q; }`.
    """
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
    """BG231: an argument for something that cannot be given

    What: the argument names a `let`, a `signal`, a `state` or a plain part of the model.
    Why: only parameters, constants, inputs and slots can be given from outside.
    Example: `Pendulum(angle = 30 deg)` where `state angle = 0;`
    Way out: give the parameter that determines it, such as `angle0` of a `Revolute`. Where there is
    none, declare a `param` in the model and use it there: `param angle0 = 0; state angle =
    angle0;`.
    """
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
    """BG266: a value whose unit does not measure the quantity of the default

    What: a `set`, `--set`, argument or `drive` has a unit of another kind than the default of the
    parameter, constant or input.

    Why: the unit of a default belongs to the declaration as if it were written after a colon.
    The model was written for it, also where its equations contain no unit that would contradict.

    Example: `param k = 3 N/m;` in a model, and `set k = 3 kg;` in a scene.

    Way out: give a value in the unit of the default or a multiple of it, or a number alone, which
    is taken in SI units. For a parameter that may have any unit, write its default without a unit.
    """
    return error(
        "BG266",
        f"`{name}` must be {expected} as its default is, not {found}",
        span,
        labels=[Label(default, "the default")],
        help="give a value in the unit of the default, or a number alone in SI units",
    )


def positional_argument(span: Span, owner: str, candidates: Iterable[str]) -> Diagnostic:
    """BG232: an argument without its name

    What: an argument of a model has no name.
    Why: only basic elements take an argument by position: `R(2 ohm)`.
    Example: `boom : Beam(12 m);`
    Way out: write the name: `boom : Beam(length = 12 m);`
    """
    names = [f"`{c} = ..`" for c in list(candidates)[:6]]
    return error(
        "BG232",
        f"the arguments of {owner} must be given by name",
        span,
        help=f"write the name: {', '.join(names)}" if names else "remove it: it takes no arguments",
    )


def misplaced_in_loop(span: Span, kind: str) -> Diagnostic:
    """BG238: a declaration that is not allowed in a `for`

    What: a `param`, `state`, `input`, `output`, `unknown` or port is declared inside a `for`.
    Why: each iteration would declare it again under the same name.
    Example: `for i in 1..3 { state x = 0; }`
    Way out: declare it before the loop with a dimension, `state x[3] = 0;`, and index it.
    """
    return error(
        "BG238",
        f"{with_article(kind)} cannot be declared inside `for`",
        span,
        help="declare it before the loop with a dimension, as `state x[3] = 0;`",
    )


def too_many_ancestors(span: Span, most: int) -> Diagnostic:
    """BG215: a model with too many ancestors

    What: more than 100 models lie between a model and the first of its ancestors by `is`.
    Why: each of them is read for each that extends it, and no person can follow that many.
    Example: a file written by a program, in which each model extends the one before.
    Way out: write what the models add as parts of one model, or as models in its slots.
    """
    return error(
        "BG215",
        f"this model has more than {most} ancestors by `is`",
        span,
        help="write what they add as parts of one model",
    )


def hides_parameter_of_file(span: Span, name: str, other: Span) -> Diagnostic:
    """BG249: two parameters of one name, of the scene's model and of a file

    What: the scene's model declares a parameter with the name of a parameter of a file that its
    parts use.

    Why: `set` and `--set` know both by this name, and would reach the model's alone.

    Example: `param gravity = 1.62 m/s^2;` in a model with parts of the library, whose weights hold
    the library's `gravity`.

    Way out: remove the model's own and set the other in the scene, `set gravity = 1.62 m/s^2;`, or
    rename the model's own.
    """
    return error(
        "BG249",
        f"the model's `{name}` has the name of a parameter that its parts use",
        span,
        labels=[Label(other, "the parts use this one")],
        help=f"set the other one in the scene, `set {name} = ..;`, or rename the model's own",
    )
