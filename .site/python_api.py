"""The reference of the Python interface, made of the signatures and docstrings of the package.

A docstring in NumPy's style becomes Markdown: its parameters, attributes and errors are lists of
definitions, its examples are blocks of code, and codes such as BG301 lead to their pages.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

from pages import Page, diagnostic_place

import bgc
from bgc.runtime import __path__ as runtime_path
from bgc.runtime import control

TOPICS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    (
        "model",
        "Compile and run",
        (
            "bgc.compile",
            "bgc.Model",
            "bgc.runtime.running.parameters.Parameters",
            "bgc.runtime.running.stepwise.Stepping",
        ),
    ),
    (
        "results",
        "Results",
        (
            "bgc.Result",
            "bgc.Ensemble",
            "bgc.values.shown_units.Shown",
            "bgc.runtime.results.rest_report.AtRest",
        ),
    ),
    (
        "studies",
        "Studies",
        (
            "bgc.runtime.results.study.Study",
            "bgc.runtime.results.statistics.Statistics",
            "bgc.runtime.results.statistics.Sensitivity",
            "bgc.runtime.studies.estimate.Estimate",
            "bgc.runtime.studies.optimum.Optimum",
            "bgc.runtime.studies.operability_result.Operability",
        ),
    ),
    (
        "linear",
        "Linear models",
        (
            "bgc.runtime.linear.state_space.Linearisation",
            "bgc.runtime.linear.state_space.Mode",
            "bgc.symbolic.symbolic_model.SymbolicModel",
            "bgc.runtime.linearising.casadi_model.CasadiModel",
        ),
    ),
    (
        "control",
        "Control",
        tuple(
            f"bgc.runtime.control.{name}"
            for name in sorted(control.__all__, key=str.swapcase)  # functions before classes
        ),
    ),
    (
        "realtime",
        "Real time",
        (
            "bgc.runtime.realtime.loop.Realtime",
            "bgc.runtime.realtime.loop_options.RealtimeOptions",
            "bgc.runtime.realtime.python_device.PythonDevice",
        ),
    ),
    (
        "trade",
        "Speed and accuracy",
        (
            "bgc.trade",
            "bgc.Trade",
            "bgc.reduce",
            "bgc.Reduction",
            "bgc.reduced_part",
            "bgc.ReducedPart",
        ),
    ),
    (
        "views",
        "Graphs, equations, pages",
        (
            "bgc.runtime.documents.views.Drawing",
            "bgc.runtime.documents.views.Tables",
            "bgc.runtime.documents.views.Equations",
            "bgc.runtime.web.page_export.LivePage",
        ),
    ),
    (
        "errors",
        "Errors",
        (
            "bgc.BgError",
            "bgc.BgWarning",
            "bgc.diagnostics.diagnostic.Diagnostic",
            "bgc.SimulationError",
            "bgc.runtime.results.runs.Interrupted",
            "bgc.runtime.running.failures.RunInterrupted",
        ),
    ),
)

# Members that other modules of the package call, and users do not.
_INNER = {
    "Ensemble": {"interrupted", "placed_failures", "placed_warnings"},
    "LoadedModel": {"explain", "instance_at", "places", "row_width", "selection", "started"},
    "Model": {"places", "solvers"},
    "Parameters": {
        "all_in", "can_set", "checked", "given", "instance", "set_in", "shown", "turned_negative",
        "values_in",
    },
    "RealtimeOptions": {"checked"},
    "Result": {"ended", "noted"},
    "Study": {"placed_failures"},
    "Operability": {"downtime_table"},
}  # fmt: skip
_LISTS = ("Parameters", "Attributes", "Returns", "Raises", "Yields")
_CODE_OR_NUMBER = re.compile(r"`+[^`]+`+|\bBG\d{3}\b")
_WIDTH = 88  # columns of a signature on one line

_ABOUT = """\
# Python

Every public class and function, with its arguments, units, conventions and errors. The chapter
[From Python](../manual/do/python-and-notebooks.md#from-python) of the manual introduces them, and
`help(model.simulate)` prints the same text in a session.

Quantities are SI numbers or texts with a unit, `"2 s"`. Arrays are NumPy arrays of double
precision, with their shapes in brackets: `(n, 3)`.
"""


def python_pages() -> list[Page]:
    """Write an overview and one page for each topic."""
    lines = [*_ABOUT.splitlines(), ""]
    pages = []
    for path, title, names in TOPICS:
        page = Page(f"python/{path}.md", title, "", [f"# {title}", ""])
        if title == "Control":
            page.lines += _text(control)
        lines += [f"## {title}", "", "| | |", "|---|---|"]
        for where in names:
            thing = found(where)
            shown = shown_name(where)
            lines.append(f"| [`{shown}`]({path}.md#{anchor(shown)}) | {_first_line(thing)} |")
            page.lines += _entry(thing, shown)
        lines.append("")
        pages.append(page)
    lines += ["## Types of arguments", "", *_types(pages)]
    return [Page("python/index.md", "Overview", "", lines), *pages]


def shown_name(where: str) -> str:
    """Return the name by which a program has an object: `bgc.Model`, `control.margins`, `Study`."""
    place, _, name = where.rpartition(".")
    if place == "bgc":
        return where
    return f"control.{name}" if place == control.__name__ else name


def anchor(shown: str) -> str:
    """Return the anchor of an object's heading."""
    return shown.replace(".", "-")


def documented(thing: type) -> Iterator[tuple[str, Any]]:
    """Yield the members of a class that its page shows: own ones first, then inherited ones."""
    seen: set[str] = set()
    for owner in thing.__mro__:
        if not owner.__module__.startswith("bgc."):
            continue
        for name, member in vars(owner).items():
            inner = name in _INNER.get(owner.__name__, ()) or name in _INNER.get(thing.__name__, ())
            if name.startswith("_") or name in seen or inner:
                continue
            seen.add(name)
            if inspect.isfunction(member) or isinstance(member, property | cached_property):
                yield name, member


def found(where: str) -> Any:
    """Return an object by its place: `bgc.Model`, `bgc.runtime.control.margins`."""
    place, _, name = where.rpartition(".")
    return getattr(bgc if place == "bgc" else importlib.import_module(place), name)


def _first_line(thing: Any) -> str:
    text = inspect.getdoc(thing) or ""
    return " ".join(text.partition("\n\n")[0].split())


# --- entries --------------------------------------------------------------------------------


def _entry(thing: Any, shown: str) -> list[str]:
    """Write a function, or a class with its members."""
    lines = [f"## `{shown}` {{#{anchor(shown)}}}", ""]
    if not inspect.isclass(thing):
        return [*lines, *_signature(thing, shown), *_text(thing)]
    lines += _text(thing)
    for base in thing.__mro__[1:]:
        sections = dict(_sections(inspect.cleandoc(base.__doc__ or "")))
        if base.__module__.startswith("bgc.") and "Attributes" in sections:
            lines += _section("Attributes", sections["Attributes"])
    for name, member in documented(thing):
        lines += [f"### `{name}` {{#{anchor(f'{shown}.{name}')}}}", ""]
        if inspect.isfunction(member):
            lines += _signature(member, f"{shown.rpartition('.')[2].lower()}.{name}")
        lines += _text(member)
    return lines


def _signature(function: Callable[..., Any], shown: str) -> list[str]:
    """Write the call with its arguments, their types and defaults; one a line if it is long."""
    signature = inspect.signature(function)
    some = [p for p in signature.parameters.values() if p.name != "self"]
    ends = signature.return_annotation
    back = f" -> {ends}" if ends is not inspect.Signature.empty else ""
    shown_ones = []
    for k, parameter in enumerate(some):
        if parameter.kind is parameter.KEYWORD_ONLY and (
            k == 0 or some[k - 1].kind is not parameter.KEYWORD_ONLY
        ):
            shown_ones.append("*")
        default = "" if parameter.default is parameter.empty else f" = {parameter.default!r}"
        shown_ones.append(f"{parameter.name}: {parameter.annotation}{default}")
    line = f"{shown}({', '.join(shown_ones)}){back}"
    if len(line) > _WIDTH:
        each = "".join(f"    {one},\n" for one in shown_ones)
        line = f"{shown}(\n{each}){back}"
    return ["```python", *line.splitlines(), "```", ""]


def _text(thing: Any) -> list[str]:
    """Write a docstring."""
    lines = []
    for title, body in _sections(inspect.getdoc(thing) or ""):
        lines += _section(title, body)
    return lines


def _sections(text: str) -> Iterator[tuple[str, list[str]]]:
    """Split a docstring at its underlined headings; what stands before them has no title."""
    title, body = "", list[str]()
    for line, below in pairwise([*text.splitlines(), ""]):
        if re.fullmatch(r"-{3,}", below) and line.strip():
            yield title, body
            title, body = line.strip(), []
        elif not re.fullmatch(r"-{3,}", line):
            body.append(line)
    yield title, body


def _section(title: str, body: list[str]) -> list[str]:
    heading = [f"**{title}**", ""] if title else []
    if title in _LISTS:
        return [*heading, *_definitions(body), ""]
    return [*heading, *_with_examples(body), ""]


def _definitions(body: list[str]) -> Iterator[str]:
    """Write terms, which are not indented, with their indented meanings."""
    for line in textwrap.dedent("\n".join(body)).strip().splitlines():
        if line and not line.startswith(" "):
            # A line may name several parameters or errors.
            yield from ("", ", ".join(f"`{name}`" for name in line.split(", ")))
            first = True
        elif line.strip():
            yield (":   " if first else "    ") + _linked(line.strip())
            first = False
        else:
            yield ""


def _with_examples(body: list[str]) -> Iterator[str]:
    """Write paragraphs; lines of a session become a block of code, its outputs comments."""
    inside = False
    for line in body:
        if line.startswith((">>> ", "... ")) or (inside and line.strip()):
            if not inside:
                yield "```python"
            inside = True
            code = re.sub(r"\s*# doctest: \+\w+", "", line)
            yield code[4:] if line[:4] in (">>> ", "... ") else f"# {code}"
            continue
        if inside:
            yield "```"
        inside = False
        yield _linked(line)
    if inside:
        yield "```"


def _linked(text: str) -> str:
    """Let codes of diagnostics lead to their pages."""

    def link(found: re.Match[str]) -> str:
        code = found[0]
        return code if code[0] == "`" else f"[{code}](../{diagnostic_place(code)})"

    return _CODE_OR_NUMBER.sub(link, text)


# --- types ----------------------------------------------------------------------------------


def _types(pages: list[Page]) -> Iterator[str]:
    """Explain the names of types in signatures by the texts below their definitions."""
    text = "\n".join(line for page in pages for line in page.lines)
    used = set(re.findall(r"[A-Z]\w+", "\n".join(re.findall(r"```python\n(.*?)```", text, re.S))))
    for name, meaning in sorted(_aliases().items()):
        if name in used:
            yield from (f"`{name}`", f":   {_linked(' '.join(meaning.split()))}", "")


def _aliases() -> dict[str, str]:
    """Return the aliases of types in the runtime, with the texts below their definitions."""
    found: dict[str, str] = {}
    for file in sorted(Path(runtime_path[0]).rglob("*.py")):
        for node, below in pairwise(ast.parse(file.read_text("utf-8")).body):
            match node, below:
                case (
                    ast.AnnAssign(ast.Name(alias), ast.Name("TypeAlias")),
                    ast.Expr(ast.Constant(str(meaning))),
                ):
                    found.setdefault(alias, meaning)
    return found
