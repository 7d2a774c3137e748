"""The solver of a run: its method and options."""

from __future__ import annotations

from typing import Literal, TypedDict

from bgc.language.methods import METHODS
from bgc.language.records import Where, option, options_of
from bgc.record_class import dataclass

_IN_TEXT = Where.SCENE | Where.C  # by `solver NAME(..)` and in C alone
_BY_CALLER = Where.COMMAND | Where.PYTHON


@dataclass(frozen=True, slots=True)
class Solver:
    """An integration method with its options, SI; 0 and empty texts where none are given.

    `start` is "rest", "given", or empty for the scene's own start.
    """

    name: str = option(
        "integration method (see bgc doc methods)",
        of="",
        kind=str,
        default="that of the scene, else `ros34prw` where the scene gives a step, or `rodas5p`; "
        "where explicit steps may cost less `switching_fixed` or `switching`",
        keyword="solver",
        metavar="NAME",
        where=_BY_CALLER,
    )
    rtol: float = option(
        "relative tolerance of an adaptive method, or of the parts of a fixed step",
        default="1e-6, of parts 1e-3",
        number="a part of a value",
        low=1e-15,  # rounding
        high=0.5,
        serves=lambda solver: solver.is_judged,
    )
    atol: float = option(
        "absolute tolerance, one number for all states (SI)",
        default="rtol times the scale of each state",
        unit=None,
        serves=lambda solver: solver.is_judged,
    )
    step: float = option(
        "step of a fixed-step method, first step of an adaptive one",
        default="the scene's `step`",
        unit="s",
        example='"1 ms"',
    )
    max_step: float = option(
        "longest step of an adaptive method",
        default="5 row intervals where the model depends on time",
        unit="s",
        example='"5 ms"',
        serves=lambda solver: not solver.fixed,
    )
    min_step: float = option(
        "least step of an adaptive method: one that needs a shorter step ends the run (BG701)",
        unit="s",
        example='"1 us"',
        serves=lambda solver: solver.name in METHODS and not solver.fixed,
    )
    max_steps: int = option(
        "most steps between two rows", of=0, kind=int, high=2e9, default="1e7", where=_IN_TEXT
    )
    keep: int = option(
        "number of steps over which a fixed-step method keeps its Jacobian",
        of=0,
        kind=int,
        default="1",
        where=_IN_TEXT,
        serves=lambda solver: solver.fixed and METHODS[solver.name].family.jacobian,
    )
    substeps: int = option(
        "most parts of a fixed step, which is divided where its error is above `rtol`",
        of=0,
        kind=int,
        default="8 for `ros34prw` and `switching_fixed`, else 1",
        high=1000,
        example="8",
        serves=lambda solver: solver.fixed and METHODS[solver.name].embedded_order > 0,
    )
    settle: float = option(
        "modes faster than this start at rest, under their loads",
        unit="Hz",
        where=Where.SCENE | _BY_CALLER,
        example='"20 Hz"',
    )
    start: str = option(
        "start at the nearest state at which all rates vanish (BG760 if there is none)",
        of="",
        kind=bool,
        default='the start of the scene; "given" stands for its initial values',
        flag="--rest",
        where=_BY_CALLER,
    )

    @property
    def given(self) -> dict[str, float]:
        """The options of `solver NAME(..)` that are given, by name."""
        return {name: value for name in SOLVER_OPTIONS if (value := getattr(self, name))}

    @property
    def served(self) -> tuple[str, ...]:
        """Names of the options that its method takes."""
        return tuple(name for name, known in SOLVER_OPTIONS.items() if known.serves(self))

    @property
    def fixed(self) -> bool:
        """Return whether its steps have a given length; those of other packages have not."""
        return self.name in METHODS and METHODS[self.name].fixed

    @property
    def parts(self) -> int:
        """The number of parts of a fixed step, at most; 1 where it cannot be divided."""
        is_divisible = self.fixed and METHODS[self.name].embedded_order > 0
        return (self.substeps or METHODS[self.name].parts) if is_divisible else 1

    @property
    def is_judged(self) -> bool:
        """Return whether the error of its steps is compared with a tolerance."""
        return not self.fixed or self.parts > 1


class SolverKeywords(TypedDict, total=False):
    """The fields of `Solver` as keywords of Python functions: SI numbers, or texts with a unit."""

    solver: str | None
    rtol: float | str | None
    atol: float | str | None
    step: float | str | None
    max_step: float | str | None
    min_step: float | str | None
    substeps: int | None
    settle: float | str | None
    start: Literal["rest", "given"] | None


def options_of_method(name: str) -> tuple[str, ...]:
    """Names of the options that a method takes where its steps are divided, if they can be."""
    return Solver(name, substeps=2).served


SOLVER_OPTIONS = options_of(Solver, Where.SCENE)
"""Options of `solver NAME(..)`."""
