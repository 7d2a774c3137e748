"""The integration methods as C has them: rows of `tableaus.c`, and what its interface says."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from ctypes import byref, c_char_p, c_int
from typing import Any, ClassVar

from bgc.language.methods import METHODS, Method


class MethodStruct(ctypes.Structure):
    """`bgc_method_info`."""

    _fields_: ClassVar[list[tuple[str, Any]]] = [
        *((name, c_char_p) for name in ("name", "family", "purpose")),
        *((name, c_int) for name in ("order", "error_order", "jacobian", "lanes")),
        *((name, c_int) for name in ("embedded_order", "substeps", "stages")),
    ]


def described(functions: Any) -> list[dict[str, Any]]:
    """What `bgc_get_method` of a loaded library says about each method, by the fields of C."""
    found: list[dict[str, Any]] = []
    raw = MethodStruct()
    while functions.bgc_get_method(len(found), byref(raw)) == 0:
        values = {name: getattr(raw, name) for name, _ in MethodStruct._fields_}
        found.append({n: v.decode() if isinstance(v, bytes) else v for n, v in values.items()})
    return found


def expected(method: Method) -> dict[str, Any]:
    """The same from the table."""
    return {
        "name": method.name,
        "family": method.family.name,
        "purpose": method.purpose,
        "order": method.order,
        "error_order": method.error_order,
        "jacobian": method.family.jacobian,
        "lanes": method.family.lanes,
        "embedded_order": method.embedded_order,
        "substeps": method.parts,
        "stages": method.stages,
    }


def rows() -> str:
    """The rows of `bgc_methods`."""
    return "".join(f"    {{\n{''.join(_fields(m))}    }},\n" for m in METHODS.values())


def _fields(method: Method) -> Iterator[str]:
    kind = "collocation" if "collocation" in method.family.name else "tableau"
    fields = {
        "name": f'"{method.name}"',
        "family": f"&{method.family.variable}",
        kind: f"&{method.coefficients or method.name}",
        "order": method.order,
        "error_order": method.error_order,
        "embedded_order": method.embedded_order,
        "substeps": method.parts if method.parts > 1 else 0,
        "check_dense": int(method.checks_dense),
        "partner": f'"{method.partner}"' if method.partner else 0,
        "purpose": f'"{method.purpose}"',
    }
    return (f"        .{name} = {value},\n" for name, value in fields.items() if value)
