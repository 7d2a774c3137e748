"""The statements of scenes: one row a statement, which all that reads scenes takes from here.

The parser, the messages, `bgc doc`, completion, scenes that extend others and the elaboration read
the rows; the manual's table is written from them. A statement that states values of the run, as
`step 1 ms;` does, needs its rule in `bgc.lark`, a row, and a field of the record
`bgc.language.scene.Scene`; another one has a class in the syntax tree and a reader besides.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from types import MappingProxyType

from bgc.grammar import syntax
from bgc.grammar.word import Reserved, Word
from bgc.record_class import dataclass, field, fields


@dataclass(frozen=True, slots=True)
class SceneStatement(Word):
    """A statement of scenes, by its first word.

    Attributes
    ----------
    node
        Its class in the syntax tree.
    key
        The field of the node that tells apart the statements of a scene: one with the same text
        replaces the other in a scene that extends another. Empty where a scene has one such
        statement, None where it has any number.
    each
        What the key names, as "how often" says in the manual: `once a slot`.
    paths
        Fields of the node with paths of parts. Where a `use` has removed the part, an inherited
        statement is dropped; of a list of paths, only the path.
    names_columns
        Whether its expressions may name observed columns.
    gives
        For a `Fact`: the fields of the record of a run that it states, with their places in the
        grammar's rule.
    chooses
        Those of these fields for which it chooses a word.
    clauses
        Further words that stand in it.
    """

    begins: tuple[str, ...] = ("scene",)
    node: type = syntax.Fact
    key: str | None = None
    each: str = ""
    paths: tuple[str, ...] = ()
    names_columns: bool = False
    gives: Mapping[str, int] = field(default_factory=dict)
    chooses: tuple[str, ...] = ()
    clauses: tuple[Word, ...] = ()

    @property
    def often(self) -> str:
        """How often it may stand in a scene."""
        if self.key is None:
            return "any number"
        return f"once {self.each}" if self.each else "once"


_ROWS = (
    SceneStatement(
        "use",
        "Fills a slot with another type.",
        form="a slot is filled by `use part.slot = Type(arguments);`",
        doc=(
            "A slot is a part whose type is an interface, or which declares a default: "
            "`lock : Lock[5] = Compliant[5];`. The type must fit the interface. `Type(..)` takes "
            "over the arguments of the type that it replaces. On the command line: `--use`.",
        ),
        example="use crane.elbow.lock = Rigid[5];\nuse crane = TelescopicCrane;",
        related=("interface", "set"),
        node=syntax.Use,
        key="slot",
        each="a slot",
        paths=("slot", "type"),
    ),
    SceneStatement(
        "set",
        "Gives a parameter or constant another value.",
        form="a parameter is set by `set part.name = value;`",
        doc=(
            "One component too: `set M[1, 2] = 0;`, and a dimension: `set boom.n = 4;`. On the "
            "command line: `--set`.",
        ),
        example="set crane.boom.mass = 7 t;",
        related=("param", "use"),
        node=syntax.Set,
        key="target",
        each="a path",
        paths=("target", "value"),
    ),
    SceneStatement(
        "device",
        "Opens a haptic device, or a driver that plays a recorded motion.",
        form='a device is `device name = driver(file = "a.csv");`',
        doc=(
            "Its channels are read by name (`hand.position`) and sampled at every `step`. The "
            "driver `trace` plays a CSV file.",
        ),
        example='device hand = trace(file = "up_down_up.csv");\ndrive handle.x = hand.position;',
        related=("drive", "devices"),
        reserved=Reserved.IN_SCENES,
        node=syntax.Device,
        key="name",
        each="a name",
    ),
    SceneStatement(
        "drive",
        "Gives an input of the model, or a command to a device, its value.",
        form="an input is driven by `drive part.input = value;`",
        doc=("The value may depend on time, on devices and on the model.",),
        example="drive handle.x = hand.position;\ndrive hand.force = handle.force;",
        related=("input", "device"),
        reserved=Reserved.IN_SCENES,
        node=syntax.Drive,
        key="target",
        each="an input",
        paths=("target", "value"),
    ),
    SceneStatement(
        "observe",
        "Makes a value a column of the result.",
        form="outputs are `observe value as name in unit, other;`",
        doc=(
            "Only what the scene observes, drives or requires is compiled. A vector becomes a "
            "column for each component. An expression needs a name, by `as`. A column in a unit "
            "other than that of SI, by `in`, has the unit in its name. Energy accounts are "
            "`energy.stored`, `energy.supplied`, `energy.dissipated` and `energy.residual`.",
        ),
        example="observe capacitor.e as voltage, loop.f in mA, energy.residual;",
        related=("as", "energy", "plot", "keep"),
        reserved=Reserved.IN_SCENES,
        node=syntax.Observe,
        paths=("value",),
        clauses=(
            Word(
                "as",
                "Gives an observed value a name.",
                example="observe tip.r.z as height;",
                related=("observe",),
                reserved=Reserved.NOWHERE,
            ),
        ),
    ),
    SceneStatement(
        "plot",
        "A panel of the plot that `bgc run --plot` draws.",
        form="a panel of the plot is `plot name, other;` or `plot name against other;`",
        doc=("It names observed columns. Without any `plot`, there is a panel for each unit.",),
        example="plot tip_height, handle_z;\nplot force against elevation;",
        related=("observe", "against"),
        reserved=Reserved.NOWHERE,
        node=syntax.Plot,
        names_columns=True,
        clauses=(
            Word(
                "against",
                "Names the horizontal axis of a panel; time without it.",
                example="plot force against elevation;",
                related=("plot",),
                reserved=Reserved.NOWHERE,
            ),
        ),
    ),
    SceneStatement(
        "require",
        "The accuracy wanted of a value, or a limit of one.",
        form="a requirement is `require value within tolerance;` or `require column < limit;`",
        doc=(
            "The tolerance is absolute, in the unit of the value.",
            "A limit is a criterion of `bgc operability`. `bgc run` judges both.",
        ),
        example="require tip_height within 1 mm;\nrequire abs(roll) < 3 deg;",
        related=("deadline", "within"),
        reserved=Reserved.IN_SCENES,
        node=syntax.Require,
        paths=("value",),
        names_columns=True,
        clauses=(
            Word(
                "within",
                "Stands before the tolerance of `require`.",
                example="require height within 1 mm;",
                related=("require",),
                reserved=Reserved.NOWHERE,
            ),
        ),
    ),
    SceneStatement(
        "keep",
        "Keeps states, parts or parameters that would be folded or left out.",
        form="a `keep` statement is `keep x, y;`",
        example="keep crane.pedestal;",
        related=("observe",),
        reserved=Reserved.NOWHERE,
        node=syntax.Keep,
        paths=("target",),
    ),
    SceneStatement(
        "deadline",
        "The processor time that one step, or all steps between two samples, may take.",
        form="a deadline is `deadline 1 ms;` or `deadline 1 ms, hold;`",
        doc=(
            "`bgc trade` and `solver auto` choose a configuration that meets it. In real time a "
            "policy says what happens where a period is missed: `hold` leaves it out, `skip` "
            "catches up without the device, `slow` lets simulated time run slower.",
        ),
        example="deadline 1 ms;\ndeadline 1 ms, skip;",
        related=("require", "step", "BG776"),
        reserved=Reserved.IN_SCENES,
        key="",
        gives={"deadline": 1, "overrun": 2},
        chooses=("overrun",),
    ),
    SceneStatement(
        "solver",
        "The integration method and its options.",
        form="a solver is `solver name(rtol = 1e-8);`",
        doc=(
            "Without it: `ros34prw` where the scene has a `step`, else `rodas5p`; where explicit "
            "steps may cost less `switching_fixed` or `switching`. `solver auto;` "
            "takes what `bgc trade` recommended for the scene.",
        ),
        example="solver rodas5p(rtol = 1e-8);\nsolver ros34prw(step = 1 ms, settle = 20 Hz);",
        related=("methods", "step", "require"),
        reserved=Reserved.IN_SCENES,
        node=syntax.Solver,
        key="",
    ),
    SceneStatement(
        "step",
        "The fixed step, and the period at which devices are sampled.",
        form="a step is `step 1 ms;`",
        example="step 1 ms;",
        related=("solver", "device", "deadline"),
        reserved=Reserved.IN_SCENES,
        key="",
        gives={"step": 1},
    ),
    SceneStatement(
        "run",
        "The simulated time, and the interval between rows.",
        form="a run is `run 60 s every 10 ms;`",
        doc=("Without `every`: a row for each fixed step, otherwise 1,000 equal intervals.",),
        example="run 60 s every 10 ms;",
        related=("every", "step"),
        reserved=Reserved.IN_SCENES,
        key="",
        gives={"duration": 1, "every": 3},
        clauses=(
            Word(
                "every",
                "Stands before the interval between rows.",
                example="run 60 s every 10 ms;",
                related=("run",),
                reserved=Reserved.NOWHERE,
            ),
        ),
    ),
    SceneStatement(
        "start",
        "Starts a run at rest: at the nearest state at which all rates vanish.",
        form="a start at rest is `start rest;` or `start rest hold value, .. vary parameter, ..;`",
        doc=(
            "The state nearest to the initial values, in the scales of the states; what nothing "
            "restores stays where it was put. Inputs, devices and sources have their first values. "
            "The run's summary has the residual and the largest moves; where there is no such "
            "state, the rates that remain are named (BG760). On the command line: `--rest`.",
        ),
        example="start rest;\nstart rest hold crane.elbow.angle;",
        related=("rest", "hold", "vary", "run"),
        reserved=Reserved.NOWHERE,
        node=syntax.Start,
        key="",
        paths=("hold", "vary"),
        clauses=(
            Word(
                "rest",
                "The state at which all rates vanish, in `start rest`.",
                example="start rest;",
                related=("start",),
                reserved=Reserved.NOWHERE,
            ),
            Word(
                "hold",
                "Names values that a start at rest keeps as they are given.",
                example="start rest hold crane.elbow.angle;",
                related=("start",),
                reserved=Reserved.NOWHERE,
            ),
            Word(
                "vary",
                "Names parameters that a start at rest may change.",
                example="start rest hold elbow.angle vary elbow_drive.torque;",
                related=("start",),
                reserved=Reserved.NOWHERE,
            ),
        ),
    ),
    SceneStatement(
        "proof",
        "Identifies the extended scene.",
        form='a proof is `proof "3f2a91c04d7e";`',
        doc=(
            "`bgc reduce` writes it. `bgc check` warns where the scene that this one extends, or "
            "anything that it uses, has changed since.",
        ),
        example='proof "3f2a91c04d7e";',
        related=("is", "require", "BG097"),
        reserved=Reserved.NOWHERE,
        node=syntax.Proof,
        key="",
    ),
)

SCENE_STATEMENTS: Mapping[str, SceneStatement] = MappingProxyType({row.word: row for row in _ROWS})
"""The statements of scenes, by their first words."""

_WORD_OF = {row.node: row.word for row in _ROWS if row.node is not syntax.Fact}


def statement_of(item: syntax.SceneItem) -> SceneStatement:
    """Return the row of a statement in the syntax tree."""
    return SCENE_STATEMENTS[item.word if isinstance(item, syntax.Fact) else _WORD_OF[type(item)]]


def expressions_in(
    item: syntax.SceneItem, names: Collection[str] | None = None
) -> Iterator[syntax.Expr]:
    """Yield the expressions of a statement in order: all, or those in some of its fields."""
    for name in (each.name for each in fields(item) if names is None or each.name in names):
        value = getattr(item, name)
        for each in value if isinstance(value, tuple) else (value,):
            found = each.value if isinstance(each, syntax.Argument) else each
            if isinstance(found, syntax.Expr):
                yield found
