"""Studies whose results go to a store while they are computed, on this machine or on others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from bgc.building.recall import processors
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.runtime.results.ensemble import Ensemble
from bgc.runtime.results.study import Study
from bgc.runtime.running.batches import Work
from bgc.runtime.running.many import Plan, ensemble_of, lane_library, study_of
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.studies.chunks import Waiting, locally
from bgc.runtime.studies.store import Store


def run_stored(
    plan: Plan,
    scheduler: str | None,
    store: str | Path | None,
    design: str,
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
) -> Ensemble | Study:
    """Run what a store lacks, on the workers of a Dask scheduler or on this machine's processors.

    A chunk takes about a second and is written when it is done. After Ctrl-C or the end of this
    process, the same call goes on with what is missing.
    """
    work = plan.work(None)
    held = Store(store, plan, design) if store is not None else None
    if held is not None:
        held.load(work)
    ended = work.completed | work.failures.keys()
    recalled = len(ended)
    waiting = Waiting(len(plan.cases), [k in ended for k in range(len(plan.cases))])
    interrupted = False
    try:
        if scheduler is not None:
            # Only this needs Dask.
            from bgc.runtime.studies.cluster import on_cluster

            chunks = on_cluster(plan, scheduler, waiting)
        else:
            library = None if plan.alone or not waiting else lane_library(plan.model)
            chunks = locally(plan, library, waiting, processors())
        with ProgressBar(float(len(plan.cases)), progress, unit=" instances") as bar:
            for chunk in chunks:
                chunk.add_to(work)
                if held is not None:
                    held.write(chunk)
                bar.show(float(len(work.completed) + len(work.failures)))
    except KeyboardInterrupt:
        interrupted = True
    return _named(plan, work, notices, design, recalled, interrupted, held is not None)


def _named(
    plan: Plan,
    work: Work,
    notices: Sequence[Diagnostic],
    design: str,
    recalled: int,
    interrupted: bool,
    kept: bool,
) -> Ensemble | Study:
    if plan.observables:
        study = replace(study_of(plan, work, notices, design), recalled=recalled)
        if interrupted:
            raise study.interrupted(kept)
        return study
    ensemble = ensemble_of(work, plan.alone, notices, recalled)
    if interrupted:
        raise ensemble.interrupted(kept)
    return ensemble
