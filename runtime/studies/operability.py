"""Operability of a scene in sea states: criteria, extremes over seeds, limits, downtime."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.ensembles import bad_range
from bgc.diagnostics.catalogue.studies import no_criterion
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import EXTREMES, Criterion
from bgc.runtime.results.study import Study
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameter_grid import Axis, read_axis
from bgc.runtime.running.quantity import read_quantity
from bgc.runtime.running.requirements import criteria_of
from bgc.runtime.studies.operability_result import Operability
from bgc.runtime.studies.sweep import Design, sweep
from bgc.values.shown_units import Shown

JUDGES = ("gumbel", "worst")

_EULER = 0.5772156649015329


@dataclass(frozen=True, slots=True)
class SeaStates:
    """Parameters of the sea and their values; heading and seed are optional.

    Each is a text `vessel.sea.height=1..4 m:7`.
    """

    height: str
    period: str
    heading: str | None = None
    seed: str | None = None

    def axes(self, model: LoadedModel) -> dict[str, Axis]:
        """Read the axes by their roles, in the order of the cells of a study."""
        found: dict[str, Axis] = {}
        for role in ("heading", "period", "height", "seed"):
            text = getattr(self, role)
            if text is not None:
                found[role] = read_axis(text, model.parameters.unit_of)
        for role in ("period", "height"):
            if role not in found or not (np.diff(found[role].values()) > 0).all():
                raise BgError([bad_range(str(getattr(self, role)))])
        return found


def read_criteria(model: LoadedModel, texts: Sequence[str]) -> tuple[Criterion, ...]:
    """Read criteria on the columns of a scene, by default its own limits; BG787 without any."""
    found = criteria_of(model, texts or None)
    if not found:
        raise BgError([no_criterion()])
    return found


def operability(
    model: LoadedModel,
    seas: SeaStates,
    criteria: Sequence[Criterion],
    method: Solver,
    times: Array,
    *,
    judge: str = "gumbel",
    exposure: float | None = None,
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
    resume: bool = False,
    scheduler: str | None = None,
    store: str | Path | None = None,
) -> Operability:
    """Run all sea states, and judge them by the criteria; see `Model.operability`."""
    if judge not in JUDGES:
        raise BgError([bad_option("judge", judge, f"one of {', '.join(JUDGES)}", "worst")])
    if exposure is not None and not exposure > 0:
        raise BgError([bad_option("exposure", exposure, "a positive time in seconds", "10800")])
    axes = seas.axes(model)
    if exposure is not None:
        _check_extrapolation(seas.seed, axes, judge)
    texts = [getattr(seas, role) for role in axes]
    observables = {each.observable.name: each.observable for each in criteria}
    study = sweep(
        model, Design(texts), method, times, tuple(observables.values()), progress=progress,
        notices=notices, resume=resume, scheduler=scheduler, store=store,
    )  # fmt: skip
    assert isinstance(study, Study)
    lengths = {role: len(axes[role].values()) if role in axes else 1 for role in
               ("heading", "period", "height", "seed")}  # fmt: skip
    shape = tuple(lengths.values())
    found, used = [], []
    for criterion in criteria:
        observable = criterion.observable
        end = min(observable.end, float(times[-1]))
        values = study[observable.name].reshape(shape)
        value = extreme(
            values,
            criterion.below,
            judge if observable.function in EXTREMES or judge == "worst" else "mean",
            math.log(exposure / (end - observable.start)) if exposure else 0.0,
        )
        found.append(value)
        used.append(criterion.utilisation(value))
    failed = np.asarray((~study.done).reshape(shape).any(axis=3))
    parameters = {role: axis.name for role, axis in axes.items()}
    return Operability(
        scene=study.scene,
        parameters=parameters,
        shown={role: _as_written(getattr(seas, role), model) for role in parameters},
        headings=axes["heading"].values() if "heading" in axes else np.array([math.nan]),
        periods=axes["period"].values(),
        heights=axes["height"].values(),
        criteria=tuple(criteria),
        values=np.stack(found, axis=-1),
        utilisation=np.where(failed[..., None], np.inf, np.stack(used, axis=-1)),
        failed=failed,
        study=study,
        judge=judge,
        exposure=exposure,
    )


def _check_extrapolation(seed: str | None, axes: Mapping[str, Axis], judge: str) -> None:
    """Raise BG066 where an exposure changes nothing: `worst`, or fewer than two seeds."""
    if judge != "gumbel":
        wanted = "a distribution of extremes, which an exposure needs"
        raise BgError([bad_option("judge", judge, wanted, "gumbel")])
    if "seed" not in axes or len(axes["seed"].values()) < 2:
        wanted = "two seeds or more, which an exposure needs"
        example = "vessel.sea.seed=1..10:10"
        raise BgError([bad_option("seed", seed or "not given", wanted, example)])


def _as_written(text: str, model: LoadedModel) -> Shown:
    """The unit in which the values of a parameter were given; else that of the parameter."""
    name, _, values = (part.strip() for part in text.partition("="))
    span = values.removesuffix(" log").partition(":")[0].strip()
    _, blank, unit = span.rpartition(" ")
    parameter = model.parameters[name]
    if not blank or not unit[0].isalpha():
        return parameter.shown
    return Shown(unit, read_quantity(f"1 {unit}", name, parameter.unit))


def extreme(values: Array, upper: bool, judge: str, log_ratio: float = 0.0) -> Array:
    """The value of a cell from those of its seeds along the last axis.

    `gumbel`: the most probable extreme of Gumbel's distribution with the mean and the standard
    deviation of the seeds, mean - 0.45 sd, moved by sd sqrt(6)/pi `log_ratio` for an exposure of
    exp(log_ratio) times the simulated time (DNV-RP-C205, section 3.6, of independent parts). One
    seed gives its own value. `worst`: the largest (or least). `mean`: the mean.
    """
    sign = 1.0 if upper else -1.0
    if judge == "worst":
        return np.asarray(sign * (sign * values).max(axis=-1))
    mean = values.mean(axis=-1)
    if judge == "mean" or values.shape[-1] < 2:
        return np.asarray(mean)
    scale = values.std(axis=-1, ddof=1) * math.sqrt(6) / math.pi
    return np.asarray(mean + sign * scale * (log_ratio - _EULER))
