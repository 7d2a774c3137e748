"""Ladders of coarser forms of a scene's parts: smaller dimensions, and other models in slots.

A dimension steps down by halves (`set boom.n = 4`, 2, 1, 0); a slot takes the models that meet its
interface (`use elbow.lock = Rigid[5]`), with the arguments of the present one that they take (`use
line = ShortLine(..)`). Parts of one array go together: `boom.flexure[*].lock`.
Only forms with fewer variables than the scene's own are kept; the numbers of the elaborated graph
tell, so that nothing has to be compiled for it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from itertools import zip_longest
from pathlib import Path

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.elaboration.instances.census import Census
from bgc.elaboration.scenes.variants import Change, variants_of, with_changes
from bgc.ir.graph import FlatGraph, Storage, ports_of
from bgc.options import Options
from bgc.record_class import dataclass, field
from bgc.resolution.modules import Package
from bgc.resolution.resolve import load

_INDEX = re.compile(r"\[[^\]]*\]")
_BEHIND_NAME = re.compile(r"\W.*")
_KEEPS = "(..)"  # of a type that takes arguments of the one it replaces
_MOST_FORMS = 6  # of a part, the coarsest first


@dataclass(frozen=True, slots=True)
class Form:
    """Changes that give a part a coarser form; in their names, `*` stands for indices of arrays.

    `saved` is the share of the scene's variables that it does without.
    """

    changes: tuple[Change, ...]
    saved: float


@dataclass(frozen=True, slots=True)
class Ladder:
    """The coarser forms of a part, and its path.

    Models that take arguments of the present one come first, and the coarsest first among them.
    """

    part: str
    forms: tuple[Form, ...]


@dataclass(frozen=True, slots=True)
class Ladders:
    """The coarser forms of all parts; `complete` if there was time to look at every one."""

    all: tuple[Ladder, ...]
    complete: bool = True


@dataclass(slots=True)
class Elaborations:
    """Flat graphs of a scene with changes, from one reading of its files."""

    path: Path
    options: Options
    package: Package = field(init=False)
    whole: FlatGraph = field(init=False)

    def __post_init__(self) -> None:
        self.package = load(self.path)
        self.whole = self.graph(())

    def graph(self, changes: Sequence[Change]) -> FlatGraph:
        """Elaborate the scene with changes. Raises BgError where they do not fit."""
        options = with_changes(self.options, changes)
        return compile_scene(self.path, options, package=self.package, until="elaborate").graph

    def expanded(self, changes: Sequence[Change]) -> tuple[Change, ...]:
        """Replace each change of an array by those of its parts, as many as the scene then has."""
        plain = [change for change in changes if "*" not in change.name]
        if len(plain) == len(changes):
            return tuple(changes)
        graph = self.graph(plain) if plain else self.whole
        names = [slot.path for slot in graph.slots]
        names += [f"{part.path}.{name}" for part in graph.parts for name, _ in part.dims]
        return tuple(
            Change(name, change.value, change.is_use)
            for change in changes
            for name in ([change.name] if "*" not in change.name else _matching(change, names))
        )

    def ladders(self, is_over: Callable[[], bool]) -> Ladders:
        """Find the coarser forms of all parts: first one of each part, then the others.

        Where `is_over`, the search ends with those that were found so far.
        """
        found: dict[str, list[Form]] = {}
        complete = True
        parts = (*self._dimensions(), *self._slots())
        turns = zip_longest(*([(part, one) for one in ways] for part, ways in parts))
        for part, ways in (each for turn in turns for each in turn if each is not None):
            if is_over():
                complete = False
                break
            form = self._form(ways)
            if form is not None:
                found.setdefault(part, []).append(form)
        ladders = (
            Ladder(part, tuple(sorted(forms, key=_preference)[:_MOST_FORMS]))
            for part, forms in found.items()
        )
        return Ladders(tuple(ladders), complete)

    def _form(self, choices: Sequence[tuple[Change, ...]]) -> Form | None:
        """The first of some changes that fits, if it saves variables and keeps all columns."""
        size, columns = _size(self.whole), _columns(self.whole)
        for changes in choices:
            try:
                graph = self.graph(self.expanded(changes))
            except BgError:
                continue
            saved = 1 - _size(graph) / size
            return Form(changes, saved) if saved > 0 and _columns(graph) == columns else None
        return None

    def _dimensions(self) -> Iterator[tuple[str, list[list[tuple[Change, ...]]]]]:
        """Each dimension with its smaller sizes: alone, or with equal ones of the parts inside."""
        parts = {_pattern(part.path): part for part in self.whole.parts}
        for pattern, part in parts.items():
            for name, size in part.dims:
                inside = [
                    _joined(other, each)
                    for other, one in parts.items()
                    for each, same in one.dims
                    if same == size and other.startswith(f"{pattern}." if pattern else "")
                ]
                own = _joined(pattern, name)
                if size > 0 and self._has_contents(pattern):
                    yield own, [_sized(own, inside, less) for less in reversed(_halves(size))]

    def _slots(self) -> Iterator[tuple[str, list[list[tuple[Change, ...]]]]]:
        """Each slot, or slots of an array, with the models that fill all of them."""
        by_pattern: dict[str, dict[str, set[str]]] = {}
        paths: dict[str, set[str]] = {}
        for change in variants_of(self.package, self.whole):
            pattern = _pattern(change.name)
            paths.setdefault(pattern, set()).add(change.name)
            by_pattern.setdefault(pattern, {}).setdefault(change.value, set()).add(change.name)
        for pattern, values in by_pattern.items():
            largest = self._parts_below(min(paths[pattern]))
            common = [
                value
                for value, seen in values.items()
                if seen == paths[pattern] and self._parts_of(value) <= largest
            ]
            if self._has_contents(pattern):
                yield pattern, [[(Change(pattern, value),)] for value in common]

    def _parts_below(self, path: str) -> int:
        """The parts and elements of a part of the whole scene."""
        names = [element.name for element in self.whole.elements]
        names += [part.path for part in self.whole.parts]
        return sum(name.startswith(f"{path}.") for name in names)

    def _parts_of(self, model: str) -> float:
        """The parts of a model that are always there, from its text alone."""
        declared = self.package.root.models.get(_BEHIND_NAME.sub("", model))
        return Census().least_parts(declared) if declared is not None else float("inf")

    def _has_contents(self, pattern: str) -> bool:
        """Return whether a part has elements or states: else nothing is saved by another one."""
        named = (*self.whole.elements, *self.whole.states)
        return not pattern or any(_pattern(each.name).startswith(f"{pattern}.") for each in named)


def _preference(form: Form) -> tuple[bool, float]:
    """Models that take the arguments of the present one first, then those that save most."""
    keeps = all(_KEEPS in change.value or not change.is_use for change in form.changes)
    return not keeps, -form.saved


def _halves(size: int) -> list[int]:
    """The halves of a size, of a half and so on, down to 0."""
    found = []
    while size > 0:
        size //= 2
        found.append(size)
    return found


def _sized(own: str, inside: Sequence[str], size: int) -> list[tuple[Change, ...]]:
    """The ways to set a dimension: alone, with inner ones of its name, with all, or one larger."""

    def sets(names: Sequence[str], to: int) -> tuple[Change, ...]:
        return tuple(Change(name, str(to), is_use=False) for name in names)

    others = [name for name in inside if name != own]
    alike = [name for name in others if name.rpartition(".")[2] == own.rpartition(".")[2]]
    found = [sets([own, *more], size) for more in ([], alike, others)]
    return [*found, sets([own], size + 1)] if size else found


def _pattern(path: str) -> str:
    return _INDEX.sub("[*]", path)


def _joined(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _matching(change: Change, names: Sequence[str]) -> list[str]:
    glob = change.name.replace("[*]", "[[]*]")
    return [name for name in names if fnmatchcase(name, glob) and _pattern(name) == change.name]


def _size(graph: FlatGraph) -> float:
    """The variables of a scene: its states, and shares of ports of elements and of expressions."""
    ports = sum(len(ports_of(element)) for element in graph.elements)
    stored = sum(len(e.ports) for e in graph.elements if isinstance(e, Storage))
    states = stored + len(graph.states) + len(graph.unknowns)
    return states + ports / 10 + len(graph.dag) / 1000


def _columns(graph: FlatGraph) -> list[str]:
    return [observation.name for observation in graph.observations]
