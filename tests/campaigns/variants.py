"""Every change of one line in every scene of the library, and whether it still starts at rest.

A change fills one slot with another model of the library (`use vessel = Quay;`), or multiplies one
parameter by 0.7 or 1.3 (`set crane.boom.length = 13 m;`). The changed scene has to start at rest,
run for 0.1 s with finite results and a closed account, or be refused with a code.

All that a case is judged by is computed anew from the start: the rates there, in the scales of the
states, and how far the recorded values move within 20 ms where nothing depends on the time.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from judging import Verdict

import bgc
import bgc.library
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.elaboration.scenes.variants import variants_of
from bgc.grammar.parse import parse, read_source
from bgc.grammar.syntax import Model, Scene, Start
from bgc.options import Options
from bgc.runtime.running.structures import Status

LIBRARY = Path(bgc.library.__path__[0])
PORTION = 10
SIZE = 1000  # numbers of the cases of a scene, which has fewer
CPU_SECONDS = 180.0  # for one case, most of it the C compiler
WALL_SECONDS = 1_800.0
MEMORY = 4_000_000_000  # bytes
FACTORS = (0.7, 1.3)
RATE = 1e-5  # of a state's scale in a second; stiff locks round 1e11 N m/rad to 1e-6
SHORT, LONG = 0.02, 0.1  # s
MOVED = 1e-6  # of a value, or of its unit where it is small
RESIDUAL = 1e-4  # of the energy that was exchanged
_INDEX = re.compile(r"\[\d[\d, ]*\]")


@dataclass(frozen=True)
class Case:
    """A scene and one statement more."""

    file: Path
    scene: str
    kind: str  # use or set
    name: str
    value: str

    @property
    def text(self) -> str:
        return f"{self.file.stem}/{self.scene}: {self.kind} {self.name} = {self.value};"


def groups() -> list[str]:
    """The scenes, each of which has the numbers of `SIZE` cases."""
    return [f"{file.stem}/{scene}" for file, scene in _scenes(LIBRARY)]


def text_of(seed: int, number: int) -> tuple[str, bytes]:
    """The scene and the change of a number."""
    del seed
    with tempfile.TemporaryDirectory(prefix="bgc-variants-") as folder:
        case = _case(Path(folder), number)
    return groups()[number // SIZE], f"{case.text if case else 'none'}\n".encode()


def _case(folder: Path, number: int) -> Case | None:
    if not (folder / "scenes").exists():
        opened(folder)
    found = cases(folder, number // SIZE)
    return found[number % SIZE] if number % SIZE < len(found) else None


@cache
def cases(folder: Path, number: int) -> list[Case]:
    """The cases of a scene of the folder, by its number."""
    file, scene = list(_scenes(folder))[number]
    return [*_uses(file, scene), *_sets(file, scene)]


def opened(folder: Path) -> None:
    """Copy the scenes to a folder, each with all modules of the library imported."""
    (folder / "scenes").mkdir()
    (folder / "traces").symlink_to(LIBRARY / "traces")
    modules = [
        f for f in sorted(LIBRARY.rglob("*.bg")) if f.parent.name not in ("scenes", "examples")
    ]
    names = [f"{f.parent.name}.{f.stem}" for f in modules if _has_models(f)]
    for file in (LIBRARY / "scenes").glob("*.bg"):
        text = file.read_text("utf-8")
        more = [name for name in names if f"import {name};" not in text]
        imports = "".join(f"import {name};\n" for name in more)
        changed = text.replace("\nimport ", f"\n{imports}import ", 1)
        (folder / "scenes" / file.name).write_text(changed, "utf-8")


def _has_models(file: Path) -> bool:
    parsed, _ = parse(read_source(file))
    return any(isinstance(d, Model) for d in parsed.declarations)


def _scenes(folder: Path) -> Iterator[tuple[Path, str]]:
    """The scenes of files that start at rest: all but the wall, where a push sets in at once."""
    for file in sorted((folder / "scenes").glob("*.bg")):
        parsed, _ = parse(read_source(file))
        scenes = [d for d in parsed.declarations if isinstance(d, Scene)]
        if any(isinstance(item, Start) for scene in scenes for item in scene.items):
            yield from ((file, scene.name) for scene in scenes)


def _uses(file: Path, scene: str) -> list[Case]:
    """The scene with each slot filled otherwise; a sea of three components stands for all."""
    stages = compile_scene(file, Options(scene), until="elaborate")
    changes = variants_of(stages.package, stages.graph)
    models = stages.package.root.models
    found = []
    for change in changes:
        model = models.get(change.value)  # not there where dimensions follow the name
        few = "[3]" if model is not None and model.syntax.formals else ""
        found.append(Case(file, scene, "use", change.name, change.value + few))
    return found


def _sets(file: Path, scene: str) -> list[Case]:
    """The scene with each parameter changed: of a vector the first and the last component."""
    components: dict[str, list] = {}
    for parameter in _model(file, scene).parameters.values():
        if parameter.default:
            components.setdefault(parameter.name.split("[")[0], []).append(parameter)
    found = []
    for several in components.values():
        for parameter in dict.fromkeys((several[0], several[-1])):
            for factor in FACTORS:
                value = factor * parameter.default
                if parameter.low <= value <= parameter.high:
                    found.append(Case(file, scene, "set", parameter.name, repr(value)))
    return found


@cache
def _model(file: Path, scene: str) -> bgc.Model:
    return bgc.compile(file, scene=scene)


# --- the judgement of one case ------------------------------------------------------------


def judge(seed: int, number: int, folder: Path) -> list[Verdict]:
    """The outcome of one case: at rest, refused or ended with a code, or a fault."""
    del seed
    case = _case(folder, number)
    if case is None:
        return []
    try:
        return [_judged(case)]
    except BgError as error:
        codes = tuple(d.code for d in error.diagnostics)
        known = codes and all(code.startswith("BG") for code in codes)
        return [Verdict("refused" if known else "traceback", codes, f"{case.text}\n{error}")]
    except Exception as error:  # whatever it is, it is a fault
        return [Verdict("traceback", (), f"{case.text}\n{type(error).__name__}: {error}")]


def _judged(case: Case) -> Verdict:
    values = {case.name: float(case.value)} if case.kind == "set" else {}
    uses = {case.name: case.value} if case.kind == "use" else None
    model = (
        bgc.compile(case.file, scene=case.scene, uses=uses)
        if uses
        else _model(case.file, case.scene)
    )
    begin = model.instance_at(None, 0.0, values)
    rates = _rates(begin)
    worst = int(np.abs(rates).argmax()) if rates.size else 0
    if rates.size and not abs(rates[worst]) < RATE:
        return _fault(
            case, "not at rest", f"{model.states[worst].name} changes by {rates[worst]:.2e}"
        )
    constant = _is_constant(model, begin, values)
    run = model.simulate(
        SHORT if constant else LONG, rtol=1e-7, solver="rodas5p", parameters=values, error=False
    )
    for column, size in _sizes(run).items():
        if not np.isfinite(size):
            return _fault(case, "not finite", column)
        moved = np.ptp(run[column])
        if constant and moved > MOVED * max(1.0, size) and not column.startswith("energy."):
            return _fault(case, "moves", f"{column} by {moved:.2e}")
    residual = np.abs(run["energy.residual"]).max() if "energy.residual" in run else 0.0
    exchanged = run.counts.get("exchanged", 0.0)
    if residual > RESIDUAL * exchanged + 1e-9:
        return _fault(case, "open account", f"{residual:.2e} of {exchanged:.2e}")
    done = model.simulate(LONG, parameters=values, error=False)  # with the solver of the scene
    if not all(np.isfinite(done[column]).all() for column in done):
        return _fault(case, "not finite", "with the solver of the scene")
    return Verdict("at rest" if constant else "at rest, then moved by the time")


def _sizes(run: bgc.Result) -> dict[str, float]:
    """The columns of a run, each with the size of the vector that it is part of."""
    vectors: dict[str, list[str]] = {}
    for column in run:
        vectors.setdefault(_INDEX.sub("", column), []).append(column)
    return {
        column: max(float(np.abs(run[one]).max()) for one in several)
        for several in vectors.values()
        for column in several
    }


def _rates(instance) -> np.ndarray:
    status, rates = instance.rhs()
    return rates / instance.scale if status is Status.OK else np.array([np.nan])


def _is_constant(model: bgc.Model, begin, values: dict[str, float]) -> bool:
    """Return whether the rates vanish at a later time too: nothing in the scene depends on time."""
    later = model.instance_at(begin.state.copy(), SHORT, values)
    return bool(np.abs(_rates(later)).max(initial=0.0) < RATE)


def _fault(case: Case, outcome: str, detail: str) -> Verdict:
    return Verdict(
        "silent" if outcome != "not finite" else outcome, (), f"{case.text}\n{outcome}: {detail}"
    )
