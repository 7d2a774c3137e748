"""The cost of compiling grows no faster than the model: counted in nodes and operations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from bgc.algebra.dag import Kind, Level, Op, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.quadratic import Order, minimise, minimise_in_order
from bgc.causality.certificates import Certifier, Size
from bgc.driver import Stages, compile_scene
from bgc.emission import sparse
from bgc.emission.lower import lower
from bgc.equations.storage import constrained_energy
from bgc.equations.variables.definitions import Variables
from bgc.ir.defaults import default_values
from bgc.ir.program import Program
from bgc.options import Options

pytestmark = pytest.mark.slow

SKEW = ("[0.6, 0.8, 0]", "[0, 0.6, -0.8]")


def joints(
    count: int,
    axes: tuple[str, str] = ("y", "z"),
    mount: str = "",
    base: str = "FreeBody(mass = 100 kg, inertia = 50*eye(3))",
) -> str:
    """Bars on rigid joints from a base, with two axes in turn and a mount behind each joint."""
    parts = [
        f"""
  j{k} : Revolute(axis = {axes[k % 2]}, angle0 = {10 + 3 * k} deg, lock = Rigid[5]);
  b{k} : Beam(length = {10 + k} m, mass = {20 - k} kg, side = 0.1 m);"""
        + (f"\n  m{k} : Mount(axes = {mount});" if mount else "")
        for k in range(count)
    ]
    turned = "m{} -> " if mount else ""
    names = " -> ".join(f"j{k} -> {turned.format(k)}b{k}" for k in range(count))
    return f"""
import arms.link;
import crane.beam;
model M {{
  base : {base};
  none : Se[6](e = zeros(6));{"".join(parts)}
  base -> {names} -> none;
}}"""


def mixed_joints(count: int) -> str:
    """Bodies on hinges about an axis of theirs, on hinges about a skew axis, and on slides."""
    kinds = ("Revolute(axis = z", f"Revolute(axis = {SKEW[0]}", "Prismatic(axis = x")
    parts = [
        f"""
  m{k} : Mount(offset = [0.3, 0, 0]);
  j{k} : {kinds[k % 3]}, lock = Rigid[5]);
  n{k} : J1;
  b{k} : HeavyBody(mass = {2 + k} kg, com = [0.1, 0.01, 0.02],
    inertia = symmetric(0.01, 0.001, 0, 0.03, 0, 0.03));
  n{k} -> b{k};"""
        for k in range(count)
    ]
    names = " -> ".join(f"m{k} -> j{k} -> n{k}" for k in range(count))
    return f"""
import arms.link;
model M {{
  ground : Ground;{"".join(parts)}
  ground -> {names};
}}"""


def masses_and_springs(count: int) -> str:
    """A row of masses, a spring between neighbours and to the wall."""
    parts = [
        f"  n{k} : J1; m{k} : I({1 + k % 3} kg); s{k} : C(stiffness = {100 + k} N/m); g{k} : J0;\n"
        f"  n{k} -> m{k}; n{k} -> g{k} -> s{k}; g{k} -> n{k + 1};\n"
        for k in range(count)
    ]
    return f"model M {{\n{''.join(parts)}  n{count} : J1; end : I(1 kg); n{count} -> end;\n}}"


def one_shaft(count: int) -> str:
    """Masses all locked to each other by gears."""
    parts = [
        f"  n{k} : J1; m{k} : I({1 + k % 3} kg); t{k} : TF({'2' if k % 2 else '0.5'});\n"
        f"  n{k} -> m{k}; n{k} -> t{k} -> n{k + 1};\n"
        for k in range(count)
    ]
    return f"model M {{\n{''.join(parts)}  n{count} : J1; end : I(1 kg); n{count} -> end;\n}}"


def ladder(count: int) -> str:
    """Two geared shafts, with a mass on the sum of their flows at each gear."""
    parts = [
        f"  a{k} : J1; p{k} : I(1 kg); u{k} : TF(1.5); b{k} : J1; q{k} : I(2 kg); v{k} : TF(1.5);\n"
        f"  d{k} : J0; c{k} : I(3 kg); a{k} -> p{k}; b{k} -> q{k};\n"
        f"  a{k} -> d{k}; b{k} -> d{k} -> c{k};\n"
        f"  a{k} -> u{k} -> a{k + 1}; b{k} -> v{k} -> b{k + 1};\n"
        for k in range(count)
    ]
    ends = "".join(
        f"  {x}{count} : J1; end{x} : I(1 kg); {x}{count} -> end{x};\n" for x in ("a", "b")
    )
    return f"model M {{\n{''.join(parts)}{ends}}}"


def compiled(tmp_path: Path, text: str) -> Stages:
    path = tmp_path / f"model{len(text)}.bg"
    path.write_text(text)
    return compile_scene(path, Options(), until="optimise")


def operations(program: Program) -> int:
    """Those of the right-hand sides that a state or time moves."""
    dag = program.dag
    nodes = dag.reachable(state.derivative for state in program.states)
    return sum(dag.op[n] > Op.SYMBOL and dag.level[n] > Level.PARAM for n in nodes)


def test_operations_of_rigid_joints_grow_in_proportion(tmp_path: Path) -> None:
    few, many = (compiled(tmp_path, joints(n)) for n in (8, 16))
    assert operations(many.optimised) / operations(few.optimised) < 2.3
    nodes = [len(c.causal.graph.dag) for c in (few, many)]
    assert nodes[1] / nodes[0] < 4, "the DAG grows with the entries of N at most"
    assert nodes[1] < 20 * operations(many.optimised)


def test_operations_of_skew_and_mixed_joints_grow_in_proportion(tmp_path: Path) -> None:
    """Ratios of 3.8 and 4.7 show a row for each pair of bodies."""
    makes: list[Callable[[int], str]] = [partial(joints, axes=SKEW, base="Ground"), mixed_joints]
    for make in makes:
        few, many = (operations(compiled(tmp_path, make(n)).optimised) for n in (7, 14))
        assert many / few < 2.8


@pytest.mark.parametrize("base", ["FreeBody(mass = 100 kg, inertia = 50*eye(3))", "Ground"])
def test_mounts_cost_no_more_than_skew_axes(tmp_path: Path, base: str) -> None:
    """Also mounts that need the rows in sequence; all were refused. A general rotation has more
    entries than a skew axis on a base that stands."""
    skew = compiled(tmp_path, joints(8, SKEW, base=base))
    allowed = 1.2 * operations(skew.optimised)
    for axes, mount in [
        (("z", "z"), "euler_matrix([0.3, -0.7, 1.1])"),
        (("z", "y"), "rot_x(0.3)"),
        (("z", "y"), "rot_y(1.57079632679)"),
    ]:
        found = compiled(tmp_path, joints(8, axes, mount, base))
        assert operations(found.optimised) < allowed


def test_an_arm_along_the_coordinate_axes_costs_no_more_than_a_skew_one(tmp_path: Path) -> None:
    """Quarter turns have zeros and ones, written in eleven digits only zeros of their axis."""
    exact, rounded, skew = (
        operations(compiled(tmp_path, joints(6, axes, mount, "Ground")).optimised)
        for axes, mount in [
            (("z", "y"), "rot_x(90 deg)"),
            (("z", "y"), "rot_x(1.57079632679)"),
            (SKEW, ""),
        ]
    )
    assert exact <= rounded <= skew
    assert exact < skew / 2


@pytest.mark.parametrize("make", [masses_and_springs, one_shaft, ladder])
def test_nodes_grow_in_proportion_to_a_row(tmp_path: Path, make: Callable[[int], str]) -> None:
    few, many = (compiled(tmp_path, make(n)) for n in (20, 100))
    assert [len(c.equations.states) for c in (few, many)] == {
        masses_and_springs: [41, 201],
        one_shaft: [1, 1],
        ladder: [2, 2],
    }[make]
    assert len(many.causal.graph.dag) / len(few.causal.graph.dag) < 5.5
    assert operations(many.optimised) <= 5.5 * operations(few.optimised)


def test_loops_of_resistors_do_not_examine_all_ports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Laws are examined a fixed number of times each; every loop examined those of the graph."""
    examined = []
    laws_of = Variables.laws_of

    def counted(self: Variables, ports: Iterable[int]) -> set[int]:
        examined.extend(given := list(ports))
        return laws_of(self, given)

    monkeypatch.setattr(Variables, "laws_of", counted)
    counts = []
    for size in (10, 40):
        parts = [
            f"n{k} : J0; c{k} : C(1 F); b{k} : J1; r{k} : R(1 ohm); d{k} : J1; s{k} : R(2 ohm);"
            f" m{k} : J0; n{k} -> c{k}; n{k} -> b{k} -> m{k}; b{k} -> r{k}; m{k} -> d{k};"
            f" d{k} -> n{k + 1}; d{k} -> s{k}; g{k} : R(3 ohm); m{k} -> g{k};"
            for k in range(size)
        ]
        text = (
            f"model M {{ {' '.join(parts)} n{size} : J0; c{size} : C(1 F); n{size} -> c{size}; }}"
        )
        examined.clear()
        compiled(tmp_path, text)
        counts.append(len(examined))
    assert counts[0] >= 30
    assert counts[1] < 4.4 * counts[0]


def star(count: int) -> str:
    """Motors, each with a coil, that turn one twisted shaft."""
    parts = [
        f"s{k} : J1; v{k} : Se(e = 24 V); w{k} : I(1 H); r{k} : R(1 ohm); g{k} : GY(2 N*m/A);"
        f" t{k} : J1; m{k} : I(3 kg*m^2); v{k} -> s{k} -> w{k}, r{k};"
        f" s{k} -> g{k} -> t{k} -> m{k}; t{k} -> hub;"
        for k in range(count)
    ]
    hub = "hub : J0; twist : C(stiffness = 1 N*m/rad); b : R(1 N*m*s/rad); hub -> twist, b;"
    return f"model M {{ {hub} {' '.join(parts)} }}"


def test_a_node_of_many_bonds_is_not_examined_after_each_pivot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Entries as pivots, and rows for their fill; both grew with the square of the bonds."""
    sized, counted = [], []
    size_beside, fill_count = Certifier.size_beside, sparse._fill_count

    def size(self: Certifier, node: int, largest: Callable[[], float]) -> Size | None:
        sized.append(node)
        return size_beside(self, node, largest)

    def fill(rows: Sequence[set[int]], columns: Sequence[set[int]], pivot: int) -> tuple[int, int]:
        counted.extend(columns[pivot])
        return fill_count(rows, columns, pivot)

    monkeypatch.setattr(Certifier, "size_beside", size)
    monkeypatch.setattr(sparse, "_fill_count", fill)
    counts = []
    for count in (80, 240):
        sized.clear()
        counted.clear()
        lower(compiled(tmp_path, star(count)).optimised)
        counts.append((len(sized), len(counted)))
    assert min(counts[0]) >= 80
    assert all(many < 4 * few for few, many in zip(*counts, strict=True)), counts


def test_a_field_has_nodes_in_proportion_to_its_matrix(tmp_path: Path) -> None:
    """Its inverse is left to the start of a run; spelled out, the nodes grew 6.1 times."""
    few, many = (
        compiled(
            tmp_path,
            f"model M {{ param a = 0.5; param M = eye({n}) + a*outer(ones({n}), ones({n}));"
            f" all : J1[{n}]; coils : I[{n}](M); loss : R[{n}](1); all -> coils, loss; }}",
        )
        for n in (12, 24)
    )
    assert len(few.optimised.states) == 12
    assert len(many.optimised.dag) < 4.3 * len(few.optimised.dag)


def derivatives(program: Program) -> np.ndarray:
    """The right-hand sides at a fixed state, all parameters at their defaults."""
    values = dict(default_values(program.dag, program.parameters))
    values[Symbol(Kind.TIME, 0)] = 0.3
    rng = np.random.default_rng(5)
    for k in range(len(program.states)):
        values[Symbol(Kind.STATE, k)] = float(rng.uniform(-1, 1))
    nodes = [state.derivative for state in program.states]
    return np.array(evaluate_nodes(program.dag, nodes, values))


def test_the_factored_and_the_merged_form_agree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also shows that the cheaper one is taken."""
    programs = {}
    for name, order in {
        "either": minimise,
        "factored": partial(minimise_in_order, order=Order.NARROW),
        "merged": partial(minimise_in_order, order=Order.SUBSTITUTIONS_FIRST),
    }.items():
        monkeypatch.setattr(constrained_energy, "minimise", order)
        programs[name] = compiled(tmp_path, joints(5)).optimised
    expected = derivatives(programs["merged"])
    size = np.abs(expected).max()
    np.testing.assert_allclose(
        derivatives(programs["factored"]) / size, expected / size, atol=1e-12
    )
    counts = {name: operations(program) for name, program in programs.items()}
    assert counts["either"] == min(counts.values()) < max(counts.values())
