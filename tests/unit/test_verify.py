"""The invariants of intermediate results: each broken one is found."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bgc.algebra.dag import Kind
from bgc.driver import Stages, compile_scene
from bgc.ir.lowered import BlockPlan, LuPlan, Store
from bgc.ir.program import MassEntry
from bgc.ir.verify import BrokenInvariant, verify
from bgc.options import Options

MODELS = Path(__file__).parents[1] / "models"


@pytest.fixture(scope="module")
def stages() -> Stages:
    return compile_scene(MODELS / "dc_motor.bg", Options(), until="lower")


def test_sound_results_pass(stages):
    for result in (stages.graph, stages.causal, stages.equations, stages.optimised, stages.lowered):
        verify(result)


def with_first(items: tuple[Any, ...], **changes: Any) -> tuple[Any, ...]:
    return (replace(items[0], **changes), *items[1:])


def one_block(plan: LuPlan, **changes: Any) -> BlockPlan:
    """All pivots of a plan in one block."""
    return replace(BlockPlan(plan.rows, plan.columns, (len(plan.rows),), ((),), ((),)), **changes)


GRAPH: dict[str, Callable[[Any], Any]] = {
    "bond 0 has the index 1": lambda g: replace(g, bonds=with_first(g.bonds, index=1)),
    "other ends": lambda g: replace(g, elements=g.elements[1:]),
    "EFFORT 999 is not a symbol": lambda g: replace(
        g, observations=with_first(g.observations, node=g.dag.symbol(Kind.EFFORT, 999))
    ),
    "the default of": lambda g: replace(
        g, parameters=with_first(g.parameters, value=g.dag.symbol(Kind.TIME, 0))
    ),
    "a column is not observed": lambda g: replace(g, observations=g.observations[1:]),
}
CAUSAL: dict[str, Callable[[Any], Any]] = {
    "`strokes` has": lambda c: replace(c, strokes=c.strokes[1:]),
    "does not fit": lambda c: replace(c, class_of=c.class_of[::-1]),
    "no row of N": lambda c: replace(c, flows=c.flows[1:]),
    "eliminated or in the basis": lambda c: replace(c, steps=c.steps[1:]),
    "its own row of N": lambda c: replace(c, flows=((),) * len(c.flows)),
    "`rows` has 2 rows, none is 999": lambda c: replace(c, redundant=frozenset({999})),
}
PROGRAM: dict[str, Callable[[Any], Any]] = {
    "two states are called": lambda p: replace(
        p, states=with_first(p.states, name=p.states[1].name)
    ),
    "FLOW 0 is not a symbol": lambda p: replace(
        p, states=with_first(p.states, derivative=p.dag.symbol(Kind.FLOW, 0))
    ),
    "starts at a state": lambda p: replace(
        p, states=with_first(p.states, initial=p.dag.symbol(Kind.STATE, 1))
    ),
    "the scale of": lambda p: replace(
        p, states=with_first(p.states, scale=p.dag.symbol(Kind.TIME, 0))
    ),
    "`states` has 2 rows, none is 999": lambda p: replace(p, mass=(MassEntry(0, 999, p.dag.one),)),
}
LOWERED: dict[str, Callable[[Any], Any]] = {
    "not sorted": lambda w: replace(
        w,
        jacobian=replace(w.jacobian, rows=w.jacobian.rows[::-1], columns=w.jacobian.columns[::-1]),
    ),
    "another number of rows": lambda w: replace(w, jacobian=replace(w.jacobian, by_time=())),
    "not a permutation": lambda w: replace(w, plan=replace(w.plan, rows=(0,) * len(w.plan.rows))),
    "another number of pivots": lambda w: replace(w, blocks=one_block(w.plan, sizes=(1,))),
    "too large": lambda w: replace(w, blocks=one_block(w.plan, sizes=(0, len(w.plan.rows)))),
    "wrong side of it": lambda w: replace(w, blocks=one_block(w.plan, right=((0,),))),
    "other pivots": lambda w: replace(w, blocks=one_block(w.plan, rows=w.plan.rows[::-1])),
    "a varying node": lambda w: replace(w, hoisted=(w.program.states[0].derivative,)),
    "twice": lambda w: replace(
        w, kernels=with_first(w.kernels, stores=(*w.kernels[0].stores, *w.kernels[0].stores))
    ),
    "another array": lambda w: replace(w, kernels=with_first(w.kernels, results=())),
    "a gap in w": lambda w: replace(
        w, kernels=with_first(w.kernels, stores=(Store("w", 1, w.program.dag.one),))
    ),
    "no kernel leaves in w": lambda w: replace(
        w, kernels=with_first(w.kernels, found=(w.program.dag.one,))
    ),
}


@pytest.mark.parametrize(
    ("stage", "message", "broken"),
    [
        (stage, message, broken)
        for stage, cases in (
            ("graph", GRAPH), ("causal", CAUSAL), ("optimised", PROGRAM), ("lowered", LOWERED)
        )
        for message, broken in cases.items()
    ],
)  # fmt: skip
def test_a_broken_invariant_is_found(stages, stage, message, broken):
    with pytest.raises(BrokenInvariant, match=message):
        verify(broken(getattr(stages, stage)))


def test_compiling_verifies_where_it_is_asked_to(monkeypatch):
    found = []
    monkeypatch.setattr("bgc.ir.verify.verify", found.append)
    monkeypatch.delenv("BGC_VERIFY")
    compile_scene(MODELS / "dc_motor.bg", Options(), until="optimise")
    assert not found
    compile_scene(MODELS / "dc_motor.bg", Options(verify=True), until="optimise")
    names = [type(result).__name__ for result in found if not isinstance(result, tuple)]
    assert names == ["Package", "FlatGraph", "Folding", "CausalGraph", *["Program"] * 3]
