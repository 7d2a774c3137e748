"""The result of a reduction as plain data, and its sentence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.diagnostics.catalogue import counted
from bgc.record_class import dataclass
from bgc.runtime.measuring.judging import Quantity
from bgc.runtime.reduce.reduced_scene import ReducedScene, statements
from bgc.runtime.reduce.search import Stage
from bgc.runtime.reduce.trial import Trial
from bgc.runtime.reduce.validity import Validity
from bgc.runtime.trade.judge import Target, spelled
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.reference_solution import Reference

_MOST_LIMITS = 4  # that a sentence names


@dataclass(frozen=True, slots=True)
class Timed:
    """A method of a scene, the processor time of its run, s, and its error over the requirement.

    Times of one result were measured in turns.
    """

    label: str
    seconds: float
    error: float


@dataclass(frozen=True, slots=True)
class Proof:
    """The run of the cheapest scene that was found, with its method, against the whole scene.

    Attributes
    ----------
    method
        The statement of the method.
    error, worst, off
        The largest error of all cases over the requirement, with the doubt about the reference; the
        quantity that has it, and by how much it is off, in its unit.
    reduced, own, whole
        Times of the reduced scene; of the whole scene with its own method; and of the whole scene
        with the cheapest method that was found within the requirement, None where none was.
    is_whole
        True where the whole scene with this method is as fast as the reduced one: it is then the
        scene that was found, and `method` and `error` are its.
    """

    method: str
    error: float
    worst: Quantity
    off: float
    reduced: Timed
    own: Timed | None
    whole: Timed | None
    is_whole: bool = False


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ReductionResult:
    """The reduction of a scene: the changes that it allows, their proof, and all that was tried.

    Attributes
    ----------
    scene, model, machine
        The scene, its model, and the machine.
    duration
        Seconds of the scene.
    cases
        The values of parameters over which the scene was judged, SI.
    target, reference
        The demands on the scene, and the reference solution of the first case.
    whole
        The trial of the unchanged scene.
    tried
        All trials, in their order.
    stages
        The accepted changes, each with the trials before and after it.
    forms
        The number of coarser forms of parts.
    measurements
        Methods of the reduced scene, in the first case.
    valid
        The values of parameters for which the reduced scene holds, and for which it does not.
    proof, reduced
        The proof, and the scene to be written; None where nothing can be left out.
    ended
        True if the budget was spent before all forms had their turn.
    warnings
        Limits of the result.
    """

    scene: str
    model: str
    machine: str
    duration: float
    cases: tuple[Mapping[str, float], ...]
    target: Target
    reference: Reference
    whole: Trial
    tried: tuple[Trial, ...]
    stages: tuple[Stage, ...]
    forms: int
    measurements: tuple[Measurement, ...]
    valid: tuple[Validity, ...]
    proof: Proof | None
    reduced: ReducedScene | None
    ended: bool
    warnings: tuple[str, ...] = ()

    @property
    def best(self) -> Trial:
        """The trial of the scene that was found: the whole one where it is as fast."""
        return self.whole if self.proof is not None and self.proof.is_whole else self.coarsest

    @property
    def coarsest(self) -> Trial:
        """The trial of all accepted changes."""
        return self.stages[-1].after if self.stages else self.whole

    @property
    def text(self) -> str:
        """The reduced scene, to be put into the file of the original; empty without one."""
        return "" if self.reduced is None else self.reduced.text()

    @property
    def sentence(self) -> str:
        """The result in words."""
        if self.proof is not None:
            return f"{summary(self, self.proof)} {compared(self.proof)}"
        if self.stages:
            return (
                f"{self.best.states} of {counted(self.whole.states, 'state')} may be enough, but "
                "no method was found within the requirement in all cases; a larger `--budget` may "
                "find one."
            )
        if self.ended:
            return "The budget was spent before anything was left out: the same command continues."
        if not self.forms:
            return "Nothing can be left out: no part of the scene has a coarser form."
        return (
            f"Nothing can be left out: none of {counted(self.forms, 'coarser form')} stays within "
            "the requirement and saves operations."
        )

    def __repr__(self) -> str:
        return f"<bgc reduction of {self.scene}: {len(self.tried)} tried; {self.sentence}>"


def summary(found: ReductionResult, proof: Proof) -> str:
    """Say what is left of the scene, and how far off it is."""
    quantity = proof.worst
    off, required = (quantity.shown.text(value, 2) for value in (proof.off, quantity.scale))
    states = counted(found.whole.states, "state")
    what = (
        f"Nothing is gained by dropping: the whole scene is as fast as {found.coarsest.states} of "
        f"its {states}"
        if proof.is_whole
        else f"{found.best.states} of {states} are enough"
    )
    return (
        f"{what}: with `{proof.method}`, {quantity.name} is at most {off} off, of the {required} "
        "required."
    )


def compared(proof: Proof) -> str:
    """Say how the time of the scene that was found compares with those of the others."""
    rows = {
        "the whole scene with its own method": proof.own,
        "the whole scene with the cheapest method found": proof.whole,
        "the reduced scene": proof.reduced,
    }
    best = proof.whole if proof.is_whole and proof.whole is not None else proof.reduced
    parts = [
        f"{_times(row.seconds / best.seconds)} as fast as {what} ({row.label})"
        for what, row in rows.items()
        if row is not None and row is not best
    ]
    return f"The run takes {spelled(best.seconds)}: {', '.join(parts)}." if parts else ""


def limits(valid: Sequence[Validity]) -> str:
    """Name the first values that are too far for the reduced scene; empty where there are none."""
    beyond = [
        f"{each.name} = {each.shown.text(side.fails)}"
        for each in valid
        for side in (each.below, each.above)
        if side.fails is not None
    ]
    if not beyond:
        return ""
    more = f", and {len(beyond) - _MOST_LIMITS} more" if len(beyond) > _MOST_LIMITS else ""
    return f" It does not hold for {', '.join(beyond[:_MOST_LIMITS])}{more}."


def _times(ratio: float) -> str:
    return f"{ratio:.3g} times"


def gained(stage: Stage) -> tuple[str, str, str, str, str]:
    """A row for an accepted change: its lines, states, share of the work, and errors."""
    before, after = stage.before, stage.after
    return (
        statements(stage.changes),
        f"{before.states} -> {after.states}",
        f"{after.work / before.work:.2f}" if before.work > 0 else "",
        f"{after.error - before.error:+.1e}",
        f"{after.error:.1e}",
    )
