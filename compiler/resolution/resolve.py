"""Read a `.bg` file with all its imports, and resolve the names visible in each file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from bgc.diagnostics.catalogue import imports, names
from bgc.diagnostics.catalogue.files import file_missing
from bgc.diagnostics.collection import Report
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.parse import parse, read_source
from bgc.grammar.peers import element_advice, part_of
from bgc.language.elements import ELEMENTS
from bgc.resolution.conformance import check_conformance, check_interfaces
from bgc.resolution.library import library_folder, library_modules, module_path, scene_file
from bgc.resolution.modules import Declared, LoadedFile, Module, Package, flatten
from bgc.resolution.name_check import check_names
from bgc.resolution.parse_cached import Parsed, parse_cached
from bgc.resolution.scene_inheritance import collect_scenes

MAX_ANCESTORS = 100  # of a model, by `is`

_DECLARATION = re.compile(r"^(?:model|interface) (\w+)", re.MULTILINE)
_DOMAIN = re.compile(r"^(?:pseudo )?domain (\w+)", re.MULTILINE)

_EXAMINED = 10_000  # errors in the files of a package that an editor shows

__all__ = ["Package", "Reader", "examine", "library_folder", "library_modules", "load", "load_text"]


class Reader:
    """Reads and parses the files of a package from the disk; an editor's reads its buffers."""

    def has(self, path: Path) -> bool:
        """Return whether there is a file; False for a path that the system rejects."""
        return _is_file(path)

    def read(self, path: Path, name: str) -> Parsed:
        """Read and parse a file; `name` is that of its messages. BgError if it cannot be read."""
        return parse_cached(Source(name, read_source(path).text))


def load(path: Path) -> Package:
    """Read a file with all its imports; BgError lists all errors in them."""
    try:
        source = read_source(path)
    except BgError as problem:
        found = scene_file(path.name)
        if found is None or path.exists():
            raise
        raise BgError([file_missing(str(path), str(found))]) from problem
    return _load_root(parse_cached(source), path)


def load_text(text: str, name: str = "<text>") -> Package:
    """Read a text with all its imports, which are relative to the working folder."""
    return _load_root(parse(Source(name, text)), None)


def examine(path: Path, reader: Reader) -> tuple[Package, tuple[Diagnostic, ...]]:
    """Read a file with its imports as far as possible, and return all that is wrong with it.

    The package may hold less than the texts: declarations with syntax errors are left out, and
    names that are not declared stay unresolved. It can be compiled if no diagnostic is an error.

    Raises
    ------
    BgError
        The file itself cannot be read, or there are thousands of errors.
    """
    loader = _Loader(reader, Report(_EXAMINED))
    root = loader.read(reader.read(path, str(path)), path, path.resolve())
    modules = tuple(loader.modules.values())
    package = Package(root, modules, tuple(loader.files), loader.report.warnings)
    if loader.report.errors:
        return package, (*loader.report.errors, *loader.report.warnings)
    checks = Report()
    try:
        for check in _CHECKS:
            for module in modules:
                check(module, checks)
            checks.raise_errors()
    except BgError as problem:
        return package, (*problem.diagnostics, *package.warnings)
    return package, (*package.warnings, *checks.warnings)


def _load_root(parsed: Parsed, path: Path | None) -> Package:
    loader = _Loader(Reader(), Report())
    root = loader.read(parsed, path, path.resolve() if path else None)
    modules = tuple(loader.modules.values()) if path else (*loader.modules.values(), root)
    for check in _CHECKS:
        for module in modules:
            check(module, loader.report)
        loader.report.raise_errors()
    return Package(root, modules, tuple(loader.files), loader.report.warnings)


class _Loader:
    """Reads each file once, imports first."""

    def __init__(self, reader: Reader, report: Report) -> None:
        self._reader = reader
        self.report = report
        self.modules: dict[Path, Module] = {}
        self.files: list[LoadedFile] = []
        self._open: list[tuple[Path | None, str]] = []

    def read(self, parsed: Parsed, path: Path | None, key: Path | None) -> Module:
        file, diagnostics = parsed
        source = file.source
        self.report.add(*diagnostics)
        module = Module(file)
        self._open.append((key, source.name))
        for item in file.imports:
            with self.report.collecting():
                imported = self._import(item, source, path)
                if imported is not None:
                    self._merge_names(imported, module, item.span)
        self._open.pop()
        self._declare(module)
        self.files.append(LoadedFile(path, source))
        if key is not None:
            self.modules[key] = module
        return module

    def _import(self, item: syntax.Import, source: Source, path: Path | None) -> Module | None:
        target, name = self._locate(item, source, path)
        if target is None:
            return None
        key = target.resolve()
        if key in self.modules:
            return self.modules[key]
        opened = [k for k, _ in self._open]
        if key in opened:
            cycle = [n for _, n in self._open[opened.index(key) :]]
            self.report.add(imports.import_cycle(item.span, [*cycle, cycle[0]]))
            return None
        return self.read(self._reader.read(target, name), target, key)

    def _locate(
        self, item: syntax.Import, source: Source, path: Path | None
    ) -> tuple[Path | None, str]:
        """The imported file and its name for messages; None, with a report, if it is missing."""
        match item:
            case syntax.ImportFile():
                folder = path.parent if path else Path()
                target = folder / item.path
                if not self._reader.has(target):
                    self.report.add(imports.imported_file_missing(item.span, item.path))
                    return None, ""
                if {target.suffix, target.resolve().suffix} != {".bg"}:
                    self.report.add(imports.not_a_model_file(item.span, item.path))
                    return None, ""
                shown = source.name.rpartition("/")[0]
                return target, f"{shown}/{item.path}" if shown else item.path
            case syntax.ImportModule():
                dotted = ".".join(item.path)
                target = library_folder().joinpath(*item.path).with_suffix(".bg")
                if not self._reader.has(target):
                    found = library_modules()
                    self.report.add(imports.library_module_missing(item.span, dotted, found))
                    return None, ""
                return target, f"library/{'/'.join(item.path)}.bg"

    # --- names ----------------------------------------------------------------------

    def _merge_names(self, imported: Module, module: Module, span: Span) -> None:
        """Make all names visible in the imported file visible in the importing one."""
        for theirs, ours in zip(imported.tables(), module.tables(), strict=True):
            for name, declared in theirs.items():
                present = ours.setdefault(name, declared)
                if present.syntax is not declared.syntax:
                    places = [_name_span(present.syntax), _name_span(declared.syntax)]
                    self.report.add(imports.name_imported_twice(span, name, places))
        for name, scenes in imported.seen_scenes.items():
            seen = module.seen_scenes.setdefault(name, [])
            seen += [scene for scene in scenes if scene not in seen]

    def _declare(self, module: Module) -> None:
        """Enter the file's own declarations; models and domains share one namespace."""
        seen: dict[tuple[bool, str], Span] = {}
        for is_type, table in zip((True, True, False, False), module.tables(), strict=True):
            for name, declared in table.items():
                seen[is_type, name] = _name_span(declared.syntax)
        for declaration in module.file.declarations:
            if isinstance(declaration, syntax.Scene):
                continue
            is_type = isinstance(declaration, syntax.Model | syntax.Domain)
            if is_type and declaration.name in ELEMENTS:
                self.report.add(names.name_of_element(declaration.name_span, declaration.name))
                continue
            first = seen.setdefault((is_type, declaration.name), declaration.name_span)
            if first is not declaration.name_span:
                self.report.add(
                    names.duplicate_name(declaration.name_span, declaration.name, first)
                )
                continue
            match declaration:
                case syntax.Model():
                    module.models[declaration.name] = Declared(declaration, module)
                case syntax.Domain():
                    module.domains[declaration.name] = Declared(declaration, module)
                case syntax.Value():
                    module.constants[declaration.name] = Declared(declaration, module)
                case syntax.Function():
                    module.functions[declaration.name] = Declared(declaration, module)
        scenes: dict[str, syntax.Scene] = {}
        for scene in module.scene_declarations:
            if scenes.setdefault(scene.name, scene) is not scene:
                first = scenes[scene.name].name_span
                self.report.add(names.duplicate_name(scene.name_span, scene.name, first))
        collect_scenes(module, self.report)


def _is_file(path: Path) -> bool:
    """Return whether a path names a file; False for a path that the system rejects."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _name_span(declaration: syntax.Declaration) -> Span:
    return declaration.name_span


# --- types ------------------------------------------------------------------------------


def _check_types(module: Module, report: Report) -> None:
    """Report every undeclared type name in the file's own declarations."""
    for declaration in module.file.declarations:
        if report.is_full:
            return
        match declaration:
            case syntax.Model():
                _check_model(declaration, module, report)
            case syntax.Scene() if declaration.model is not None:
                _check_root(declaration.model, module, report)
            case _:
                pass


def _check_members(module: Module, report: Report) -> None:
    """Check interfaces, the models that fit them, and the names in all models of a file."""
    check_interfaces(module, report)
    for declared in module.own_models:
        check_conformance(declared, report)
        check_names(declared, report)


_CHECKS = (_check_types, _check_members)
"""Checks of all files, in order; each runs if the one before found no error."""


def _check_model(model: syntax.Model, module: Module, report: Report) -> None:
    declared = module.models.get(model.name)
    if declared is None or declared.syntax is not model:
        return  # reported as a duplicate
    if model.base is not None:
        base = model.base
        if base.name not in module.models:
            if base.name in ELEMENTS or base.name in module.domains:
                what = "an element" if base.name in ELEMENTS else "a domain"
                report.add(names.not_a_model(base.name_span, base.name, what))
            else:
                home = _home_in_library(base.name)
                report.add(names.unknown_type(base.name_span, base.name, module.models, home))
        else:
            _check_ancestry(declared, report)
    for item in flatten(model.items):
        if report.is_full:
            return
        match item:
            case syntax.Part():
                for use in (item.type, item.default):
                    if use is not None:
                        check_type(use, module, report)
            case syntax.Port() if item.domain is not None and item.domain not in module.domains:
                of_library = _library_index(_DOMAIN)
                report.add(names.unknown_domain(item.span, item.domain, module.domains, of_library))
            case _:
                pass


def _check_ancestry(declared: Declared[syntax.Model], report: Report) -> None:
    """Report a model that is its own ancestor by `is`, or that has too many ancestors."""
    lineage = [declared]
    seen = {id(declared.syntax)}
    while (base := lineage[-1].syntax.base) is not None:
        parent = lineage[-1].module.models.get(base.name)
        if parent is None:
            return
        if parent.syntax is declared.syntax:
            places = [d.syntax.name_span for d in lineage if d.module is declared.module]
            if declared.syntax.name_span.start > min(place.start for place in places):
                return  # reported where the cycle is first written
            cycle = [*(d.syntax.name for d in lineage), declared.syntax.name]
            assert declared.syntax.base is not None
            report.add(names.inheritance_cycle(declared.syntax.base.name_span, cycle))
            return
        if id(parent.syntax) in seen:
            return  # a cycle among its ancestors, which is reported there
        lineage.append(parent)
        seen.add(id(parent.syntax))
        if len(lineage) > MAX_ANCESTORS + 1:
            assert declared.syntax.base is not None
            report.add(names.too_many_ancestors(declared.syntax.base.name_span, MAX_ANCESTORS))
            return


def _check_root(use: syntax.TypeUse, module: Module, report: Report) -> None:
    model = module.models.get(use.name)
    if model is not None and not model.syntax.interface:
        return
    if model is not None:
        report.add(names.not_a_model(use.name_span, use.name, "an interface"))
    elif use.name in ELEMENTS:
        report.add(names.not_a_model(use.name_span, use.name, "an element"))
    elif use.name in module.domains:
        report.add(names.not_a_model(use.name_span, use.name, "a domain"))
    else:
        home = _home_in_library(use.name)
        report.add(names.unknown_type(use.name_span, use.name, module.models, home))


def check_type(use: syntax.TypeUse, module: Module, report: Report) -> bool:
    """Return whether the type of a part is declared; an undeclared type is reported."""
    if use.name in module.models or use.name in ELEMENTS:
        return True
    if use.name in module.domains:
        report.add(names.not_a_model(use.name_span, use.name, "a domain"))
    else:
        candidates = [*module.models, *ELEMENTS]
        home, advice = _home_in_library(use.name), element_advice(use.name)
        if part := part_of(use.name):
            library = f"the library has `{part}`: `import {_home_in_library(part)};`"
            advice = f"{advice}; {library}" if advice else library
        report.add(names.unknown_type(use.name_span, use.name, candidates, home, advice))
    return False


def _home_in_library(name: str) -> str | None:
    """The library module that declares a model or interface, for the help of a message."""
    return _library_index().get(name)


@cache
def _library_index(declaration: re.Pattern[str] = _DECLARATION) -> Mapping[str, str]:
    """The models and interfaces of the library, or its domains, each with its module."""
    homes: dict[str, str] = {}
    for module in library_modules():
        for name in declaration.findall(module_path(module).read_text("utf-8")):
            homes.setdefault(name, module)
    return homes
