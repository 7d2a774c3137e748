"""Configurations to measure: methods with tolerances or steps, kept Jacobians, variants."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import zip_longest
from typing import TypeAlias

from bgc.elaboration.scenes.variants import Change
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.running.quantity import spelled_time

RTOLS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
KEEPS = (1, 2, 5)
_FACTORS = (5.0, 2.0, 1.0, 0.5, 0.2)  # times the scene's step, or a typical one

Variant: TypeAlias = tuple[Change, ...]
"""Changed lines of a scene, which go together."""


@dataclass(frozen=True, slots=True)
class Configuration:
    """One way to run a scene: adaptive with `rtol`, or with a fixed `step` in s.

    `keep` is the number of steps over which a Jacobian is kept; `changes` are the changed lines of
    a variant.
    """

    solver: str
    rtol: float = 0.0
    step: float = 0.0
    keep: int = 1
    changes: Variant = ()

    @property
    def fixed(self) -> bool:
        """True for a fixed step."""
        return self.step > 0

    @property
    def method(self) -> Solver:
        """The method and options of a run."""
        return Solver(self.solver, rtol=self.rtol, step=self.step, keep=self.keep)

    @property
    def setting(self) -> str:
        """The step or the tolerance, and the number of steps that a Jacobian is kept."""
        main = spelled_time(self.step) if self.fixed else f"rtol {self.rtol:.2g}"
        return main if self.keep == 1 else f"{main}, keep {self.keep}"

    @property
    def variant(self) -> str:
        """The changed lines without `use` and `set`; empty for the unchanged scene."""
        return ", ".join(f"{change.name}={change.value}" for change in self.changes)

    @property
    def label(self) -> str:
        """Method, setting and variant in one line."""
        text = f"{self.solver} {self.setting}"
        return f"{text} with {self.variant}" if self.changes else text

    def statement(self, settle: float = 0.0) -> str:
        """Write the statement for a scene; `settle`, Hz, is included if it is not 0."""
        options = [f"step = {spelled_time(self.step)}" if self.fixed else f"rtol = {self.rtol:g}"]
        if self.keep > 1:
            options.append(f"keep = {self.keep}")
        if settle > 0:
            options.append(f"settle = {settle:.12g} Hz")
        return f"solver {self.solver}({', '.join(options)});"

    @property
    def ladder(self) -> tuple[str, int, Variant]:
        """The key of configurations that differ only in their step or tolerance."""
        return self.solver, self.keep, self.changes


def scene_configurations(
    adaptive: Sequence[str],
    fixed: Sequence[str],
    rtols: Sequence[float],
    steps: Sequence[float],
    keeps: Sequence[int],
    explicit: Collection[str] = (),
) -> tuple[Configuration, ...]:
    """List all configurations of the unchanged scene in the order of measurement.

    Methods, with fresh and with kept Jacobians, take turns from coarse to fine: the whole range
    shows early, and the slowest configurations come last. Methods in `explicit` have no Jacobian to
    keep.
    """
    rtols, steps = sorted(rtols, reverse=True), sorted(steps, reverse=True)
    ladders = [[Configuration(name, rtol=rtol) for rtol in rtols] for name in adaptive]
    for place, keep in enumerate(sorted(keeps)):
        for name in fixed:
            if name not in explicit:
                ladders.append([Configuration(name, step=step, keep=keep) for step in steps])
            elif place == 0:
                ladders.append([Configuration(name, step=step) for step in steps])
    return tuple(_in_turns(ladders))


def _in_turns(ladders: Iterable[Sequence[Configuration]]) -> Iterator[Configuration]:
    for level in zip_longest(*ladders):
        yield from (configuration for configuration in level if configuration is not None)


def step_ladder(base: float, duration: float) -> tuple[float, ...]:
    """List steps around a base step, s, up to the duration of the run.

    Shorter steps divide the base, so that devices see the same samples.
    """
    return tuple(step for step in (factor * base for factor in _FACTORS) if step <= duration)


def round_step(step: float) -> float:
    """Round to the nearest 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(step))
    nearest = min((1.0, 2.0, 5.0, 10.0), key=lambda digit: abs(math.log(digit * power / step)))
    return float(f"{nearest * power:.1g}")
