"""Diagnostics of names, types, models, slots and their arguments."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span

# --- declarations -----------------------------------------------------------------------


def duplicate_name(span: Span, name: str, first: Span | None) -> Diagnostic:
    """BG200: a name declared twice

    What: two declarations in one place have the same name, or one repeats an imported name.
    Why: which of them a use means could not be told.
    Example: `mass : I(m); mass : C(c);`
    Way out: rename one of them. An extension may not replace what it inherits: give the
    inherited part other arguments instead.
    """
    labels = [Label(first, "first declared here")] if first else []
    return error("BG200", f"`{name}` is declared twice", span, labels=labels, help="rename one")


def unknown_type(
    span: Span, name: str, candidates: Iterable[str], library: str | None = None
) -> Diagnostic:
    """BG201: a type that is not declared

    What: the name after the colon is no element, model or interface that this file sees.
    Why: a file sees its own declarations and those of the files it imports, the library's too.
    Example: `boom : Beem(length = 12 m);`
    Way out: correct the name, or import the file that declares it.
    """
    near = did_you_mean(name, candidates)
    if library is not None:
        near = f"it is in the library: `import {library};`"
    return error(
        "BG201",
        f"there is no element, model or interface called `{name}`",
        span,
        help=near or "import the file that declares it",
    )


def unknown_domain(span: Span, name: str, candidates: Iterable[str]) -> Diagnostic:
    """BG202: a domain that is not declared

    What: the name after a port's colon is no domain that this file sees.
    Why: a domain gives a port its width, its units and the signals it carries.
    Example: `port tip out : Fram;`
    Way out: correct the name, import the file that declares it, or leave the domain out: a
    port then takes it from its bonds.
    """
    near = did_you_mean(name, candidates)
    return error(
        "BG202",
        f"there is no domain called `{name}`",
        span,
        help=near or "import the file that declares it, or leave the domain out",
    )


def not_a_model(span: Span, name: str, what: str) -> Diagnostic:
    """BG203: something other than a model where a model is needed

    What: a scene, or a model after `is`, names something that is no model.
    Why: only a model can be run or extended; an interface only says what a model must have.
    Example: `scene s of Frame { }` where Frame is a domain.
    Way out: name a model.
    """
    return error("BG203", f"`{name}` is {what}, not a model", span, help="name a model")


def inheritance_cycle(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG204: a model that extends itself

    What: following `is` from a model leads back to it.
    Why: it would have infinitely many parts.
    Example: `model A is B { } model B is A { }`
    Way out: remove one of the `is`.
    """
    return error(
        "BG204", f"a model extends itself: {' is '.join(names)}", span, help="remove one `is`"
    )


def contains_itself(span: Span, name: str, path: str, depth: int) -> Diagnostic:
    """BG205: a model that contains itself without end

    What: a model has a part of its own type, and nothing ends the nesting.
    Why: it would have infinitely many parts.
    Example: `model Link { next : Link; }`
    Way out: end it by a dimension and a compile-time `if`: `model Link[n] { if n > 1 { next :
    Link[n - 1]; } }`, or use an array of parts in a `for`.
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

    What: a type is used with more or fewer dimensions in brackets than it has.
    Why: `Lock[5]` gives the model's `n` its value; each needs one.
    Example: `lock : Lock[5, 2];` of `interface Lock[n]`
    Way out: give as many as the declaration has.
    """
    return error(
        "BG206",
        f"`{name}` takes {expected}, not {given}",
        span,
        help="the dimensions in brackets are those of its declaration",
    )


def name_of_element(span: Span, name: str) -> Diagnostic:
    """BG207: a model with the name of an element

    What: a model, interface or domain is called like a basic element: `R`, `C`, `J0`.

    Why: every part of that type would silently be something else.

    Example: `model R { }`

    Way out: give it another name. Values and parts may have these names: `param R = 2 ohm;`.
    """
    return error(
        "BG207", f"`{name}` is the name of an element", span, help="give the model another name"
    )


# --- names in expressions and paths -----------------------------------------------------


def unknown_member(span: Span, name: str, owner: str, candidates: Iterable[str]) -> Diagnostic:
    """BG210: a part, value or port that is not there

    What: the name after the dot is nothing that the part has.
    Why: a path as `crane.boom.mass` goes from part to part.
    Example: `observe crane.bom.mass;`
    Way out: correct the name; what a model has is listed where it is declared.
    """
    candidates = list(candidates)
    listing = ", ".join(f"`{c}`" for c in candidates[:12])
    near = did_you_mean(name, candidates) or (f"it has {listing}" if listing else "it has none")
    return error("BG210", f"{owner} has no `{name}`", span, help=near)


def unknown_name(span: Span, name: str, candidates: Iterable[str]) -> Diagnostic:
    """BG211: a name that is not declared

    What: a name in an expression, a chain or a path is nothing that is visible here.
    Why: a model sees its own values, parts and ports, and the constants of its file; what is
    inside a part is reached by its path.
    Example: `supply -> lop;`
    Way out: correct the name, declare it, or give its path, as in `boom.mass`.
    """
    way_out = did_you_mean(name, candidates) or "declare it, or give its path, as in `boom.mass`"
    return error("BG211", f"there is no `{name}` here", span, help=way_out)


def part_by_equals(span: Span, name: str, type_name: str) -> Diagnostic:
    """BG241: a part that is declared by `=`

    What: a name that is not declared is given a type with `=`.
    Why: `=` gives a value to what is declared; a part is declared by its name, a colon and its
    type.
    Example: `damper = R(3 N*s/m);`
    Way out: write `damper : R(3 N*s/m);`.
    """
    return error("BG241", f"the part `{name}` is declared by `=`", span,
                 help=f"write `{name} : {type_name}(..);`")  # fmt: skip


def no_such_index(span: Span, name: str, index: Sequence[int], have: str) -> Diagnostic:
    """BG212: an index that an array does not have

    What: the index names no part of the array.
    Why: indices start at 1 and end at the last part made. `mass[4] : I(m);` makes the one part
    `mass[4]`, not four.
    Example: `mass[0]`, or `mass[21]` of 20.
    Way out: keep the index within the array; the ends of a `for` are both included.
    """
    at = ", ".join(str(i) for i in index)
    return error("BG212", f"`{name}[{at}]` does not exist: `{name}` has {have}", span,
                 help="indices start at 1, and both ends of a range are included; a `for` makes "
                 "several parts: `for i in 1..4 { mass[i] : I(m); }`")  # fmt: skip


def needs_index(span: Span, name: str, have: str) -> Diagnostic:
    """BG213: an array of parts where one part is needed

    What: an array of parts is used without an index.
    Why: each of its parts is bonded and read on its own.
    Example: `rail -> mass;` where `mass[1]` to `mass[20]` exist.
    Way out: write an index, in a `for` if all are meant.
    """
    return error("BG213", f"`{name}` is {have}: say which", span, help=f"write `{name}[1]`")


def defined_by_itself(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG214: a value that is defined in terms of itself

    What: following the definitions from a value leads back to it.
    Why: no order exists in which to compute them.
    Example: `let a = b + 1; let b = a;`
    Way out: break the circle: make one of them a `state` with its `der`, or an `unknown` with
    an `equation`.
    """
    return error(
        "BG214",
        f"a value is defined by itself: {' -> '.join(names)}",
        span,
        help="make one of them a `state`, or an `unknown` with an `equation`",
    )


def no_value(span: Span, name: str, kind: str, asked: Span | None) -> Diagnostic:
    """BG218: a value that nobody gives

    What: a `param` or `input` has neither a default nor an argument, or a `let`, `signal` or
    `output` has no definition.
    Why: it is needed to compute the model.
    Example: `model Beam { param length : m; }` used as `boom : Beam;`
    Way out: give it where the part is made, `boom : Beam(length = 12 m);`, or a default.
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
    """BG220: a value that is given twice

    What: an argument, a definition, a `set`, `use` or `drive` gives the same thing again.
    Why: which of the two is meant could not be told.
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


# --- arguments and slots ----------------------------------------------------------------


def unknown_argument(span: Span, name: str, owner: str, candidates: Iterable[str]) -> Diagnostic:
    """BG230: an argument that the type does not have

    What: the name before `=` is no parameter, input or slot of the model, or no argument of
    the element.
    Why: arguments are given by name.
    Example: `Beam(lenght = 12 m)`
    Way out: correct the name.
    """
    candidates = list(candidates)
    near = did_you_mean(name, candidates)
    listing = ", ".join(f"`{c}`" for c in candidates[:12])
    return error(
        "BG230",
        f"{owner} takes no argument `{name}`",
        span,
        help=near or (f"it takes {listing}" if listing else "it takes none"),
    )


def cannot_be_given(span: Span, name: str, kind: str) -> Diagnostic:
    """BG231: an argument for something that cannot be given

    What: the argument names a `let`, a `signal`, a `state` or a plain part of the model.
    Why: from outside only parameters, constants, inputs and slots are given.
    Example: `Pendulum(angle = 30 deg)` where `state angle = 0;`
    Way out: declare a `param` in the model and use it there: `param angle0 = 0; state angle =
    angle0;`
    """
    return error(
        "BG231",
        f"`{name}` is a {kind} of the model, and cannot be given from outside",
        span,
        help="only a param, const, input or slot can; declare a `param` and use it there",
    )


def positional_argument(span: Span, owner: str, candidates: Iterable[str]) -> Diagnostic:
    """BG232: an argument without its name

    What: an argument of a model is given without a name.
    Why: only basic elements take an argument by its place: `R(2 ohm)`.
    Example: `boom : Beam(12 m);`
    Way out: write the name: `boom : Beam(length = 12 m);`
    """
    names = [f"`{c} = ..`" for c in list(candidates)[:6]]
    return error(
        "BG232",
        f"the arguments of {owner} are given by name",
        span,
        help=f"write {' or '.join(names)}" if names else "it takes none",
    )


def slot_not_filled(span: Span, name: str, interface: str, models: Sequence[str]) -> Diagnostic:
    """BG233: a slot without a model in it

    What: a part's type is an interface, and nothing says which model fills it.
    Why: an interface only lists what a model must have.
    Example: `lock : Lock[5];`
    Way out: a default, `lock : Lock[5] = Rigid[5];`, an argument, or `use` in the scene.
    """
    fitting = ", ".join(f"`{m}`" for m in models[:8])
    return error(
        "BG233",
        f"nothing fills the slot `{name}`",
        span,
        help=f"write a default, `{name} : {interface} = ..;`, or `use` in the scene"
        + (f"; fitting: {fitting}" if fitting else ""),
    )


def does_not_fit(span: Span, model: str, interface: str, models: Sequence[str]) -> Diagnostic:
    """BG234: a model in a slot that it does not fit

    What: the model that fills a slot is not declared to be what the slot asks for.
    Why: whoever uses the slot relies on what its interface lists.
    Example: `use crane.elbow.lock = Beam;`
    Way out: use a model that `is` the interface, or declare that this one is.
    """
    fitting = ", ".join(f"`{m}`" for m in models[:8])
    return error(
        "BG234",
        f"`{model}` is no `{interface}`",
        span,
        help=f"fitting: {fitting}"
        if fitting
        else f"declare `model {model} is {interface}` if it is one",
    )


def not_a_slot(span: Span, name: str, what: str) -> Diagnostic:
    """BG235: `use` of something that is no slot

    What: `use` names a part or value that is not replaceable.
    Why: only a slot, a part declared with an interface or a default after `=`, can be filled.
    Example: `use crane.boom = Beam;` where `boom : Beam(..);`
    Way out: declare the part as a slot: `boom : Link = Beam(..);`; for a number use `set`.
    """
    return error(
        "BG235",
        f"`{name}` is {what}, not a slot",
        span,
        help="a slot is declared as `name : Interface = Default;`",
    )


def interface_misses(
    span: Span, model: str, interface: str, missing: str, place: Span
) -> Diagnostic:
    """BG236: a model that lacks what its interface lists

    What: the model `is` an interface, but has no member of that kind and name.
    Why: whoever uses a slot of this interface relies on it.
    Example: `interface Lock[n] { port p[n]; output d[n]; }` and a model without `d`.
    Way out: add the member, or remove the `is`.
    """
    return error(
        "BG236",
        f"`{model}` is declared to be a `{interface}`, but has no {missing}",
        span,
        labels=[Label(place, "asked for here")],
        help="add it to the model",
    )


def type_expected(span: Span, slot: str) -> Diagnostic:
    """BG237: something other than a type given to a slot

    What: the argument or `use` of a slot is an expression.
    Why: a slot is filled by a model.
    Example: `elbow : Revolute(lock = 3);`
    Way out: name a model: `lock = Rigid[5]`.
    """
    return error(
        "BG237", f"`{slot}` is a slot, and takes a model", span, help="as in `lock = Rigid[5]`"
    )


def misplaced_in_loop(span: Span, kind: str) -> Diagnostic:
    """BG238: a declaration that cannot stand in a `for`

    What: a `param`, `state`, `input`, `output`, `unknown` or port is declared inside a `for`.
    Why: it would be declared once for every turn, under one name.
    Example: `for i in 1..3 { state x = 0; }`
    Way out: declare it before the loop with a dimension, `state x[3] = 0;`, and index it.
    """
    return error(
        "BG238",
        f"a {kind} cannot be declared inside `for`",
        span,
        help="declare it before the loop with a dimension, as `state x[3] = 0;`",
    )


def range_excludes(
    span: Span, name: str, value: float, low: float, high: float, unit: str
) -> Diagnostic:
    """BG239: a parameter outside its own range

    What: the value given to a parameter lies outside the range after `in`.
    Why: the author of the model says where it holds.
    Example: `param mass = 1 t in 0 t .. 100 t;` with `set boom.mass = 200 t;`
    Way out: give a value within the range.
    """
    ends = f"{low:g} .. {high:g} {unit}".rstrip()
    number = f"{value:g} {unit}".rstrip()
    return error("BG239", f"`{name}` is {number}, outside {ends}", span,
                 help="give a value within the range of its declaration")  # fmt: skip


def empty_range(span: Span, name: str, low: float, high: float) -> Diagnostic:
    """BG240: a range with nothing in it

    What: the first end of a parameter's range is above the second.
    Why: no value would be allowed.
    Example: `param mass = 1 t in 100 t .. 0 t;`
    Way out: write the lower end first.
    """
    return error("BG240", f"the range of `{name}` is empty: {low:g} is above {high:g}", span,
                 help="write the lower end first")  # fmt: skip
