"""The doors of the Python interface: errors leave them short, with the excerpt of the text."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Mapping
from functools import wraps
from numbers import Integral
from typing import Any, ParamSpec, TypeVar

from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.render import render
from bgc.diagnostics.words import did_you_mean

_P = ParamSpec("_P")
_R = TypeVar("_R")
_C = TypeVar("_C")
_OPERATORS = ("__getitem__", "__setitem__", "__delitem__")

_CHECKED: dict[str, tuple[type, str]] = {
    "str": (str, "a text"),
    "Literal": (str, "a text"),  # all literals of the interface are texts
    "Mapping": (Mapping, "a mapping such as a dict"),
    "int": (Integral, "an integer"),
    "None": (type(None), "None"),
}
"""Annotations whose arguments are checked, with the type and words for it."""


def public_function(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Cut the inner frames off the traceback of a BgError that leaves a function.

    The error keeps its diagnostics and gets their rendered form as a note, which Python prints
    below the traceback. With `BGC_DEBUG` set the traceback is whole. An argument that is to be a
    text, a mapping or an integer, and is not, is a TypeError that names it, and so is an unknown
    keyword.
    """
    names, checks = _checks(function)

    @wraps(function)
    def outer(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        for name, value in (*zip(names, args, strict=False), *kwargs.items()):
            if name not in names:
                raise TypeError(
                    f"`{function.__name__}` got an unexpected keyword argument `{name}`; "
                    + (did_you_mean(name, names) or "see `help`")
                )
            if name in checks and not isinstance(value, checks[name][0]):
                kind, wanted = type(value).__name__, checks[name][1]
                raise TypeError(f"`{name}` has the type {kind}, where {wanted} is expected")
        try:
            return function(*args, **kwargs)
        except BgError as problem:
            if os.environ.get("BGC_DEBUG"):
                raise
            if not getattr(problem, "__notes__", None):
                problem.add_note("\n" + render(problem.diagnostics, colour=False).rstrip())
            raise problem.with_traceback(None) from None

    return outer


def _checks(
    function: Callable[..., Any],
) -> tuple[list[str], dict[str, tuple[tuple[type, ...], str]]]:
    """The parameters of a function, and the types and words of those that are checked.

    The keys of `[]` are not: which exist is the answer of the mapping.
    """
    parameters = inspect.signature(function).parameters
    checks = {}
    for name, parameter in parameters.items():
        kinds = [_CHECKED.get(word) for word in _alternatives(parameter.annotation)]
        if function.__name__ not in _OPERATORS and kinds and None not in kinds:
            found = [kind for kind in kinds if kind is not None]
            checks[name] = (
                tuple(kind for kind, _ in found),
                " or ".join(words for _, words in found),
            )
    return list(parameters), checks


def _alternatives(annotation: object) -> list[str]:
    """The names of the types in the text of an annotation, `Mapping[str, float] | None`."""
    if not isinstance(annotation, str):
        return []
    while (bare := re.sub(r"\[[^\[\]]*\]", "", annotation)) != annotation:
        annotation = bare
    return [word.strip() for word in annotation.split("|")]


def public_class(kind: type[_C]) -> type[_C]:
    """Make doors of the public methods of a class and of its `[]`."""
    for name, member in list(vars(kind).items()):
        is_public = not name.startswith("_") or name in _OPERATORS
        if is_public and callable(member) and not isinstance(member, type):
            setattr(kind, name, public_function(member))
    return kind
