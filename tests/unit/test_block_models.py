"""Models whose matrix is factorised in blocks of rows: the same results as by tables of entries."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import Floats

import bgc
from bgc.building.build import build_shared_object
from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain
from bgc.driver import compile_scene
from bgc.emission import print_lu
from bgc.emission.blocks import plan_blocks
from bgc.emission.emit import emit_lowered
from bgc.emission.operation_cost import cost_of
from bgc.emission.sparse import entries_of_matrix
from bgc.ir.lowered import BlockPlan, Lowered
from bgc.options import Options
from bgc.runtime.running.binding import Instance, Library
from bgc.runtime.running.structures import OptionsStruct, Status

MODELS = Path(__file__).parents[1] / "models"
BENCH = Path(__file__).parents[1] / "bench"
NODES = 60


def lowered_scene(path: Path, scene: str | None = None) -> Lowered:
    return compile_scene(path, Options(scene=scene), until="lower").lowered


def in_blocks(lowered: Lowered) -> BlockPlan:
    return plan_blocks(lowered.plan, entries_of_matrix(lowered.program, lowered.jacobian))


def library(lowered: Lowered, blocks: BlockPlan | None) -> Library:
    """The model with these blocks; without blocks by tables."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(print_lu, "UNROLLED", 0)
        units = emit_lowered(replace(lowered, blocks=blocks), "").units
    return Library(build_shared_object(units, find_toolchain(), open_cache()))


def rows_of(
    model: Library, times: Floats, options: OptionsStruct, parameters: tuple[float, ...] = ()
) -> tuple[Floats, dict[str, float]]:
    """The rows of a run, with the accounts of energy, and its counts."""
    instance = Instance(model)
    for index, value in enumerate(parameters):
        instance.set_parameter(index, value)
    options.accounts = 1
    assert instance.set_options(options) is Status.OK
    assert instance.reset() is Status.OK
    rows = np.full((len(times), model.model.n_output + 4), np.nan)
    status, _ = instance.run(times, rows)
    assert status is Status.OK
    return rows, instance.counts


def circuit() -> str:
    """Nodes with capacitors, coils between neighbours and to some nodes before."""
    lines = ["model Circuit { drive : Se(e = sin(2*time)); entry : J1; feed : R(1);"]
    lines.append("drive -> entry -> feed; entry -> n0;")
    for k in range(NODES):
        lines.append(f"n{k} : J0; c{k} : C({1 + k % 3}); n{k} -> c{k};")
    edges = [(k - 1, k) for k in range(1, NODES)] + [(k - 7, k) for k in range(7, NODES, 3)]
    for e, (a, b) in enumerate(edges):
        lines.append(f"e{e} : J1; l{e} : I({1 + e % 5}); r{e} : R(0.1);")
        lines.append(f"n{a} -> e{e} -> l{e}, r{e}, n{b};")
    lines.append(f"}} scene circuit of Circuit {{ observe c{NODES - 1}.e as last; run 1 s; }}")
    return "\n".join(lines)


def test_a_chain_of_bodies_and_a_circuit_give_the_same_by_tables_and_by_blocks(
    tmp_path: Path,
) -> None:
    (tmp_path / "circuit.bg").write_text(circuit(), "utf-8")
    for model in (
        lowered_scene(MODELS / "boom_of_beams.bg", "long"),  # 16 bodies
        lowered_scene(tmp_path / "circuit.bg"),
    ):
        blocks = in_blocks(model)
        assert len(blocks.sizes) < len(blocks.rows) / 2
        ways = library(model, None), library(model, blocks)
        assert not any(way.model.factor for way in ways)
        assert [bool(way.model.lu_row) for way in ways] == [True, False]
        for method, step in (("rodas5p", 1e-2), ("radau5", 1e-2)):
            times = np.linspace(0.0, 0.5, 6)
            options = OptionsStruct(name=method.encode(), step=step, max_step=step, rtol=1e-3)
            (tables, ours), (found, counts) = (rows_of(way, times, options) for way in ways)
            scale = np.abs(tables).max(axis=0)
            assert (np.abs(found - tables) <= 1e-9 * scale + 1e-15).all()
            assert counts["factorisations"] == ours["factorisations"] > 10
            for each in (ours, counts):
                assert each["refinements"] == each["fallbacks"] == 0


def test_inner_unknowns_are_eliminated_in_blocks() -> None:
    """The speeds of a rigid crane are unknowns beside its states; M has no rows of them."""
    model = lowered_scene(BENCH / "crane.bg", "reduced")
    assert model.jacobian.inner > 0 and model.program.mass is None
    times = np.linspace(0.0, 1.0, 6)
    ways = library(model, None), library(model, in_blocks(model))
    instance = Instance(ways[0])
    assert instance.reset() is Status.OK
    check_jacobian(instance)
    for method in (b"rodas5p", b"radau5"):
        options = OptionsStruct(name=method, step=1e-2, max_step=1e-2, rtol=1e-3)
        (tables, _), (found, counts) = (rows_of(way, times, options) for way in ways)
        scale = np.abs(tables).max(axis=0)
        assert (np.abs(found - tables) <= 1e-9 * scale + 1e-15).all()
        assert counts["factorisations"] > 10
        assert counts["refinements"] == counts["fallbacks"] == 0


def check_jacobian(instance: Instance) -> None:
    """Compare the Jacobian with central differences of f."""
    x = instance.state.copy()
    status, jacobian, _ = instance.jacobian()
    assert status is Status.OK
    steps = 1e-5 * (instance.scale + np.abs(x))
    for k, step in enumerate(steps):
        found = []
        for sign in (1, -1):
            instance.state[:] = x
            instance.state[k] += sign * step
            found.append(instance.rhs()[1])
        slope = (found[0] - found[1]) / (2 * step)
        np.testing.assert_allclose(jacobian[:, k], slope, atol=1e-6 * np.abs(slope).max() + 1e-9)
    instance.state[:] = x


def test_algebraic_equations_are_solved_in_blocks() -> None:
    model = lowered_scene(MODELS / "ivp" / "chemical_akzo.bg")
    assert model.program.mass is not None
    times = np.array([180.0])
    for method in (b"rodas5p", b"radau5"):
        ways = library(model, None), library(model, in_blocks(model))
        options = OptionsStruct(name=method, rtol=1e-8, atol=1e-10)
        (tables, _), (found, counts) = (rows_of(way, times, options) for way in ways)
        np.testing.assert_allclose(found[:, :6], tables[:, :6], rtol=1e-7)
        assert counts["fallbacks"] == 0


ENTRIES = [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0), (1.0, 1e-14)]


@pytest.mark.parametrize("method", ["rodas5p", "radau5"])
def test_pivots_that_vanish_are_exchanged_in_a_block_and_else_end_in_dense_factors(
    method: str,
) -> None:
    """Whatever the order of static pivots, one of them vanishes at some of these parameters."""
    model = lowered_scene(MODELS / "pivots.bg")
    plan, size = model.plan, len(model.plan.rows)
    apart = BlockPlan(plan.rows, plan.columns, (1,) * size, plan.lower, plan.upper)
    together = BlockPlan(plan.rows, plan.columns, (size,), ((),), ((),))
    times = np.linspace(0.0, 2.0, 5)
    for blocks, falls_back in ((apart, True), (together, False)):
        fallbacks = 0.0
        made = library(model, blocks)
        for entries in ENTRIES:
            options = OptionsStruct(name=method.encode(), rtol=1e-8, atol=1e-10, max_steps=10_000)
            rows, counts = rows_of(made, times, options, entries)
            assert np.abs(rows[:, 0] - np.exp(-times)).max() < 1e-6
            fallbacks += counts["fallbacks"]
        assert (fallbacks > 0) == falls_back


def test_batches_use_unrolled_code_where_single_instances_use_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lanes of models whose unrolled code is not too long: `bgc_lanes.h` has no blocks."""
    source = tmp_path / "line.bg"
    source.write_text(
        "model Line { param k = 2; wall : Sf(f = 0); pull : Se(e = sin(time));"
        " for i in 1..6 { hub[i] : J1; mass[i] : I(1 + i/10); gap[i] : J0;"
        " spring[i] : C(stiffness = k);"
        " drag[i] : R(0.3); hub[i] -> mass[i], drag[i]; gap[i] -> spring[i], hub[i]; }"
        " for i in 2..6 { hub[i-1] -> gap[i]; } wall -> gap[1]; pull -> hub[6]; }"
        "scene line of Line { observe spring[1].q as q; run 2 s every 0.5 s; }",
        "utf-8",
    )
    monkeypatch.setattr("bgc.emission.lower.choose_blocks", plan_blocks)
    model = bgc.compile(source)
    assert not model.library.model.factor and not model.library.model.lu_row
    stiffnesses = np.linspace(1.0, 4.0, 16)
    ensemble = model.simulate_many({"k": stiffnesses}, solver="ros34prw", step=0.01)
    assert ensemble.alone == ""
    for k in (0, 7, 15):
        alone = model.simulate(parameters={"k": stiffnesses[k]}, solver="ros34prw", step=0.01)
        np.testing.assert_allclose(ensemble["q"][k], alone["q"], rtol=1e-9, atol=1e-12)


def test_the_cost_of_a_scene_says_how_its_matrix_is_factorised(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = lowered_scene(MODELS / "pivots.bg")
    blocks = in_blocks(model)
    count = len(blocks.sizes)
    assert cost_of(model).factors == "unrolled code"
    assert cost_of(replace(model, blocks=blocks)).factors == f"{count} blocks of rows"
    monkeypatch.setattr(print_lu, "UNROLLED", 0)
    assert cost_of(model).factors == "tables of entries"
