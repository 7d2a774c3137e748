"""Options that several commands share, and what the scene that they choose is compiled to."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Literal

from bgc.diagnostics.catalogue.arguments import bad_assignment, bad_option
from bgc.diagnostics.catalogue.devices import bad_device_option
from bgc.language.records import Where, options_of
from bgc.language.scene import Scene
from bgc.language.solver import Solver
from bgc.options import Options
from bgc.record_class import dataclass
from bgc.runtime.cli.command import (
    Declared,
    OptionGroup,
    Pair,
    Target,
    Value,
    argument,
    option,
    require,
    signature,
)
from bgc.runtime.cli.completion import scenes_of
from bgc.runtime.cli.printing import print_diagnostics

if TYPE_CHECKING:
    from bgc.driver import Stage, Stages
    from bgc.runtime.model import Model

SECONDS = Value("s")
PICTURE = Target(".png", ".svg", ".pdf")
TABLE = Target(".csv")
_KINDS: Mapping[Any, Any] = {bool: bool, tuple: tuple[str, ...]}  # others may be left out


def option_of(record: type, field: str, text: str = "") -> Any:
    """Declare the option that gives a field of a record, by default with the help of its own."""
    known = options_of(record, Where.COMMAND)[field]
    kind = Value(known.unit) if known.unit else None
    facts: dict[str, Any] = {"type": kind, "metavar": known.metavar, "choices": known.choices}
    return option(text or known.help, known.flag, **{k: v for k, v in facts.items() if v})


def assigned(example: str) -> Pair:
    """Make the type of `NAME=VALUE`, with an example for those who write another text (BG064)."""
    return Pair(lambda text: bad_assignment(text, example))


ASSIGNED = assigned('--set "boom.mass=7 t"')

File = Annotated[Path, argument()]
Files = Annotated[tuple[Path, ...], argument(required=True)]
SceneName = Annotated[
    str | None,
    option(
        "Scene to take; by default the first of the file.", metavar="NAME", shell_complete=scenes_of
    ),
]
Assignments = Annotated[
    tuple[tuple[str, str], ...],
    option(
        'Set a parameter: --set "crane.boom.mass=7 t". May be repeated.',
        "--set",
        type=ASSIGNED,
    ),
]
Uses = Annotated[
    tuple[tuple[str, str], ...],
    option(
        'Fill a slot: --use "crane.elbow.lock=Rigid[5]". May be repeated.',
        "--use",
        type=assigned('--use "elbow.lock=Rigid[5]"'),
        metavar="SLOT=TYPE",
    ),
]
Whole = Annotated[bool, option("Compile the whole model, not only what the scene observes.")]
Strict = Annotated[bool, option("Treat warnings as errors (exit status 1).")]
Preview = Annotated[
    bool, option("Compile quickly without optimisation (tcc if installed, otherwise -O0).")
]
Verify = Annotated[
    bool, option("Check all intermediate results of the compiler (for work on bgc).")
]
Errors = Annotated[
    bool | None,
    option(
        "Estimate by how much the columns are off, as is usual; --error also says how.",
        "--error/--no-error",
        default=None,
    ),
]
Devices = Annotated[
    tuple[tuple[str, str], ...],
    option(
        "Driver in place of the scene's: hand=./mine.so, hand=motion.csv. May be repeated.",
        "--device",
        type=Pair(bad_device_option),
        metavar="NAME=DRIVER",
    ),
]
_INPUT = "Input: a source (supply.e), a parameter, an input, or a channel (hand.position[3])."
_OUTPUT = "Output: an observed name, or any expression."
Input = Annotated[str, option(_INPUT, metavar="NAME")]
Inputs = Annotated[tuple[str, ...], option(_INPUT, "--input", metavar="NAME")]
Output = Annotated[str, option(_OUTPUT, metavar="NAME")]
Outputs = Annotated[tuple[str, ...], option(_OUTPUT, "--output", metavar="NAME")]
Duration = Annotated[float | None, option_of(Scene, "duration")]
Budget = Annotated[
    float,
    option("Longest time for the measurements.", type=SECONDS, default="120 s", show_default=True),
]
Within = Annotated[
    tuple[tuple[str, str], ...],
    option(
        'Largest error of an observed value: "tip_height: 1 mm". May be repeated.',
        type=Pair(
            lambda text: bad_option("--within", text, "NAME: VALUE", "tip_height: 1 mm"), ":"
        ),
        metavar="NAME: VALUE",
    ),
]
Deadline = Annotated[float | None, option("Longest time of a step or a sample.", type=SECONDS)]
Json = Annotated[bool, option("Print JSON, in SI units with all digits.", "--json")]
Scheduler = Annotated[str | None, option("Dask scheduler: tcp://10.0.0.5:8786.", metavar="ADDRESS")]


@dataclass(frozen=True)
class SceneOptions(OptionGroup):
    """FILE, and the options that choose and change its scene."""

    file: File
    scene: SceneName
    assignments: Assignments
    uses: Uses

    def options(self, **more: Any) -> Options:
        """Options of a compilation into which the assigned values enter."""
        return Options(self.scene, self.assignments, uses=self.uses, **more)

    def stages(self, until: "Stage", **more: Any) -> "Stages":
        """Compile up to a stage, with further fields of `Options`; print the warnings."""
        # The compiler is slow to load, and models from the cache do without it.
        from bgc.driver import compile_scene

        stages = compile_scene(self.file, self.options(**more), until=until)
        print_diagnostics(stages.warnings)
        return stages

    def model(self, quiet: bool = False, **more: Any) -> "Model":
        """Load the model from the cache or compile it, and print its warnings.

        Unless `quiet`, a terminal shows the stage of a compilation. `more` are fields of `Options`.
        """
        # Loads NumPy, which commands that run nothing do without.
        from bgc.runtime.model import Model
        from bgc.runtime.running.model_loading import load_as
        from bgc.runtime.running.progress import CompilingLine

        options = Options(self.scene, uses=self.uses, **more)
        with CompilingLine(self.file.name, wanted=not quiet) as line:
            model = load_as(Model, self.file, options, dict(self.assignments), line)
        print_diagnostics(model.warnings)
        return model


@dataclass(frozen=True)
class PointOptions(OptionGroup):
    """Where to linearise: by default at the initial state."""

    at: Annotated[
        float | None,
        option("Linearise at the state after a simulation to this time.", type=SECONDS),
    ]
    steady: Annotated[bool, option("Linearise in the equilibrium found from the initial state.")]

    def __post_init__(self) -> None:
        require(self.at is None or not self.steady, "--at and --steady exclude each other")
        at = self.at or 0.0
        require(at >= 0, bad_option("--at", at, "a time in seconds from the start on"))

    @property
    def is_given(self) -> bool:
        """Whether one of the two options was given."""
        return self.steady or self.at is not None

    @property
    def point(self) -> float | Literal["steady"] | None:
        """A time, s, `steady`, or None for the initial state."""
        return "steady" if self.steady else self.at or None


def rows_of(
    record: type, texts: Mapping[str, str] = MappingProxyType({})
) -> dict[str, tuple[Any, Declared]]:
    """Rows of `signature` for the options of a record; `texts` replace help texts by field."""
    return {
        known.keyword: (
            _KINDS.get(known.kind, known.kind | None),
            option_of(record, name, texts.get(name, "")),
        )
        for name, known in options_of(record, Where.COMMAND).items()
    }


class SolverOptions(OptionGroup):
    """The integration method of a loop in real time and its options.

    `arguments` are those of `Model.simulate`, in SI units.
    """

    __signature__ = signature(rows_of(Solver, {"step": 'Step and period of the loop: "1 ms".'}))

    def __init__(self, *, start: bool, **given: Any) -> None:
        self.arguments: dict[str, Any] = {**given, "start": "rest" if start else None}


class MethodOptions(SolverOptions):
    """The integration method, its options, and the times of the rows."""

    __signature__ = signature({**rows_of(Solver), **rows_of(Scene)})
