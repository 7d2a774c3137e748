"""Jinja2 templates: text from the files `*.j2` of this folder.

Imported by commands that write documents only: Jinja2 takes tens of milliseconds to import.
"""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape


def render_template(name: str, /, **values: Any) -> str:
    """Fill in a template; values in HTML and XML are escaped, a missing name is an error."""
    environment = Environment(
        loader=PackageLoader("bgc.runtime.documents", package_path=""),
        autoescape=select_autoescape(("html.j2", "xml.j2"), default_for_string=False),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(name).render(**values)
