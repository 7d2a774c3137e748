"""The doors of the Python interface: errors leave them short, with the excerpt of the text."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.render import render

_P = ParamSpec("_P")
_R = TypeVar("_R")
_C = TypeVar("_C")
_OPERATORS = ("__getitem__", "__setitem__", "__delitem__")


def door(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Cut the inner frames off the traceback of a BgError that leaves a function.

    The error keeps its diagnostics and gets their rendered form as a note, which Python prints
    below the traceback. With `BGC_DEBUG` set the traceback is whole.
    """

    @wraps(function)
    def outer(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        try:
            return function(*args, **kwargs)
        except BgError as problem:
            if os.environ.get("BGC_DEBUG"):
                raise
            if not getattr(problem, "__notes__", None):
                problem.add_note("\n" + render(problem.diagnostics, colour=False).rstrip())
            raise problem.with_traceback(None) from None

    return outer


def with_doors(kind: type[_C]) -> type[_C]:
    """Make doors of the public methods of a class and of its `[]`."""
    for name, member in list(vars(kind).items()):
        is_public = not name.startswith("_") or name in _OPERATORS
        if is_public and callable(member) and not isinstance(member, type):
            setattr(kind, name, door(member))
    return kind
