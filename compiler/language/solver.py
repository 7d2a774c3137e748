"""The solver of a run: its method and options."""

from __future__ import annotations

from dataclasses import dataclass

from bgc.language.records import Where, option, options_of

_IN_TEXT = Where.SCENE | Where.C  # by `solver NAME(..)` and in C alone


@dataclass(frozen=True, slots=True)
class Solver:
    """An integration method with its options, SI; 0 and empty texts where none are given.

    `start` is "rest", "given", or empty for the scene's own start.
    """

    name: str = option(
        "integration method (see bgc doc methods)",
        of="",
        kind=str,
        keyword="solver",
        where=Where.COMMAND | Where.PYTHON,
    )
    rtol: float = option(
        "relative tolerance of an adaptive method, or of the parts of a fixed step",
        default="1e-6; of parts 1e-3",
        number="a part of a value",
        low=1e-15,  # rounding
        high=0.5,
    )
    atol: float = option(
        "absolute tolerance, one number for all states (SI)",
        default="rtol times the scale of each state",
        unit=None,
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
    )
    max_steps: int = option(
        "most steps between two rows", of=0, kind=int, default="1e7", where=_IN_TEXT
    )
    keep: int = option(
        "number of steps over which a fixed-step method keeps its Jacobian",
        of=0,
        kind=int,
        default="1",
        where=_IN_TEXT,
    )
    substeps: int = option(
        "most parts of a fixed step, which is divided where its error is above `rtol`",
        of=0,
        kind=int,
        default="8 for `ros34prw` and `switching_fixed`, else 1",
        high=1000,
        example="8",
    )
    settle: float = option(
        "modes faster than this start at rest, under their loads",
        unit="Hz",
        where=Where.SCENE | Where.COMMAND | Where.PYTHON,
        example='"20 Hz"',
    )
    start: str = option(
        "start at the nearest state at which all rates vanish",
        of="",
        kind=bool,
        flag="--rest",
        where=Where.COMMAND | Where.PYTHON,
    )

    @property
    def given(self) -> dict[str, float]:
        """The options of `solver NAME(..)` that are given, by name."""
        return {name: value for name in SOLVER_OPTIONS if (value := getattr(self, name))}


SOLVER_OPTIONS = options_of(Solver, Where.SCENE)
"""Options of `solver NAME(..)`."""
