"""Every place that holds a node is known to the passes that move a program to another graph."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest

from bgc.algebra.dag import Dag
from bgc.driver import compile_scene
from bgc.ir.fields import map_nodes
from bgc.options import Options

MODELS = Path(__file__).parents[1] / "models"
MOVED = 10**9  # no graph has so many nodes
SCENES = [("rigid_chain", None), ("vessel_at_rest", "rolling_euler"), ("handle", None),
          ("balance", None), ("duffing", None), ("typologies", None)]  # fmt: skip


def nodes_in(value: Any, annotation: str) -> Iterator[int]:
    """The nodes in a value, told by how its field is annotated."""
    if is_dataclass(value):
        for field in fields(value):
            yield from nodes_in(getattr(value, field.name), str(field.type))
    elif isinstance(value, tuple):
        for item in value:
            yield from nodes_in(item, annotation)
    elif isinstance(value, int) and ("Node" in annotation or "Matrix" in annotation):
        yield value


EVERYTHING = """
model All {
  param a = 2;
  push : Se[2](e = [a, a*time]);
  hub : J1; body : I[2](a); spin : MGY[2] { e = [[0, -body.p[1]], [body.p[1], 0]]*f; }
  turn : MTF { f2 = [[cos(y), -sin(y)], [sin(y), cos(y)]]*f1;
               f1 = [[cos(y), sin(y)], [-sin(y), cos(y)]]*f2; }
  far : J1; spring : C[2] { H = a*(q[1]^2 + q[2]^2)/2; } loss : R[2] { e = a*f; }
  push -> hub -> body, spin; hub -> turn -> far -> spring, loss;
  state y = a; der(y) = -y; project y = a*y/a;
  unknown z = a; equation z^3 + z = y;
  assert y < 100*a, "too far";
}
scene s of All { observe body.f as v, z; keep y; require body.f within 1e-3; run 1 s; }
"""


@pytest.fixture(scope="module")
def everything(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("nodes") / "all.bg"
    path.write_text(EVERYTHING)
    return path


@pytest.mark.parametrize(("name", "scene"), [("", None), *SCENES])
def test_all_nodes_are_moved(name: str, scene: str | None, everything: Path) -> None:
    path = MODELS / f"{name}.bg" if name else everything
    stages = compile_scene(path, Options(scene), until="slice")
    for holder in (stages.graph, stages.sliced):
        before = list(nodes_in(holder, ""))
        after = list(nodes_in(map_nodes(holder, Dag(), lambda n: n + MOVED), ""))  # type: ignore[operator]
        assert before and after == [n + MOVED for n in before]
