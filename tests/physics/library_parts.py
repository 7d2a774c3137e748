"""Every part of the library in a small scene of its own, built from its ports.

A port gets a neighbour by its domain: a source behind a resistance, which takes flow or effort as
the part asks for; a frame gets a body that is thrown. So each part meets moving, loaded neighbours
without a model of its own in `models/`. What a part needs beyond its defaults stands in `GIVEN`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import bgc.library
from bgc.grammar.parse import parse, read_source
from bgc.grammar.syntax import Model, Port, Value

LIBRARY = Path(bgc.library.__path__[0])


@dataclass(frozen=True)
class Given:
    """Widths, arguments, bonds of ports in place of neighbours, declarations of the file."""

    widths: tuple[int, ...] = ()
    arguments: str = ""
    bonds: dict[str, str] | None = None
    declarations: str = ""


@dataclass(frozen=True)
class Declared:
    """A model of the library and the module that declares it."""

    module: str
    model: Model

    @property
    def name(self) -> str:
        return self.model.name


@cache
def declared() -> dict[str, Declared]:
    """All models of the library but scenes and examples, by name; interfaces too."""
    found: dict[str, Declared] = {}
    for file in sorted(LIBRARY.rglob("*.bg")):
        if file.parent.name in ("scenes", "examples"):
            continue
        parsed, _ = parse(read_source(file))
        for model in parsed.declarations:
            if isinstance(model, Model):
                assert model.name not in found, f"two parts are called {model.name}"
                found[model.name] = Declared(f"{file.parent.name}.{file.stem}", model)
    return found


def parts() -> tuple[str, ...]:
    """The names of all parts that can be used: every model but the interfaces."""
    return tuple(name for name, found in declared().items() if not found.model.interface)


def _bases(name: str) -> Iterator[Model]:
    """The model and those that it is made of, the most basic one last."""
    while True:
        model = declared()[name].model
        yield model
        if model.base is None:
            return
        name = model.base.name


def ports(name: str) -> tuple[Port, ...]:
    """The ports of a part and of what it is made of."""
    found: dict[str, Port] = {}
    for model in _bases(name):
        for item in model.items:
            if isinstance(item, Port):
                found.setdefault(item.name, item)
    return tuple(found.values())


def inputs(name: str) -> tuple[Value, ...]:
    """The inputs of a part that its model or its arguments leave open."""
    found: dict[str, Value] = {}
    closed: set[str] = set()
    for model in _bases(name):
        for item in model.items:
            if isinstance(item, Value):
                found.setdefault(item.name, item)
        if model.base is not None:
            closed |= {a.name for a in model.base.arguments if a.name}
    return tuple(v for v in found.values() if v.kind == "input" and v.name not in closed)


# --- harnesses -----------------------------------------------------------------------------

# Amplitude of the source and its resistance, by domain; without a domain a shaft is meant.
SOURCES = {
    "Electrical": ("10 V", "2 ohm"),
    "Translational": ("50 N", "20 N*s/m"),
    "Rotational": ("5 N*m", "2 N*m*s"),
    "Hydraulic": ("40 bar", "0.5 bar*min/L"),
    "Thermal": ("350 K", "2 K/W"),
    None: ("5", "2"),
}
BODY = "HeavyBody(mass = 500 kg, inertia = diag([300, 400, 500]), com = [0.1, 0.2, -0.1])"
WAVES = (
    "amplitude = 0.5*ones(3), frequency = [0.5, 0.8, 1.2], phase = [0, 1, 2], direction = zeros(3)"
)


def harness(name: str, given: Given | None = None) -> str:
    """A file with one scene, `around`: the part with a neighbour at each port."""
    observed = "".join(f"observe part.{o} as out_{o};" for o in outputs(name))
    return f"""{_imports([name])}
{_around(name, "Around", given or GIVEN.get(name, Given()))}
scene around of Around {{
  keep part;
  observe energy.stored, energy.supplied, energy.dissipated, energy.residual;
  {observed}
  solver rodas5p(rtol = 1e-7);
  run 0.5 s every 10 ms;
}}
"""


def together(names: Sequence[str]) -> str:
    """A file with one scene, `together`, of several harnesses that do not touch each other."""
    models = "\n".join(_around(n, f"Around{n}", GIVEN.get(n, Given())) for n in names)
    held = "\n".join(f"  in_{n} : Around{n};" for n in names)
    observed = "\n".join(
        f"  observe in_{n}.part.{o} as {n}_{o};" for n in names for o in outputs(n)
    )
    return f"""{_imports(names)}
{models}
model Together {{
{held}
}}
scene together of Together {{
  observe energy.stored, energy.supplied, energy.dissipated, energy.residual;
{observed}
  solver rodas5p(rtol = 1e-7);
  run 0.2 s every 10 ms;
}}
"""


def _imports(names: Sequence[str]) -> str:
    modules = {declared()[name].module for name in names} | {"mechanics.body", "mechanics.joints"}
    return "\n".join(f"import {module};" for module in sorted(modules))


def _around(name: str, called: str, given: Given) -> str:
    """The model of a harness."""
    model = declared()[name].model
    widths = {f.name: width for f, width in zip(model.formals, given.widths, strict=False)}
    for formal in model.formals:
        if formal.name not in widths:
            assert formal.default is not None, f"{name} needs a width {formal.name}"
            widths[formal.name] = int(formal.default.span.text)
    arguments = [given.arguments] if given.arguments else []
    for item in inputs(name):
        if f"{item.name} =" not in given.arguments:
            arguments += _driven(item, widths)
    dims = f"[{', '.join(str(widths[f.name]) for f in model.formals)}]" if widths else ""
    bonds = given.bonds or {}
    around = "\n".join(
        bonds[port.name] if port.name in bonds else _neighbour(port, k, widths)
        for k, port in enumerate(ports(name))
    )
    return f"""{given.declarations}
model {called} {{
  part : {name}{dims}({", ".join(arguments)});
{around}
}}
"""


def outputs(name: str) -> tuple[str, ...]:
    """The outputs of a part."""
    found = {
        item.name: None
        for model in _bases(name)
        for item in model.items
        if isinstance(item, Value) and item.kind == "output"
    }
    return tuple(found)


def _width(dims: tuple[object, ...], widths: dict[str, int]) -> list[int]:
    return [int(eval(d.span.text, {}, {**widths, "m": widths.get("m", 3)})) for d in dims]


def _driven(item: Value, widths: dict[str, int]) -> list[str]:
    """An argument that moves an input that has no value, or a scalar one that is zero."""
    if item.value is not None and (item.dims or item.value.span.text.split()[0] != "0"):
        return []
    sizes = _width(item.dims, widths)
    if not sizes:
        return [f"{item.name} = 0.5*sin(7*time) + 0.1"]
    if len(sizes) == 1:
        terms = ", ".join(f"{0.3 + 0.1 * k:.1f}*sin({5 + k}*time)" for k in range(sizes[0]))
        return [f"{item.name} = [{terms}]"]
    return [f"{item.name} = (1 + 0.1*sin(5*time))*eye({sizes[0]})"]


def _neighbour(port: Port, k: int, widths: dict[str, int]) -> str:
    enters = port.direction is not None and port.direction.value == "in"
    p = port.name
    if port.domain == "Frame":
        if enters:
            return f"""
  {p}_origin : Ground;
  {p}_throw  : Free(position0 = [{4 * k}, 1, 2], angles0 = [0.1, 0.2, 0.3],
    rate0 = [1, 0.5, 0, 0.3, 0.2, 0.4]);
  {p}_hub    : J1;
  {p}_body   : {BODY};
  {p}_origin -> {p}_throw -> {p}_hub -> {p}_body;
  {p}_hub -> part.{p};"""
        return f"  {p}_body : {BODY};\n  part.{p} -> {p}_body;"
    effort, resistance = SOURCES[port.domain]
    sizes = _width(port.dims, widths)
    width = f"[{sizes[0]}]" if sizes else ""
    wave = f"{effort}*(0.2 + sin({6 + k}*time))"
    if port.domain == "Thermal":
        wave = f"{effort}*(1 + 0.2*sin({6 + k}*time))"
    if sizes:
        wave = f"{wave}*ones({sizes[0]})"
    path = (
        f"{p}_source -> {p}_way -> part.{p};" if enters else (f"part.{p} -> {p}_way -> {p}_source;")
    )
    return f"""
  {p}_source : Se{width}(e = {wave});
  {p}_way    : J1{width};
  {p}_loss   : R{width}({resistance});
  {path}
  {p}_way -> {p}_loss;"""


INERTIA = "inertia = diag([1, 2, 2.5])"
CURRENT = Path(__file__).parents[1] / "models" / "current.csv"


HULL = (
    "M_RB = diag([2e4, 2e4, 2e4, 1e5, 4e5, 4e5]), M_A = diag([2e3, 1e4, 2e4, 2e4, 2e5, 1e5]),"
    " D = diag([1e3, 1e4, 2e4, 2e4, 4e5, 2e5])"
)
SEAKEEPING = f"{HULL}, G = diag([2e5, 1e5, 2e6])"


def _thrown(port: str, at: str, rate: str = "[1, 0.5, 0, 0.3, 0.2, 0.4]") -> str:
    """A thrown body at a given place."""
    return f"""
  {port}_origin : Ground;
  {port}_throw  : Free(position0 = {at}, rate0 = {rate});
  {port}_hub    : J1;
  {port}_body   : {BODY};
  {port}_origin -> {port}_throw -> {port}_hub -> {port}_body;
  {port}_hub -> part.{port};"""


def _hand(port: str) -> dict[str, str]:
    """A mass that a sampled port moves."""
    return {
        port: f"""
  {port}_way  : J1[3];
  {port}_mass : I[3](2 kg);
  {port}_loss : R[3](5 N*s/m);
  part.{port} -> {port}_way -> {port}_mass, {port}_loss;"""
    }


CONTACT = {
    "plane": "  floor : Ground;\n  floor -> part.plane;",
    "body": _thrown("body", "[0, 0, 0.5]", "[0.2, 0.1, -1, 0, 0, 0]"),
}
LOCKED = {
    "p": """
  p_way    : J1[3];
  p_mass   : I[3](2 kg, f0 = [0.1, 0.2, 0.3]);
  p_source : Se[3](e = [1, 2, 3]*sin(6*time));
  p_source -> p_way -> p_mass;
  part -> p_way;"""
}


GIVEN: dict[str, Given] = {
    # Typologies: lengths, and joints away from singular positions.
    "Planar3R": Given(arguments="links = [2, 1.5, 1]"),
    "Scara": Given(arguments="l1 = 1, l2 = 0.7"),
    "Anthropomorphic6R": Given(arguments="l1 = 1, l2 = 0.7"),
    "Planar2R": Given(arguments="l1 = 2, l2 = 1.5"),
    "Slew2R": Given(arguments="l1 = 2, l2 = 1.5"),
    "SlewLuffTelescope": Given(arguments="length = 5"),
    "KnuckleBoom": Given(
        arguments="l1 = 7, l2 = 5.2, boom_pins = [1.485, 2.831], boom_offset = 0.7869,"
        " jib_pins = [2.955, 1.002], jib_offset = 3.0758,"
        " coordinates = [0.1*sin(time), 2.5 + 0.1*sin(time), 2.6 + 0.1*sin(2*time)]"
    ),
    "Cylindrical": Given(arguments="coordinates = [sin(time), 1 + time, 2 - time]"),
    # Bodies, links and beams.
    "Link": Given(arguments=f"mass = 3, {INERTIA}"),
    "Beam": Given(arguments="length = 4, mass = 300"),
    "SectionBeam": Given(arguments="length = 4"),
    "Member": Given(arguments="length = 4, mass = 300, moments = [10, 400, 400]"),
    "RigidBody": Given(arguments=f"mass = 3, {INERTIA}"),
    "HeavyBody": Given(arguments=f"mass = 3, {INERTIA}"),
    "PointMass": Given(arguments="mass = 3"),
    "RotaryInertia": Given(widths=(3,), arguments="moments = [1, 2, 3]"),
    "FreeBody": Given(arguments=f"mass = 3, {INERTIA}"),
    "FlexibleBeam": Given(arguments="length = 4"),
    "GivenSection": Given(arguments="area = 1e-2, Iy = 1e-4, Iz = 1e-4, J = 1e-4"),
    # Control.
    "Elimination": Given((3, 1), arguments="b = [1, 2, time]"),
    "DefiniteSolve": Given((3,), arguments="b = [1, 2, time]"),
    "ResolvedRate": Given(arguments="rate = [1, 2, 3]"),
    "Shift": Given(arguments="offset = [0.3, 0.2, 0.1]"),
    "Compliant": Given((3,), bonds=LOCKED),
    "Rigid": Given((3,), bonds={"p": LOCKED["p"].replace(", f0 = [0.1, 0.2, 0.3]", "")}),
    "Weld": Given(
        bonds={
            "a": _thrown("a", "[0, 0, 2]"),
            "b": f"""
  b_ground : Ground;
  b_free   : Free(position0 = [0, 0, 2]);
  b_hub    : J1;
  b_body   : {BODY};
  b_ground -> b_free -> b_hub -> b_body;
  b_hub -> part.b;""",
        }
    ),
    "PointContact": Given(arguments="gap0 = 0.5", bonds=CONTACT),
    "Feet": Given(
        (4,),
        arguments="at = [[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]], gap0 = 0.5*ones(4)",
        bonds=CONTACT,
    ),
    # Hulls.
    "FloatingHull": Given(arguments=SEAKEEPING),
    "Vessel": Given(arguments=SEAKEEPING),
    "SeakeepingHull": Given(arguments=SEAKEEPING),
    "SeakeepingVessel": Given(arguments=SEAKEEPING),
    # Ropes and two-point parts: the ends are thrown bodies whose distance is known.
    "Tackle": Given(arguments="distance0 = 4, paid0 = 7.9"),
    "Rope": Given(arguments="distance0 = 4, paid0 = 3.9"),
    "Tugger": Given(arguments="distance0 = 4"),
    # Couplings of a hand.
    "SampledPort": Given((3,), bonds=_hand("bond")),
    "NoGuard": Given((3,), bonds=_hand("bond")),
    "Observer": Given((3,), bonds=_hand("bond")),
    "Coupling": Given((3,), bonds=_hand("bond")),
    # The sea.
    "Drag": Given(arguments="area = [1, 2, 3]"),
    "UniformCurrent": Given((3,)),
    "CurrentProfile": Given((3,)),
    "GivenCurrent": Given(
        (3,),
        arguments="table = flow",
        declarations=f'const flow = data("{CURRENT}");',
    ),
    "FluidMemory": Given((17,)),
    "Response": Given((3,), arguments=WAVES),
    "OrbitalMotion": Given((3,), arguments=WAVES),
    "SplashZone": Given((3,), arguments=WAVES),
    "GivenWaves": Given((3,), arguments="amplitude = 0.5*ones(3), frequency = [0.5, 0.8, 1.2]"),
}
# Ships in a sea of few components: what one costs, many cost.
for _ship in (
    "ShipGuided ShipSeakeepingInSea ShipUnderWaves ShipInSea ShipWithMemory ShipInWeather"
    " Supply SupplyWithMemory SupplyInWeather SupplySeakeeping SupplyGuided"
).split():
    GIVEN[_ship] = Given((3,))
