"""Loops of monotone laws have one solution, which the start of a run finds.

The networks are trees of junctions, transformers and gyrators with steep, flat and saturating
resistances. Each is compiled once and started with parameters over four powers of ten, far from
the defaults, for which the compiler has solved its loops.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from refusals import refusal

import bgc

LAWS = (
    "{k}*{x}",
    "{k}*{x}^3",
    "{k}*abs({x})*{x}",
    "{k}*{x} + {m}*{x}^3",
    "{k}*(exp({s}*{x}) - 1) + {m}*{x}",
    "{k}*tanh({s}*{x}) + {m}*{x}",
    "{k}*asinh({s}*{x})",
    "{k}*sinh({s}*{x})",
    "{k}*atan({s}*{x}) + {m}*{x}",
    "{k}*sign({x})*sqrt(abs({x}))",
    "{k}*{x} + {m}*sign({x})*sqrt(abs({x}))",
    "{k}*({x} + {m}*max({x}, 0))",
)


class Network:
    """The text of a random network; `ranges` are the powers of ten of its parameters."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.lines: list[str] = []
        self.ranges: dict[str, tuple[float, float, bool]] = {}
        count = self.rng.randint(2, 7)
        kinds = [self.rng.choice(("J0", "J1")) for _ in range(count)]
        self.lines += [f"n{i} : {kind};" for i, kind in enumerate(kinds)]
        for i in range(1, count):
            self._join(i, self.rng.randrange(max(0, i - 3), i))
        for i, kind in enumerate(kinds):
            for j in range(self.rng.randint(1, 2)):
                self._element(f"x{i}_{j}", f"n{i}")
            if self.rng.random() < 0.5:
                source, variable = ("Sf", "f") if kind == "J0" else ("Se", "e")
                value = self._parameter(-1, 1.5, signed=True)
                self.lines.append(f"s{i} : {source}({variable} = {value}); s{i} -> n{i};")
        common = (f"n{i}.{'e' if kind == 'J0' else 'f'}" for i, kind in enumerate(kinds))
        self.text = (
            f"model M {{ {' '.join(self.lines)} z : J1; zc : C(1); zr : R(1); z -> zc, zr; }}\n"
            f"scene s of M {{ observe zc.q, {', '.join(common)}; run 1; }}\n"
        )

    def _parameter(self, low: float, high: float, signed: bool = False) -> str:
        name = f"a{len(self.ranges)}"
        self.ranges[name] = (low, high, signed)
        self.lines.append(f"param {name} = {10 ** self.rng.uniform(low, high)!r};")
        return name

    def _join(self, i: int, j: int) -> None:
        kind = self.rng.choice(("TF", "GY", "", ""))
        if kind:
            ratio = self._parameter(-1, 1)
            self.lines.append(f"t{i} : {kind}({ratio}); n{i} -> t{i} -> n{j};")
        else:
            self.lines.append(f"n{i} -> n{j};")

    def _element(self, name: str, where: str) -> None:
        left, right = self.rng.choice(("ef", "fe"))
        law = self.rng.choice(LAWS)
        k, m, s = (
            self._parameter(low, high) if f"{{{letter}}}" in law else ""
            for letter, low, high in (("k", -2, 1.5), ("m", -2, 1.5), ("s", -0.5, 1.3))
        )
        law = law.format(k=k, m=m, s=s, x=right)
        self.lines.append(f"{name} : R {{ {left} = {law}; }} {where} -> {name};")

    def drawn(self) -> dict[str, float]:
        """Other values of the parameters."""
        return {
            name: 10 ** self.rng.uniform(low, high) * (self.rng.choice((-1, 1)) if signed else 1)
            for name, (low, high, signed) in self.ranges.items()
        }


# Of seeds 0 to 99, those on which the start failed for some parameters before it was searched for.
# Seed 25 is left out: it has flows of 1e32.
SEEDS = (1, 9, 10, 11, 13, 19, 27, 29, 36, 58, 67, 68, 74, 87, 94)


@pytest.mark.parametrize("seed", SEEDS)
def test_networks_of_monotone_laws_start(seed: int, tmp_path: Path) -> None:
    network = Network(seed)
    (tmp_path / "model.bg").write_text(network.text)
    model = bgc.compile(tmp_path / "model.bg", preview=True)
    known = set(model.parameters)
    for _ in range(25):
        parameters = {k: x for k, x in network.drawn().items() if k in known}
        instance = model.instance_at(None, 0.0, parameters)  # BG711 where it fails
        status, rates = instance.rhs()
        _, mass = instance.mass()
        assert status == 0
        _, slopes, _ = instance.jacobian()
        for row in range(len(rates)):
            if not mass[row].any():
                terms = abs(slopes[row]) @ abs(instance.state)
                assert abs(rates[row]) <= 1e-8 * max(terms, 1e-9)


def test_a_start_that_does_not_exist_names_its_loop(tmp_path: Path) -> None:
    """The second loop has to carry 5 through laws that end at 1 each."""
    text = """model M { j : J0; s : Sf(f = 3); a : R { f = sinh(e); } b : R { f = e + e^3; }
      s -> j -> a, b;
      q : J0; d : R { f = tanh(e); } h : R { f = tanh(2*e); } drive : Sf(f = 5); drive -> q -> d, h;
      z : J1; c : C(1); r : R(1); z -> c, r; }
    scene s of M { observe c.q, j.e, q.e; run 1 s; }"""
    (tmp_path / "model.bg").write_text(text)
    diagnostic = refusal(lambda: bgc.compile(tmp_path / "model.bg").observe())
    assert diagnostic.code == "BG711"
    assert "in the algebraic loop through `d` and `h`" in diagnostic.message
