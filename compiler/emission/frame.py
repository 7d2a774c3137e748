"""The frame of a C unit of a model: title, includes, functions and tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.emission.c_tables import Field

_UNIT = """\
/* {title}
 *
{about} */
#include "bgc.h"

#include <math.h>
{functions}"""

_TABLES = """
/* --- tables ------------------------------------------------------------------------------ */
{tables}
static const bgc_model model_info = {{
{fields}}};

const bgc_model *bgc_get_model(void)
{{
    return &model_info;
}}
"""


def print_unit(
    title: str,
    about: Iterable[str],
    functions: Iterable[str],
    tables: Iterable[str] = (),
    fields: Sequence[Field] = (),
) -> str:
    """The C text of a unit, with the model's tables if `fields` (of `bgc_model`) are given."""
    text = _UNIT.format(
        title=title,
        about="".join(f" * {line}\n" if line else " *\n" for line in about),
        functions="".join(f"\n{function}" for function in functions),
    )
    if not fields:
        return text
    return text + _TABLES.format(
        tables="".join(f"\n{table}" for table in tables),
        fields="".join(f"    .{name} = {value},\n" for name, value in fields),
    )
