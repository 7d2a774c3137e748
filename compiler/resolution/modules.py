"""A package: files with the names visible in each, as elaboration expects them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Generic, TypeVar

from bgc.diagnostics.catalogue.fmu_parts import fmu_unreadable
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.record_class import dataclass, field
from bgc.values.data_files import DataFile, read_data
from bgc.values.fmu_files import FmuFault, FmuFile, read_fmu

D = TypeVar("D", bound=syntax.Declaration)


@dataclass(frozen=True, slots=True, eq=False)
class Declared(Generic[D]):
    """A declaration and the file in which its names are resolved."""

    syntax: D
    module: Module


@dataclass(frozen=True, slots=True, eq=False)
class Inherited:
    """A statement from a scene further up the line of `is`, with slots that scenes below filled.

    The parts that it names may have been removed with what was in one of these `slots`.
    """

    item: syntax.SceneItem
    slots: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class WholeScene:
    """A scene with all its statements: those of the scenes that it extends first.

    `model` is the scene's own or an inherited one, `inherited` lists the statements from further
    up, `bases` counts the scenes that it extends.
    """

    declaration: syntax.Scene
    model: syntax.TypeUse
    items: tuple[syntax.SceneItem, ...]
    inherited: tuple[Inherited, ...] = ()
    bases: int = 0


@dataclass(slots=True, eq=False)
class Module:
    """A file and the names visible in it: its own and those of all its imports.

    Types (models, interfaces, domains) and values (constants, functions) are two namespaces.
    `scenes` are those of the file itself, complete with what they take over from other scenes;
    `seen_scenes` are those that a scene may extend, by name: the file's own, or imported ones.
    """

    file: syntax.File
    models: dict[str, Declared[syntax.Model]] = field(default_factory=dict)
    domains: dict[str, Declared[syntax.Domain]] = field(default_factory=dict)
    constants: dict[str, Declared[syntax.Value]] = field(default_factory=dict)
    functions: dict[str, Declared[syntax.Function]] = field(default_factory=dict)
    scenes: tuple[WholeScene, ...] = ()
    seen_scenes: dict[str, list[WholeScene]] = field(default_factory=dict)

    def tables(self) -> tuple[dict[str, Declared[syntax.Declaration]], ...]:
        """The tables of names, in the same order for every module."""
        return (self.models, self.domains, self.constants, self.functions)  # type: ignore[return-value]

    @property
    def scene_declarations(self) -> tuple[syntax.Scene, ...]:
        """The scenes of the file itself, as they are written."""
        return tuple(d for d in self.file.declarations if isinstance(d, syntax.Scene))

    @property
    def own_models(self) -> tuple[Declared[syntax.Model], ...]:
        """The models declared in the file itself, without interfaces."""
        return tuple(
            self.models[d.name]
            for d in self.file.declarations
            if isinstance(d, syntax.Model) and not d.interface
        )


@dataclass(frozen=True, slots=True)
class LoadedFile:
    """A file that was read; `path` is None for a text that is not in a file."""

    path: Path | None
    source: Source


@dataclass(frozen=True, slots=True)
class Package:
    """A file with all its imports. `files` lists every file read, the root last.

    `data` are the data files that its expressions have read so far, by path and name, `fmus` the
    FMUs likewise.
    """

    root: Module
    modules: tuple[Module, ...]
    files: tuple[LoadedFile, ...]
    warnings: tuple[Diagnostic, ...]
    data: dict[tuple[Path, str], DataFile] = field(default_factory=dict, compare=False)
    fmus: dict[tuple[Path, str], FmuFile] = field(default_factory=dict, compare=False)

    def data_file(self, name: str, span: Span) -> DataFile:
        """A data file that an expression names, relative to the file of the expression.

        It is read once; BgError if it cannot be read.
        """
        key = self._located(name, span)
        if key not in self.data:
            self.data[key] = read_data(*key, span)
        return self.data[key]

    def fmu_file(self, name: str, span: Span) -> FmuFile:
        """An FMU that an expression names, relative to the file of the expression.

        It is read once; BgError BG273 if it cannot be read.
        """
        key = self._located(name, span)
        if key not in self.fmus:
            try:
                self.fmus[key] = read_fmu(*key)
            except FmuFault as reason:
                raise BgError([fmu_unreadable(span, key[1], str(reason))]) from reason
        return self.fmus[key]

    @property
    def read_files(self) -> Iterator[tuple[str, Path, str]]:
        """Name, path and digest of each data file and each FMU that has been read."""
        files: Iterable[DataFile | FmuFile] = (*self.data.values(), *self.fmus.values())
        for (path, name), file in zip((*self.data, *self.fmus), files, strict=True):
            yield name, path, file.digest

    def _located(self, name: str, span: Span) -> tuple[Path, str]:
        """The path of a file that an expression names, and its name in messages."""
        here = next((file for file in self.files if file.source is span.source), None)
        folder = here.path.parent if here is not None and here.path is not None else Path()
        shown_folder = span.source.name.rpartition("/")[0] if here is not None else ""
        return folder / name, f"{shown_folder}/{name}" if shown_folder else name

    @property
    def scene_names(self) -> tuple[str, ...]:
        """The names of the root file's scenes, in order."""
        return tuple(scene.declaration.name for scene in self.root.scenes)

    @property
    def sources(self) -> tuple[Source, ...]:
        """The texts of all files, the root's last."""
        return tuple(file.source for file in self.files)


def flatten(items: tuple[syntax.Item, ...]) -> Iterator[syntax.Item]:
    """All items, including those within `for` and both branches of `if`."""
    for item in items:
        yield item
        match item:
            case syntax.For() | syntax.Sample():
                yield from flatten(item.items)
            case syntax.If():
                yield from flatten(item.yes)
                yield from flatten(item.no)
            case _:
                pass


def ancestors(declared: Declared[syntax.Model]) -> Iterator[Declared[syntax.Model]]:
    """The model, followed by its base models and interfaces, nearest first."""
    yield declared
    while (base := declared.syntax.base) is not None:
        declared = declared.module.models[base.name]
        yield declared


def fitting_models(
    interface: syntax.Model, seen: Mapping[str, Declared[syntax.Model]]
) -> list[str]:
    """The names of the visible models that implement the interface, sorted."""
    return sorted(
        name
        for name, declared in seen.items()
        if not declared.syntax.interface and any(a.syntax is interface for a in ancestors(declared))
    )
