"""Jinja2 templates: text from the files `*.j2` of this folder.

Imported by commands that write documents only: Jinja2 takes tens of milliseconds to import.
"""

from __future__ import annotations

import re
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

# Characters that no XML document may have, not even escaped (XML 1.0, section 2.2).
_NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def render_template(name: str, /, **values: Any) -> str:
    """Fill in a template; values in HTML and XML are escaped, a missing name is an error.

    Characters that XML cannot have become U+FFFD in templates `*.xml.j2`.
    """
    environment = Environment(
        loader=PackageLoader("bgc.runtime.documents", package_path=""),
        autoescape=select_autoescape(("html.j2", "xml.j2"), default_for_string=False),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=_in_xml if name.endswith(".xml.j2") else None,
    )
    return environment.get_template(name).render(**values)


def _in_xml(value: object) -> object:
    """Replace what XML cannot have; text that is marked as escaped stays marked."""
    if not isinstance(value, str):
        return value
    return type(value)(_NOT_IN_XML.sub("\ufffd", value))
