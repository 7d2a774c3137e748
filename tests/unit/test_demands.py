"""Definitions and parts that lead to each other along long chains, within Python's own stack."""

from __future__ import annotations

import sys
from collections.abc import Callable

import pytest

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.elaboration.elaborate import elaborate
from bgc.ir.graph import FlatGraph
from bgc.resolution.resolve import load_text

LENGTH = 2000  # twice as deep as Python's stack, at one frame each
BONDS = "s : Se(e = a0); r : R(1); s -> r;"
WIDE = "w : Se(e = [1, 2]); n : J1; r : R(1); c : C(1); w -> n -> c, r;"
PART = "model Part[n] { let size = n + 1; s : Se(e = n); r : R(1); s -> r; }"


def model(lines: list[str], rest: str = BONDS) -> FlatGraph:
    return elaborate(load_text("model M {" + "\n".join([*lines, rest]) + "}"))


def problems(lines: list[str], rest: str = BONDS) -> list[Diagnostic]:
    with pytest.raises(BgError) as caught:
        model(lines, rest)
    return list(caught.value.diagnostics)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["let", "const", "param", "output"])
def test_a_chain_of_definitions_in_any_order(kind: str) -> None:
    chain = [f"{kind} a{k} = a{k + 1} + 1;" for k in range(LENGTH)]
    flat = model([*chain, f"{kind} a{LENGTH} = 1; output y = a0;"])
    before = sys.getrecursionlimit()
    backwards = model([*reversed([*chain, f"{kind} a{LENGTH} = 1;"]), "output y = a0;"])
    assert sys.getrecursionlimit() == before
    if kind in {"let", "const"}:
        for each in (flat, backwards):
            (y,) = [o for o in each.observations if o.name == "y"]
            assert each.dag.value(y.node) == LENGTH + 1
    else:
        assert len(flat.parameters) == len(backwards.parameters)


def test_a_chain_of_constants_through_functions() -> None:
    chain = [f"function f{k}(x) = x + a{k + 1}; const a{k} = f{k}(1);" for k in range(1000)]
    text = "\n".join([*chain, f"const a1000 = 1; model M {{ {BONDS} output y = a0; }}"])
    flat = elaborate(load_text(text))
    (y,) = [o for o in flat.observations if o.name == "y"]
    assert flat.dag.value(y.node) == 1001


def test_a_chain_of_parts_in_any_order() -> None:
    count = 500
    parts = [f"x{k} : Part[x{k + 1}.size];" for k in range(count)]
    lines = "\n".join([*parts, f"x{count} : Part[1]; let a0 = x0.size; {BONDS} output y = a0;"])
    flat = elaborate(load_text(f"{PART} model M {{ {lines} }}"))
    (y,) = [o for o in flat.observations if o.name == "y"]
    assert flat.dag.value(y.node) == count + 2
    assert len(flat.elements) == 2 * count + 4


def test_what_a_wrong_value_leads_to_is_reported_once() -> None:
    chain = [f"let a{k} = a{k + 1} + 1;" for k in range(LENGTH)]
    (problem,) = problems([*chain, f"let a{LENGTH} = [1, 2] + [1, 2, 3];"])
    assert problem.code == "BG310"


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, LENGTH // 2])
def test_a_long_cycle_is_named_whole(first: int) -> None:
    chain = [f"let a{k} = a{k + 1} + 1;" for k in range(LENGTH)]
    (problem,) = problems([*chain, f"let a{LENGTH} = a{first} + 1;"])
    assert problem.code == "BG214"
    assert f"a{first} -> a{first + 1} -> " in problem.message
    assert problem.message.endswith(f" -> a{LENGTH} -> a{first}")
    assert problem.message.count("->") == LENGTH - first + 1


def test_parts_that_need_each_other_are_reported() -> None:
    lines = [f"x{k} : Part[x{(k + 1) % 300}.size];" for k in range(300)]
    with pytest.raises(BgError) as caught:
        elaborate(load_text(f"{PART} model M {{ {' '.join(lines)} let a0 = 1; {BONDS} }}"))
    assert {d.code for d in caught.value.diagnostics} == {"BG214"}


def test_a_width_that_is_not_known_yet_is_asked_for_again() -> None:
    """The width of `g` is that of `w`, which is read later, through a chain of values."""
    chain = [f"let a{k} = a{k + 1}*2;" for k in range(200)]
    flat = model([*chain, "let a200 = c.e;"], "g : MSe(e = a0); h : R(1); g -> h; " + WIDE)
    bonds = [bond for bond in flat.bonds if bond.name.startswith("g -> h")]
    assert len(bonds) == 2


NESTED: dict[str, Callable[[int], str]] = {
    "signs": lambda depth: "-" * depth + "time",
    "indices": lambda depth: "v[" * (depth // 2) + "1" + "]" * (depth // 2),
    "powers": lambda depth: "^".join(["time"] * (depth // 2)),
    "calls": lambda depth: "sin(" * (depth // 2) + "time" + ")" * (depth // 2),
    "branches": lambda depth: "if time > 1 then 2 else " * depth + "3",
    "sum": lambda depth: " + ".join(["time"] * depth),
}


@pytest.mark.parametrize("kind", NESTED)
@pytest.mark.parametrize("depth", [100, 150, 160, 190, 400, 20_000])
def test_deep_expressions_are_read_or_refused(kind: str, depth: int) -> None:
    """Also where the caller has used a fourth of the stack."""

    def from_depth(frames: int) -> set[str]:
        if frames:
            return from_depth(frames - 1)
        try:
            model([f"let v = [1, 1]; let a0 = {NESTED[kind](depth)};"])
        except BgError as error:
            return {d.code for d in error.diagnostics}
        return set()

    found = from_depth(200)
    assert found <= {"BG118", "BG120", "BG318"}
    if depth == 100:
        assert found == set()
    if depth > 200 and (kind != "sum" or depth > 5_000):  # sums of any length are read
        assert found
