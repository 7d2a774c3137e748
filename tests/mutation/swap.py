"""Change the code of a module that is loaded: its functions keep their identity."""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any


class NotSwapped(Exception):
    """A change that reached no function and no constant."""


def swap(name: str, text: str) -> None:
    """Give the functions and constants of a module those of another text.

    Raises NotSwapped where nothing differs.
    """
    module = sys.modules[name]
    new = ModuleType(name)
    new.__dict__.update(__file__=module.__file__, __package__=module.__package__)
    try:
        sys.modules[name] = new  # dataclasses find their module by its name
        exec(compile(text, str(module.__file__), "exec"), new.__dict__)
    finally:
        sys.modules[name] = module
    before = compile(_plain(str(module.__file__)), str(module.__file__), "exec")
    after = compile(text, str(module.__file__), "exec")
    changed = _swap_all(module.__dict__, new.__dict__, name, set())
    if not changed and _shape(before) != _shape(after):
        raise NotSwapped(name)


def _plain(path: str) -> str:
    """The text of a file as `breaks.py` writes it."""
    return ast.unparse(ast.parse(Path(path).read_text("utf-8")))


def _swap_all(old: Any, new: Any, name: str, seen: set[int]) -> bool:
    changed = False
    for key, value in list(new.items()):
        present = old.get(key)
        if key.startswith("__") and not callable(value):
            continue
        function, other = _function(value), _function(present)
        if function is not None and other is not None and function.__module__ == name:
            if id(other) in seen:
                continue
            seen.add(id(other))
            if _shape(other.__code__) != _shape(function.__code__):
                changed = True
            if other.__defaults__ != function.__defaults__:
                other.__defaults__ = function.__defaults__
                changed = True
            if other.__kwdefaults__ != function.__kwdefaults__:
                other.__kwdefaults__ = function.__kwdefaults__
                changed = True
            if other.__code__.co_freevars == function.__code__.co_freevars:
                other.__code__ = function.__code__
        elif isinstance(value, type) and isinstance(present, type):
            if value.__module__ == name:
                changed |= _swap_all(vars(present), vars(value), name, seen)
        elif isinstance(value, int | float | str | tuple | frozenset | dict | set | list) and (
            repr(value) != repr(present)
        ):
            _replace_everywhere(key, present, value)
            changed = True
    return changed


def _function(value: Any) -> FunctionType | None:
    """The function in a wrapper, a property or a class method."""
    for attribute in ("__wrapped__", "fget", "func", "__func__"):
        if not isinstance(value, FunctionType) and hasattr(value, attribute):
            value = getattr(value, attribute)
    value = getattr(value, "__wrapped__", value)
    return value if isinstance(value, FunctionType) else None


def _replace_everywhere(key: str, before: Any, after: Any) -> None:
    for module in list(sys.modules.values()):
        names = getattr(module, "__dict__", {})
        if getattr(module, "__name__", "").startswith("bgc") and names.get(key) is before:
            names[key] = after


def _shape(code: CodeType) -> Any:
    """Code without its places in the text."""
    parts = [_shape(c) if isinstance(c, CodeType) else (type(c), repr(c)) for c in code.co_consts]
    return code.co_code, code.co_names, code.co_varnames, parts
