"""Modules and parts of the installed library as entries of the reference.

Names come from a search of the files; only a file that is asked for is parsed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

from bgc.record_class import dataclass, replace
from bgc.reference.entry import Block, Code, Entry, Group, Text, first_sentence, rows_of
from bgc.reference.parts import declaration_entry, file_doc, file_entry
from bgc.resolution.library import library_modules, module_path
from bgc.resolution.modules import Module

_DECLARATION = re.compile(
    r"^(?P<doc>(?:///[^\n]*\n)*)"
    r"(?:pseudo )?(?P<kind>model|interface|domain|function|const|param|scene) (?P<name>\w+)"
    r"(?:\[[^\]\n]*\])?(?: is (?P<base>\w+))?",
    re.MULTILINE,
)


@dataclass(frozen=True, slots=True)
class Declaration:
    """A declaration of the library, as a search of its file finds it."""

    module: str
    kind: str
    name: str
    base: str
    doc: str
    text: str

    @property
    def full_name(self) -> str:
        """`crane.beam.Beam`."""
        return f"{self.module}.{self.name}"


@cache
def declarations() -> tuple[Declaration, ...]:
    """Return all declarations of the library, in the order of modules and files."""
    return tuple(found for module in library_modules() for found in _declarations_of(module))


def module_text(module: str) -> str:
    """Return the text of a module's file."""
    return module_path(module).read_text("utf-8")


def _declarations_of(module: str) -> Iterator[Declaration]:
    content = module_text(module)
    found = [*_DECLARATION.finditer(content)]
    ends = [*(match.start() for match in found[1:]), len(content)]
    for match, end in zip(found, ends, strict=False):
        doc = "\n".join(line.removeprefix("///").strip() for line in match["doc"].splitlines())
        text = content[match.start() : end]
        yield Declaration(module, match["kind"], match["name"], match["base"] or "", doc, text)


def fitting(name: str) -> tuple[str, ...]:
    """Return the models that are an interface or model, by its full name, or extend one that is.

    An example may declare a model of a name that a module of parts has, too: its own comes first,
    and no other module imports it.
    """
    found: list[str] = []
    above = {name}
    for _ in declarations():
        more = [d for d in declarations() if _base_of(d) in above and d.name not in found]
        if not more:
            break
        found += [d.name for d in more]
        above |= {d.full_name for d in more}
    return tuple(found)


@cache
def _base_of(declared: Declaration) -> str:
    """The full name of what a declaration `is`, empty without."""
    others = [d for d in declarations() if d.name == declared.base]
    own = [d for d in others if d.module == declared.module]
    parts = [d for d in others if not d.module.startswith("examples.")]
    return (own or parts or others)[0].full_name if others else ""


# --- entries --------------------------------------------------------------------------------


@cache
def _modules() -> dict[str, str]:
    return {module: first_sentence(file_doc(module_text(module))) for module in library_modules()}


@cache
def _summaries() -> dict[str, str]:
    return _modules() | {d.full_name: first_sentence(d.doc) for d in declarations()}


def entry(name: str) -> Entry:
    """Describe a module, `crane.beam`, or a declaration, `crane.beam.Beam`."""
    if name in library_modules():
        file = read(name)
        described = file_entry(file, name, "library module")
        return replace(described, body=(Code(f"import {name};"), *described.body))
    module, _, last = name.rpartition(".")
    file = read(module)
    found = next(d for d in file.file.declarations if d.name == last)
    fits = fitting(name)
    place = f"Source: library/{module.replace('.', '/')}.bg (`import {module};`)."
    described = declaration_entry(found, file, name, place)
    filled: tuple[Block, ...] = (
        (Text(f"Extended or filled by: {', '.join(fits)}."),) if fits else ()
    )
    return replace(
        described,
        kind=f"library {described.kind}",
        body=(*described.body[:-1], *filled, described.body[-1]),
        see_also=(*described.see_also, module),
    )


@cache
def read(module: str) -> Module:
    """Read a module with what it imports."""
    # Lark, which takes 40 ms to import, parses: most look-ups are of other names.
    from bgc.resolution.resolve import load

    return load(module_path(module)).root


def _others(text: str) -> tuple[Entry, ...]:
    """Find declarations by their last name."""
    return tuple(entry(d.full_name) for d in declarations() if d.name == text)


def _texts() -> dict[str, tuple[str, str]]:
    modules = {name: (summary, file_doc(module_text(name))) for name, summary in _modules().items()}
    return modules | {d.full_name: (first_sentence(d.doc), d.text) for d in declarations()}


GROUP = Group(
    "library",
    "modules of the library",
    _summaries,
    entry,
    (
        Text(
            "`import crane.beam;` makes the parts of a module visible; `bgc doc crane.beam` lists "
            "them."
        ),
    ),
    ("modules", "parts"),
    lambda: (rows_of(_modules()),),
    other=_others,
    texts=_texts,
)
"""The installed library."""
