"""Chains and trees of rigid links as scenes, and their compilation with speeds solved for in f."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from bgc.driver import compile_scene
from bgc.emission import implicit_speeds, least_cost
from bgc.ir.lowered import Jacobian, Lowered
from bgc.ir.program import Program
from bgc.options import Options
from bgc.resolution.resolve import load_text

Parent = Callable[[int], int]


def serial(k: int) -> int:
    """Each link on the one before."""
    return k - 1


def binary(k: int) -> int:
    """Two links on each one."""
    return (k - 1) // 2 if k else -1


def chain(bodies: int, parent: Parent = serial, base: str = "ground : Ground;") -> str:
    """Links with offset centres of mass, the third of each three on a slide, the second skew.

    Joints are damped; every second one has a spring. `base` declares the part `ground`.
    """
    lines = ["import arms.link;", "", "model Chain {", f"  {base}"]
    for k in range(bodies):
        before, size = ("ground", 0.1) if parent(k) < 0 else (f"node{parent(k)}", 0.3)
        angle = f"angle0 = {0.3 + 0.05 * k:.2f} rad"
        kind = [
            f"PoweredRevolute(axis = z, {angle}",
            f"PoweredRevolute(axis = [1, {k % 5 - 2}, 2]/norm([1, {k % 5 - 2}, 2]), {angle}",
            "PoweredPrismatic(axis = y, extension0 = 0.1 m",
        ][k % 3]
        damping = "0.5 N*s/m" if k % 3 == 2 else "0.5 N*m*s"
        lines += [
            f"  param mass{k} : kg = {2 + 0.1 * (k % 5):.1f};",
            f"  mount{k} : Mount(offset = [{size} m, 0, 0.1 m]);",
            f"  joint{k} : {kind}, rate0 = {(-1) ** k * 0.2}, friction = {damping},",
            "    lock = Rigid[5]);",
            f"  node{k} : J1;",
            f"  body{k} : HeavyBody(mass = mass{k}, com = [0.15 m, 0.01 m, 0.02 m],",
            "    inertia = symmetric(0.01, 0.001, 0, 0.03, 0, 0.03));",
            f"  spring{k} : C({0.05 if k % 2 else 0.02});",
            f"  {before} -> mount{k} -> joint{k} -> node{k} -> body{k};",
            f"  joint{k}.{'rod' if k % 3 == 2 else 'shaft'} -> spring{k};",
        ]
    lines += [
        "}",
        "",
        "scene hang of Chain {",
        f"  observe joint{bodies - 1}.free.f as last, joint0.free.f as first;",
        "  observe energy.residual as residual, energy.stored as stored;",
        "  run 0.2 s every 0.05 s;",
        "}",
    ]
    return "\n".join(lines) + "\n"


def arm_of_boxes(bodies: int, slides: bool = False) -> str:
    """An arm of equal links on joints about z, y, x in turn; every second one can be a slide."""
    lines = ["import arms.link;", "", "model Boxes {", "  ground : Ground;"]
    for k in range(bodies):
        before = f"node{k - 1}" if k else "ground"
        kind, start, unit = ("Revolute", "angle0 = 0.3 rad", "N*m*s")
        if slides and k % 2:
            kind, start, unit = ("Prismatic", "extension0 = 0.1 m", "N*s/m")
        lines += [
            f"  mount{k} : Mount(offset = [0.3 m, 0, 0]);",
            f"  joint{k} : {kind}(axis = {'zyx'[k % 3]}, {start}, lock = Rigid[5],",
            f"    friction = 0.5 {unit});",
            f"  node{k} : J1;",
            f"  body{k} : HeavyBody(mass = 2 kg, com = [0.15 m, 0.01 m, 0.02 m],",
            "    inertia = symmetric(0.01, 0.001, 0, 0.03, 0, 0.03));",
            f"  {before} -> mount{k} -> joint{k} -> node{k} -> body{k};",
        ]
    last = f"joint{bodies - 1}.free.f"
    return "\n".join([*lines, "}", "", f"scene hang of Boxes {{ observe {last} as v; }}"]) + "\n"


def lowered(source: str) -> Lowered:
    """The lowered program of a text."""
    package = load_text(source, "chain.bg")
    return compile_scene(Path("chain.bg"), Options(), package=package, until="lower").lowered


def elimination_products(source: str) -> int:
    """The products of J and its factorisation in the order with kept vertices."""
    package = load_text(source, "chain.bg")
    found = compile_scene(Path("chain.bg"), Options(), package=package, until="optimise")
    forms = implicit_speeds.implicit_forms(found.optimised)
    assert forms is not None
    kept = forms.order()
    assert kept is not None
    return kept.order.products


@contextmanager
def solved_in_f() -> Iterator[None]:
    """Compile without inner unknowns."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(least_cost, "implicit_forms", lambda program: None)
        yield


def _with_kept_vertices(
    forms: implicit_speeds.ImplicitForms, most: int | None = None
) -> tuple[Program, Jacobian]:
    kept = forms.order()
    assert kept is not None
    return forms.with_kept_vertices(kept)


@contextmanager
def kept_vertices() -> Iterator[None]:
    """Compile with intermediate values as inner unknowns, whatever they cost."""
    with pytest.MonkeyPatch.context() as patch:
        forms = implicit_speeds.ImplicitForms
        patch.setattr(forms, "accumulated", _with_kept_vertices)
        patch.setattr(least_cost, "_GAIN", 1e9)
        patch.setattr(least_cost, "_COMPARED_OPERATIONS", -1)
        patch.setattr(implicit_speeds, "_SETTINGS", ((-5, -5),))  # accumulate few
        yield


def operations(found: Lowered) -> int:
    """The operations of J, one factorisation and six solutions."""
    return least_cost._cost((found.program, (), found.jacobian, (), found.plan))
