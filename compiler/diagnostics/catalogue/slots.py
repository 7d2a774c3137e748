"""BG23x: slots, and the models that fill them."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def slot_not_filled(span: Span, name: str, interface: str, models: Sequence[str]) -> Diagnostic:
    """BG233: a slot without a model in it

    What: a part's type is an interface, and no model is chosen for it.
    Why: an interface only lists the members that a model must have.
    Example: `lock : Lock[5];`
    Way out: write a default, `lock : Lock[5] = Rigid[5];`, give an argument, or write `use` in the
    scene.
    """
    fitting = ", ".join(f"`{m}`" for m in models[:8])
    return error(
        "BG233",
        f"the slot `{name}` has no model",
        span,
        help=f"write a default, `{name} : {interface} = ..;`, or `use` in the scene"
        + (f"; these models fit: {fitting}" if fitting else ""),
    )


def does_not_fit(span: Span, model: str, interface: str, models: Sequence[str]) -> Diagnostic:
    """BG234: a model that does not fit its slot

    What: the model given for a slot is not declared to be the slot's interface.
    Why: the users of a slot rely on the members that its interface lists.
    Example: `use crane.elbow.lock = Beam;`
    Way out: use a model that `is` the interface, or declare that this one is.
    """
    fitting = ", ".join(f"`{m}`" for m in models[:8])
    return error(
        "BG234",
        f"`{model}` is not a `{interface}`",
        span,
        help=f"use a model that fits: {fitting}"
        if fitting
        else f"declare `model {model} is {interface}` if it is one",
    )


def not_a_slot(span: Span, name: str, what: str) -> Diagnostic:
    """BG235: `use` of something that is not a slot

    What: `use` names a part or value that is not a slot.
    Why: a slot is a part declared with an interface, or with a default after `=`; only a slot can
    be filled.
    Example: `use crane.boom = Beam;` where `boom : Beam(..);`
    Way out: declare the part as a slot: `boom : Link = Beam(..);`; for a number use `set`.
    """
    return error(
        "BG235",
        f"`{name}` is {what}, not a slot",
        span,
        help="declare it as a slot: `name : Interface = Default;`",
    )


def interface_misses(
    span: Span, model: str, interface: str, missing: str, place: Span
) -> Diagnostic:
    """BG236: a model without a member of its interface

    What: the model `is` an interface, but lacks one of its members.
    Why: the users of a slot rely on the members that its interface lists.
    Example: `interface Lock[n] { port p[n]; output d[n]; }` and a model without `d`.
    Way out: add the member, or remove the `is`.
    """
    return error(
        "BG236",
        f"`{model}` is declared to be a `{interface}`, but has no {missing}",
        span,
        labels=[Label(place, "required here")],
        help="add it to the model",
    )


def statement_in_interface(span: Span, interface: str) -> Diagnostic:
    """BG265: a statement in an interface

    What: an interface holds a statement that is not a declaration: a bond, an equation, an
    `assert`, a shape, a loop.
    Why: an interface only lists members. A model that is declared to be one takes nothing from it,
    so the statement would have no effect.
    Example: `interface Load { port frame in : Frame; shape sphere(1 m); }`
    Way out: move the statement to the models of the interface.
    """
    return error(
        "BG265",
        f"the interface `{interface}` takes declarations only",
        span,
        help="move the statement to the models of the interface",
    )


def type_expected(span: Span, slot: str) -> Diagnostic:
    """BG237: something other than a type given to a slot

    What: the argument or `use` of a slot is an expression.
    Why: only a model can fill a slot.
    Example: `elbow : Revolute(lock = 3);`
    Way out: name a model: `lock = Rigid[5]`.
    """
    return error(
        "BG237",
        f"`{slot}` is a slot and takes a model",
        span,
        help=f"name a model, as in `{slot} = Rigid[5]`",
    )
