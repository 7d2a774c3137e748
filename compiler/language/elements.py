"""The basic elements: arguments, laws, causality and readable variables, one row an element.

The compiler takes names, arguments and laws from here, `bgc doc` the texts. Conventions are those
of `bgc.ir.graph`: effort and flow of a bond are positive when power runs along its half arrow, and
the causal stroke stands at the end of the bond that is given the effort.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

from bgc.record_class import dataclass, replace

INITIAL_VALUE = "initial value"  # of a declared state, as `q0` is of a C


class Form(Enum):
    """The variable for which a law is written.

    EFFORT: efforts in terms of the other variable: C `e = K q`, R `e = R f`.
    FLOW: flows in terms of it: I `f = W p`, R `f = G e`.
    DISPLACEMENT: `q = C e`.  MOMENTUM: `p = M f`.
    """

    EFFORT = "effort"
    FLOW = "flow"
    DISPLACEMENT = "displacement"
    MOMENTUM = "momentum"


class Family(Enum):
    """The family of an element by what it does with power; passes treat a family alike."""

    SOURCE = "source"
    STORAGE = "storage"
    RESISTOR = "resistor"
    TWO_PORT = "two-port"
    JUNCTION = "junction"
    BUNDLE = "bundle"  # of bonds, which has no law


class Role(Enum):
    """Purpose of an argument: the constant of a law, the value of a source or ratio, a start."""

    LAW = "law"
    VALUE = "value"
    INITIAL = "initial value"


@dataclass(frozen=True, slots=True)
class ElementArgument:
    """An argument of an element. `form` is that of the law which it gives, for the role LAW.

    `unit` is that of such an argument, as the powers of effort / flow and of the second: a
    stiffness is effort / displacement, with displacement = flow * time; an inertia is
    momentum / flow, with momentum = effort * time.
    """

    name: str
    role: Role
    doc: str
    form: Form | None = None
    unit: tuple[int, int] = (0, 0)


@dataclass(frozen=True, slots=True)
class LawForm:
    """An equation that a law block may hold: `left` in terms of `right`."""

    left: str
    right: str
    form: Form | None = None


@dataclass(frozen=True, slots=True)
class ElementKind:
    """A basic element.

    `basic` is the element without the M that marks a modulated one. `symbol` is the text of its
    node in a drawing, if not its name. `sides` are the faces that
    bonds meet: `all`, or `in` (port 1) and `out` (port 2). `widths` is the largest number of
    dimensions in brackets, None for any. The first argument may be given without its name.
    `energy` are the variables of the law `H`, none where the element has no such law. `missing`
    is the advice for an element without a law. `dependent` says what a storage element without
    integral causality stores. `observed` are the variables that a scene or an
    expression may read of a part.
    """

    name: str
    basic: str
    family: Family
    title: str
    written: tuple[str, ...]
    law: str
    causality: str
    doc: str = ""
    arguments: tuple[ElementArgument, ...] = ()
    laws: tuple[LawForm, ...] = ()
    energy: tuple[str, ...] = ()
    sides: tuple[str, ...] = ("all",)
    widths: int | None = 1
    missing: str = ""
    dependent: str = ""
    symbol: str = ""
    observed: tuple[str, ...] = ("e", "f", "power")
    related: tuple[str, ...] = ()

    @property
    def law_arguments(self) -> Mapping[str, Form]:
        """The arguments that give a linear law, with the form of that law."""
        return {each.name: each.form for each in self.arguments if each.form is not None}

    @property
    def value_argument(self) -> str | None:
        """The argument that is the value of a source, or the ratio of a two-port."""
        return next((each.name for each in self.arguments if each.role is Role.VALUE), None)

    @property
    def initial_arguments(self) -> tuple[str, ...]:
        """The arguments that give values for the start."""
        return tuple(each.name for each in self.arguments if each.role is Role.INITIAL)

    @property
    def right_sides(self) -> Mapping[str, str]:
        """For the left side of each law but that of an energy, the variable of the right side."""
        return {law.left: law.right for law in self.laws}

    @property
    def stored(self) -> tuple[str, ...]:
        """The variables that it integrates: `q`, `p` or both."""
        return tuple(name for name in self.observed if name in {"q", "p"})

    @property
    def law_variables(self) -> tuple[str, ...]:
        """The variables that a law of the element relates, each once."""
        related = (name for form in self.laws for name in (form.left, form.right))
        return tuple(dict.fromkeys((*related, *self.energy)))

    @property
    def law_starts(self) -> tuple[str, ...]:
        """The names with which an equation of a law block begins."""
        return (*(form.left for form in self.laws), *(("H",) if self.energy else ()))


_INITIAL = {
    "q0": "displacement at the start, 0 by default",
    "p0": "momentum at the start, 0 by default",
    "e0": "effort at the start, in place of `q0`",
    "f0": "flow at the start, in place of `p0`",
}
_COMMON = "at the start, which the storage that moves with it has to agree with"
_ANY_PORT = "One bond, or as many bonds as its width has components, in the order written."


def _start(*names: str) -> tuple[ElementArgument, ...]:
    return tuple(ElementArgument(name, Role.INITIAL, _INITIAL[name]) for name in names)


_SE = ElementKind(
    "Se",
    "Se",
    Family.SOURCE,
    "effort source",
    ("Se(e = 5 V)", "Se { e = 5*sin(time); }", "Se[3](e = force)"),
    "e is the given value, whatever the flow.",
    "It gives the effort: the stroke stands at the other end of its bond.",
    "Its arrow may point either way, out of it by custom; the value counts along the arrow. The "
    "value may depend on time and on signals; `MSe` marks such a source but is not required.",
    (ElementArgument("e", Role.VALUE, "the effort; a scalar serves all components"),),
    missing="give its effort: `Se(e = 5)`",
    related=("MSe", "Sf"),
)

_SF = ElementKind(
    "Sf",
    "Sf",
    Family.SOURCE,
    "flow source",
    ("Sf(f = 1 m/s)", "Sf { f = sin(time); }", "Sf[6](f = zeros(6))"),
    "f is the given value, whatever the effort.",
    "It gives the flow: the stroke stands at its own end of the bond.",
    "Its arrow may point either way, out of it by custom; the value counts along the arrow. The "
    "value may depend on time and on signals; `MSf` marks such a source but is not required.",
    (ElementArgument("f", Role.VALUE, "the flow; a scalar serves all components"),),
    missing="give its flow: `Sf(f = 1)`",
    related=("MSf", "Se"),
)

_C = ElementKind(
    "C",
    "C",
    Family.STORAGE,
    "compliance: spring, capacitor, tank",
    (
        "C(10 uF)",
        "C(stiffness = 2 kN/m, q0 = 1 cm)",
        "C { e = k*q + k3*q^3; }",
        "C { H = k/2*q^2 + k3/4*q^4; }",
        "C[3](stiffness = K)",
    ),
    "q' = f, and e follows from q: e = q/C, e = K q, or e = dH/dq of an energy H(q).",
    "Integral causality by preference: it is given the flow and gives the effort, so the stroke "
    "stands at the other end. Otherwise its storage depends on that of others and is merged.",
    f"{_ANY_PORT} The arrow points into it. A matrix is a field that couples its components; a "
    "vector is the diagonal of one. The law may depend on parameters, not on time or signals.",
    (
        ElementArgument("compliance", Role.LAW, "C in q = C e", Form.DISPLACEMENT, (-1, 1)),
        ElementArgument(
            "stiffness", Role.LAW, "K in e = K q; may be 0 or singular", Form.EFFORT, (1, -1)
        ),
        *_start("q0", "e0"),
    ),
    (LawForm("e", "q", Form.EFFORT), LawForm("q", "e", Form.DISPLACEMENT)),
    ("q",),
    dependent="its displacement follows from the effort that it is given",
    missing="give its compliance, `C(c)` or `C(stiffness = k)`, or a law: `C { e = k*q; }`",
    observed=("e", "f", "q", "power"),
    related=("I", "IC"),
)

_I = ElementKind(
    "I",
    "I",
    Family.STORAGE,
    "inertia: mass, flywheel, inductor",
    ("I(2 kg)", "I(1 mH, p0 = 0)", "I { f = p/m; }", "I { H = p^2/(2*m); }", "I[6](M)"),
    "p' = e, and f follows from p: f = p/M, or f = dH/dp of an energy H(p).",
    "Integral causality by preference: it is given the effort and gives the flow, so the stroke "
    "stands at its own end. Otherwise its storage depends on that of others and is merged.",
    f"{_ANY_PORT} The arrow points into it. A matrix is a field that couples its components; a "
    "vector is the diagonal of one. The law may depend on parameters, not on time or signals.",
    (
        ElementArgument("inertia", Role.LAW, "M in p = M f", Form.MOMENTUM, (1, 1)),
        *_start("p0", "f0"),
    ),
    (LawForm("f", "p", Form.FLOW), LawForm("p", "f", Form.MOMENTUM)),
    ("p",),
    dependent="its momentum follows from the flow that it is given",
    missing="give its inertia, `I(m)`, or a law: `I { f = p/m; }`",
    observed=("e", "f", "p", "power"),
    related=("C", "IC"),
)

_R = ElementKind(
    "R",
    "R",
    Family.RESISTOR,
    "resistor: damper, friction, valve",
    ("R(2 ohm)", "R(conductance = 0.5 S)", "R { e = d1*f + d2*abs(f)*f; }", "R[3](D)"),
    "e = R f, f = G e, or an equation for e in f or for f in e. It dissipates e f.",
    "Either. Its law is inverted where it must be, or solved within an algebraic loop.",
    f"{_ANY_PORT} The arrow points into it. A law that depends on time, states or signals needs "
    "`MR`. Where its conductance may be 0 or singular, give `conductance`.",
    (
        ElementArgument("resistance", Role.LAW, "R in e = R f", Form.EFFORT, (1, 0)),
        ElementArgument("conductance", Role.LAW, "G in f = G e", Form.FLOW, (-1, 0)),
    ),
    (LawForm("e", "f", Form.EFFORT), LawForm("f", "e", Form.FLOW)),
    missing="give its resistance, `R(r)` or `R(conductance = g)`, or a law: `R { e = r*f; }`",
    related=("MR",),
)

_IC = ElementKind(
    "IC",
    "IC",
    Family.STORAGE,
    "storage of both kinds on each bond",
    ("IC { H = p^2/(2*m) + k*q^2/2; }", "IC[3](q0 = [0, 0, 1 m]) { H = ..; }"),
    "For one energy H(q, p): f = q' = dH/dp and p' = e - dH/dq on a bond whose p is in H; "
    "q' = f and e = dH/dq on a bond whose p is not.",
    "A bond whose p is in H is that of an I, another that of a C.",
    f"{_ANY_PORT} The arrow points into it. Energy is conserved by construction.",
    _start("q0", "p0", "e0", "f0"),
    energy=("q", "p"),
    dependent="its energy variables follow from what its bonds give it",
    missing="give its energy: `IC { H = p^2/(2*m) + k*q^2/2; }`",
    observed=("e", "f", "q", "p", "power"),
    related=("C", "I"),
)

_TF = ElementKind(
    "TF",
    "TF",
    Family.TWO_PORT,
    "transformer: lever, gear, piston",
    ("TF(ratio = n)", "TF(20)", "TF { f2 = n*f1; }", "TF { f2 = J*f1; }"),
    "f2 = m f1 and e1 = m e2: power in at port 1 leaves at port 2. Of a matrix J, f2 = J f1 and "
    "e1 = J' e2.",
    "One stroke comes in and one goes on: it is given one effort and gives the other. A "
    "matrix that is not square determines which.",
    "Port 1 is where the arrow comes in, port 2 where it goes out: `joints -> map -> tip`. Write "
    "one equation, for e1, f1, e2 or f2; the other follows, so that power is conserved. A gear of "
    "20 turns in for 1 turn out is `TF(1/20)`. A ratio that depends on time, states or signals "
    "needs `MTF`.",
    (ElementArgument("ratio", Role.VALUE, "m in f2 = m f1, e1 = m e2"),),
    (LawForm("f2", "f1"), LawForm("e1", "e2"), LawForm("f1", "f2"), LawForm("e2", "e1")),
    sides=("in", "out"),
    widths=2,
    missing="give its ratio, `TF(m)`, or a law: `TF { f2 = m*f1; }`",
    observed=("e1", "f1", "e2", "f2", "power"),
    related=("MTF", "GY"),
)

_GY = ElementKind(
    "GY",
    "GY",
    Family.TWO_PORT,
    "gyrator: motor, pump, gyroscope",
    ("GY(ratio = k)", "GY(0.05)", "GY { e2 = k*f1; }", "MGY[6] { e = S*f; }"),
    "e2 = r f1 and e1 = r f2. Of a matrix r, e2 = r f1 and e1 = r' f2.",
    "Two strokes at it or none: it is given both efforts or both flows.",
    "Port 1 is where the arrow comes in, port 2 where it goes out. Write one equation; the other "
    "follows, so that power is conserved. With bonds on one side only, and a law `e = S*f` of a "
    "skew matrix S, it is the gyristor of a rotating body. A ratio that depends on time, states "
    "or signals needs `MGY`.",
    (ElementArgument("ratio", Role.VALUE, "r in e2 = r f1, e1 = r f2"),),
    (LawForm("e2", "f1"), LawForm("e1", "f2"), LawForm("f1", "e2"), LawForm("f2", "e1")),
    sides=("in", "out"),
    widths=2,
    missing="give its ratio, `GY(r)`, or a law: `GY { e2 = r*f1; }`",
    observed=("e1", "f1", "e2", "f2", "power"),
    related=("MGY", "TF"),
)

_J0 = ElementKind(
    "J0",
    "J0",
    Family.JUNCTION,
    "0-junction: common effort",
    ("node : J0;", "gap : J0[6];", "node : J0(e0 = 3 V);"),
    "All bonds have one effort; the flows sum to zero, those of arrows in less those of arrows "
    "out. Electrically parallel; a relative velocity in mechanics.",
    "Exactly one bond gives it the effort: one stroke stands at the junction.",
    "Any number of bonds, all of one width, which need not be written. `e0` sets the charges and "
    "momenta that determine the effort; a zero that is a part's default gives way.",
    (ElementArgument("e0", Role.INITIAL, f"effort {_COMMON}"),),
    observed=("e",),
    symbol="0",
    related=("J1",),
)

_J1 = ElementKind(
    "J1",
    "J1",
    Family.JUNCTION,
    "1-junction: common flow",
    ("loop : J1;", "hub : J1[6];", "free : J1(f0 = rate0);"),
    "All bonds have one flow; the efforts sum to zero, those of arrows in less those of arrows "
    "out. Electrically in series; a common velocity in mechanics.",
    "Exactly one bond gives it the flow: all strokes but one stand at the junction.",
    "Any number of bonds, all of one width, which need not be written. The signals of a domain "
    "(a pose, say) pass through it from tail to head. `f0` sets the momenta that determine the "
    "flow, such as those of a joint's rate; a zero that is a part's default gives way.",
    (ElementArgument("f0", Role.INITIAL, f"flow {_COMMON}"),),
    observed=("f",),
    symbol="1",
    related=("J0",),
)

_MUX = ElementKind(
    "Mux",
    "Mux",
    Family.BUNDLE,
    "joins bonds into a wide one",
    ("join : Mux[3, 3];", "lin, ang -> join -> body;", "shafts : Mux[1, 1, 1];"),
    "The components of its arrows in, in the order written, are those of its arrow out.",
    "None of its own: it is dissolved into scalar bonds.",
    "The numbers in brackets are the widths of the bonds that come in, which one statement lists. "
    "A slice of a junction, `hub[1..3] -> lin`, takes components without it.",
    sides=("in", "out"),
    widths=None,
    observed=(),
    related=("Demux",),
)

_DEMUX = replace(
    _MUX,
    name="Demux",
    basic="Demux",
    title="splits a wide bond",
    written=("split : Demux[3, 3];", "body -> split -> lin, ang;"),
    law="The components of its arrow in are those of its arrows out, in the order written.",
    doc="The numbers in brackets are the widths of the bonds that go out, which one statement "
    "lists. A slice of a junction, `hub[1..3] -> lin`, takes components without it.",
    related=("Mux",),
)


def _modulated(element: ElementKind, title: str, written: tuple[str, ...]) -> ElementKind:
    """The same element, whose law or value may depend on time, states and signals."""
    doc = (
        f"As `{element.name}`, with a law that may depend on time, states, signals and the "
        "variables of other bonds. The dependence carries no power."
    )
    return replace(
        element,
        name=f"M{element.name}",
        title=title,
        written=written,
        doc=doc,
        related=(element.name,),
    )


ELEMENTS: Mapping[str, ElementKind] = {
    kind.name: kind
    for kind in (
        _SE,
        _SF,
        _C,
        _I,
        _R,
        _IC,
        _TF,
        _GY,
        _J0,
        _J1,
        _modulated(_SE, "modulated effort source", ("MSe(e = gain*error)",)),
        _modulated(_SF, "modulated flow source", ("MSf(f = amplitude*sin(w*time))",)),
        _modulated(_TF, "modulated transformer", ("MTF { f2 = jacobian*f1; }", "MTF(lever)")),
        _modulated(_GY, "modulated gyrator", ("MGY(field)", "MGY[6] { e = skew_of(body.p)*f; }")),
        _modulated(_R, "modulated resistor", ("MR { f = opening*orifice(e, small); }",)),
        _MUX,
        _DEMUX,
    )
}
"""All basic elements by name."""

# The variables of elements that a model may read, and what each is.
VARIABLES_OF_ELEMENTS = {
    "e": "effort",
    "f": "flow",
    "p": "momentum",
    "q": "displacement",
    "e1": "effort of port 1",
    "f1": "flow of port 1",
    "e2": "effort of port 2",
    "f2": "flow of port 2",
}
