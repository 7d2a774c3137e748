"""Models that grow with one number: text of `.bg` files for the benchmarks."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path

import bgc.library

_CRANE = """\
import mechanics.joints;
import crane.beam;

/// A crane of {n} beams on compliant joints, whose axes alternate: twelve states a beam.
model Crane {{
  ground : Ground;
  for i in 1..{n} {{
    let upright = i - 2*floor(i/2);
    joint[i] : Revolute(
      axis = upright*y + (1 - upright)*z, friction = 2000 N*m*s/rad,
      lock = Compliant[5](stiffness = 1e7 N/m, damping_ratio = 0.1, mass = 100 kg),
      torque = -(4e5 N*m)*joint[i].angle);
    beam[i] : Beam(axis = x, length = 2 m, mass = 100 kg, side = 0.2 m);
    joint[i] -> beam[i];
  }}
  for i in 2..{n} {{
    beam[i-1] -> joint[i];
  }}
  free : Se(e = [100, 50, 20, 0, 0, 0]);
  ground -> joint[1];
  beam[{n}] -> free;
}}

scene crane of Crane {{
  observe beam[{n}].tip.r as tip;
  run 1 s every 0.1 s;
}}
"""


def crane(n: int) -> str:
    """A chain of n beams on compliant joints, 12 n states."""
    return _CRANE.format(n=n)


_BEAM = """\
import mechanics.flexible;

/// A clamped beam of {n} elements in space, which a skew force at its end sets swinging.
model Boom {{
  ground : Ground;
  beam   : FlexibleBeam[{n}](
    length = 10 m, section = Rectangle(width = 0.12 m, height = 0.2 m), damping_ratio = 0.02);
  end : Se[6](e = [100 N, 200 N, 300 N, 50 N*m, 0, 0]);
  ground -> beam -> end;
}}

scene boom of Boom {{
  observe beam.deflection as tip;
  run 1 s every 0.1 s;
}}
"""


def beam(n: int) -> str:
    """A flexible beam of n elements in space, 12 n states."""
    return _BEAM.format(n=n)


def grid(n: int) -> str:
    """A square grid of n by n capacitors with coils between neighbours, driven at one corner."""
    places = [(i, j) for i in range(n) for j in range(n)]
    edges = [((i, j), (i + 1, j)) for i, j in places if i + 1 < n]
    edges += [((i, j), (i, j + 1)) for i, j in places if j + 1 < n]
    return _network(
        [i * n + j for i, j in places], [(a[0] * n + a[1], b[0] * n + b[1]) for a, b in edges]
    )


def circuit(n: int, seed: int = 1) -> str:
    """A circuit of n nodes with capacitors, coils between each and one or two before it."""
    rng = random.Random(seed)
    edges = [(max(0, k - rng.randint(1, 6)), k) for k in range(1, n)]
    edges += [tuple(sorted(rng.sample(range(max(0, k - 20), k + 1), 2))) for k in range(20, n, 2)]
    return _network(list(range(n)), sorted(set(edges)))


def _network(nodes: list[int], edges: list[tuple[int, int]]) -> str:
    lines = ["model Network {", "  drive : Se(e = sin(2*time)); feed : R(1); entry : J1;",
             "  drive -> entry -> feed; entry -> node0;"]  # fmt: skip
    for k in nodes:
        lines.append(f"  node{k} : J0; store{k} : C({1 + k % 3}); leak{k} : R({20 + k % 7});")
        lines.append(f"  node{k} -> store{k}, leak{k};")
    for k, (a, b) in enumerate(edges):
        lines.append(
            f"  edge{k} : J1; coil{k} : I({1 + k % 5}); loss{k} : R({0.1 * (1 + k % 4):g});"
        )
        lines.append(f"  node{a} -> edge{k} -> coil{k}, loss{k}, node{b};")
    near = nodes[len(nodes) // 10]  # far from the drive hardly anything moves
    lines.append(
        f"}}\nscene network of Network {{ observe store{near}.e as near; run 10 s every 1 s; }}"
    )
    return "\n".join(lines) + "\n"


def arm(n: int) -> str:
    """A chain of n boxes on hinges about z, y and x in turn, which hangs and swings."""
    return _boxes(n, lambda k: k - 1)


def tree(n: int) -> str:
    """A binary tree of n boxes on hinges."""
    return _boxes(n, lambda k: (k - 1) // 2 if k else -1)


def box(k: int) -> tuple[str, float, float, float]:
    """Axis, angle and rate at the start, and mass of the box k of an arm or a tree."""
    return "zyx"[k % 3], 0.3 + 0.05 * k, (-1) ** k * 0.2, 2 + 0.1 * (k % 5)


LINK = 0.3  # m, between two hinges
FRICTION = 0.5  # N*m*s of each hinge
CENTRE = (0.15, 0.01, 0.02)  # m, the centre of mass of a box from its hinge
INERTIA = ((0.01, 0.001, 0.0), (0.001, 0.03, 0.0), (0.0, 0.0, 0.03))  # kg*m^2 about the centre


_SKEW = ((1, 2, 2), (2, 1, -2), (2, -2, 1))  # of norm 3


def skew(n: int) -> str:
    """An arm on hinges about three axes that are no axes of the boxes."""
    axes = ["[" + ", ".join(f"{each}/3" for each in axis) + "]" for axis in _SKEW]
    return _boxes(n, lambda k: k - 1, lambda k: _hinge(k, axes[k % 3]))


def slides(n: int) -> str:
    """An arm whose second, fourth, .. joint slides along an axis of the box before."""
    return _boxes(n, lambda k: k - 1, lambda k: _slide(k) if k % 2 else _hinge(k))


def mixed(n: int) -> str:
    """An arm of hinges about axes of the boxes and others, and of slides, in turn."""
    axes = ["[" + ", ".join(f"{each}/3" for each in axis) + "]" for axis in _SKEW]
    return _boxes(
        n, lambda k: k - 1, lambda k: (_hinge(k), _hinge(k, axes[k % 3]), _slide(k))[k % 3]
    )


def turned(n: int) -> str:
    """An arm on hinges about the z axes of mounts that are a quarter turn apart."""
    return _boxes(n, lambda k: k - 1, lambda k: _hinge(k, "z"), ", axes = rot_x(90 deg)")


def _hinge(k: int, axis: str = "") -> str:
    usual, angle, rate, _ = box(k)
    return (
        f"  joint{k} : Revolute(axis = {axis or usual}, angle0 = {angle:.2f} rad,\n"
        f"    rate0 = {rate} rad/s, friction = {FRICTION} N*m*s, lock = Rigid[5]);"
    )


def _slide(k: int) -> str:
    return (
        f"  joint{k} : Prismatic(axis = {box(k)[0]}, extension0 = 0.1 m, rate0 = 0.1 m/s,\n"
        f"    friction = 50 N*s/m, force = -(400 N/m)*joint{k}.extension, lock = Rigid[5]);"
    )


def _boxes(
    n: int,
    parent: Callable[[int], int],
    joint: Callable[[int], str] = _hinge,
    mount: str = "",
) -> str:
    com = ", ".join(f"{x} m" for x in CENTRE)
    lines = ["import arms.link;", "", "model Boxes {", "  ground : Ground;"]
    for k in range(n):
        mass = box(k)[3]
        before = f"node{parent(k)}" if parent(k) >= 0 else "ground"
        lines += [
            f"  mount{k} : Mount(offset = [{LINK if parent(k) >= 0 else 0} m, 0, 0]{mount});",
            joint(k),
            f"  node{k} : J1;",
            f"  body{k} : HeavyBody(mass = {mass:.1f} kg, com = [{com}],",
            "    inertia = symmetric(0.01, 0.001, 0, 0.03, 0, 0.03));",
            f"  {before} -> mount{k} -> joint{k} -> node{k} -> body{k};",
        ]
    rates = ", ".join(f"joint{k}.free.f as v{k}" for k in range(n))
    return "\n".join([*lines, "}", "", f"scene hang of Boxes {{ observe {rates}; run 1 s; }}", ""])


_CHAIN = """
model Chain {{
  push : Se(e = 1 N);
  for i in 1..{n} {{
    mass[i] : I(1 kg); at[i] : J1; between[i] : J0; gap[i] : J1; spring[i] : C(stiffness = 1 N/m);
    drag[i] : R(0.1 N*s/m);
    at[i] -> mass[i];
    at[i] -> between[i];
    between[i] -> gap[i] -> spring[i], drag[i];
  }}
  for i in 1..{n} - 1 {{ between[i] -> at[i + 1]; }}
  push -> at[1];
}}
scene pull of Chain {{ observe mass[1].f as first; run 10 s every 1 s; }}
"""

_MOTORS = """
model Motor {{
  port shaft out;
  supply : Se(e = 24 V); coil : J1; wire : R(1 ohm); winding : I(2 mH); drive : GY(0.05 N*m/A);
  turning : J1; rotor : I(1e-4 kg*m^2);
  supply -> coil -> wire, winding; coil -> drive -> turning -> rotor; turning -> shaft;
}}
model Motors {{
  common : J0; twist : C(stiffness = 10 N*m/rad); bearing : R(1 N*m*s/rad);
  for i in 1..{n} {{ motor[i] : Motor; motor[i].shaft -> common; }}
  common -> twist;
  common -> bearing;
}}
scene start of Motors {{ observe twist.e; run 1 s; }}
"""


def chain(n: int) -> str:
    """A row of n masses with springs and dampers between them, pulled at one end."""
    return _CHAIN.format(n=n)


def motors(n: int) -> str:
    """Electric motors that turn one twisted shaft; each is a submodel."""
    return _MOTORS.format(n=n)


def ladder(n: int) -> str:
    """A ladder of resistors and capacitors with a bridge every third node: resistive loops."""
    lines = ["model Circuit {", "  supply : Se(e = 5 V);"]
    lines += [f"  node{k} : J0;" for k in range(n)]
    bonds = ["  supply -> in0; in0 : J1; inner : R(1 ohm); in0 -> inner; in0 -> node0;"]
    for k in range(n - 1):
        bonds.append(f"  b{k} : J1; r{k} : R({1 + k % 7} ohm);")
        bonds.append(f"  node{k} -> b{k} -> node{k + 1}; b{k} -> r{k};")
        if k % 3 == 0 and k + 2 < n:
            bonds.append(f"  d{k} : J1; s{k} : R({2 + k % 5} ohm);")
            bonds.append(f"  node{k} -> d{k} -> node{k + 2}; d{k} -> s{k};")
    bonds += [f"  c{k} : C({1 + k % 3} uF); node{k} -> c{k};" for k in range(0, n, 2)]
    scene = f"scene charge of Circuit {{ observe node{n - 1}.e; run 1 ms; }}"
    return "\n".join([*lines, *bonds, "}", scene])


def field(n: int) -> str:
    """A dense inductance matrix of n coils, all excited."""
    rows = ", ".join(
        "[" + ", ".join(f"{(2.0 if i == j else 1 / (3.0 + abs(i - j)))!r}" for j in range(n)) + "]"
        for i in range(n)
    )
    return (
        f"model Coils {{ param M = [{rows}]; supply : Se[{n}](e = 1); all : J1[{n}];"
        f" coils : I[{n}](M); loss : R[{n}](1); supply -> all -> coils, loss; }}\n"
        f"scene rise of Coils {{ observe coils.f as currents; run 10 s every 1 s; }}"
    )


HYDRAULIC = {50: "knuckle_boom_hydraulic", 76: "knuckle_boom_at_sea"}  # scenes by their states


def hydraulic(states: int) -> str:
    """The first scene of a hydraulic knuckle-boom crane of the library."""
    folder = Path(bgc.library.__path__[0]) / "scenes"
    text = (folder / f"{HYDRAULIC[states]}.bg").read_text("utf-8")
    scenes = [found.start() for found in re.finditer(r"^scene ", text, re.MULTILINE)]
    return text[: [*scenes, len(text)][1]]


MODELS: dict[str, Callable[[int], str]] = {
    "crane": crane,
    "beam": beam,
    "arm": arm,
    "tree": tree,
    "skew": skew,
    "slides": slides,
    "mixed": mixed,
    "turned": turned,
    "chain": chain,
    "motors": motors,
    "circuit": circuit,
    "ladder": ladder,
    "grid": grid,
    "field": field,
    "hydraulic": hydraulic,
}


def text_of(name: str) -> str:
    """The text of a model such as `crane:16`."""
    kind, _, size = name.partition(":")
    return MODELS[kind](int(size))
