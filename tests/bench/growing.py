"""Models that grow with one number: text of `.bg` files for the benchmarks."""

from __future__ import annotations

import random

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


MODELS = {"crane": crane, "grid": grid, "circuit": circuit}
