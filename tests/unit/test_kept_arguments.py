"""`use slot = Type(..)` takes over the dimensions and arguments of the type that it replaces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bgc

SPRINGS = """
interface Spring { port p in; }
model Linear[n = 2] is Spring {
  port p in; param k = 100;
  element : C(stiffness = n*k); p -> element;
}
model Cubic[n = 3] is Spring {
  port p in; param k = 10; param k3 = 1e4;
  element : C { e = n*k*q + k3*q^3; } p -> element;
}
model Fixed is Spring { port p in; element : C(stiffness = 7); p -> element; }
model Hung {
  param b = 55;
  spring : Spring = Linear[5](k = b); weight : Se(10); motion : J1; mass : I(1);
  weight -> motion -> mass, spring;
}
model Pair { one : Hung(spring = Linear[4](k = 6)); }
scene plain of Hung { observe spring.element.e, spring.element.q; run 1 s; }
scene cubic is plain { use spring = Cubic(.., k3 = 5); }
scene back is cubic { use spring = Linear(..); }
scene bare is plain { use spring = Fixed(..); }
scene given is plain { use spring = Linear(k = b/5); }
scene again is given { use spring = Cubic[1](..); }
scene pair of Pair {
  use one.spring = Cubic(..); observe one.spring.element.e, one.spring.element.q; run 1 s;
}
"""


def written(folder: Path, text: str = SPRINGS) -> Path:
    path = folder / "springs.bg"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("scene", "stiffness", "cubic"),
    [
        ("plain", 275, 0),
        ("cubic", 275, 5),
        ("back", 275, 0),
        ("bare", 7, 0),
        ("given", 22, 0),
        ("again", 11, 1e4),
        ("pair", 24, 1e4),
    ],
)
def test_a_filling_keeps_what_it_takes(tmp_path, scene, stiffness, cubic):
    """Of all rows, the force is stiffness q + cubic q^3."""
    rows = bgc.compile(written(tmp_path), scene).simulate(error=False)
    force, stretch = (rows[name] for name in rows if name.endswith((".e", ".q")))
    assert np.ptp(stretch) > 0.01
    assert np.allclose(force, stiffness * stretch + cubic * stretch**3, rtol=1e-12)


def test_it_may_be_given_on_the_command_line(tmp_path):
    found = bgc.compile(written(tmp_path), "again", uses={"spring": "Linear(.., k = 3)"})
    rows = found.simulate(error=False)
    assert np.allclose(rows["spring.element.e"], 3 * rows["spring.element.q"], rtol=1e-12)
