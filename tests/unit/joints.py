"""Planar bodies joined by revolute joints, rigid or compliant, the carrier drawn either way."""

from __future__ import annotations

from graphs import GraphBuilder

from bgc.algebra.dag import Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.rotations import known_inverse
from bgc.ir.graph import Form, Node


def chain_of_bodies(count: int, *, rigid: bool, reverse: bool) -> GraphBuilder:
    """Bodies with offset centres of mass and gyroscopic terms, driven at each joint.

    The twist of a body is (vx, vy, w) in its own axes; the joint sits 2 m along its x axis.
    """
    g = GraphBuilder()
    angles = [g.state(f"angle{k}", 0.3) for k in range(count - 1)]
    for k in range(count):
        _body(g, f"body{k}")
    for k, angle in enumerate(angles):
        _joint(g, k, angle, rigid=rigid, reverse=reverse)
    return g


def _body(g: GraphBuilder, name: str) -> None:
    g.storage("I", name, [[3, 0, 0], [0, 3, 1], [0, 1, 2]], Form.MOMENTUM)
    x, y = g.p(name, 0), g.p(name, 1)
    zero = g.dag.zero
    turn = ((zero, zero, g.dag.neg(y)), (zero, zero, x), (y, g.dag.neg(x), zero))
    g.gyristor(f"{name}.turn", turn)
    for i in range(3):
        g.junction("J1", f"{name}.{i}")
        g.bond(f"{name}.{i}", name)
        g.bond(f"{name}.{i}", f"{name}.turn")


def _joint(g: GraphBuilder, k: int, angle: Node, *, rigid: bool, reverse: bool) -> None:
    dag = g.dag
    s, c = dag.call(Op.SIN, angle), dag.call(Op.COS, angle)
    zero, arm = dag.zero, g.node(2)
    carry = (
        (c, s, dag.mul(s, arm)),
        (dag.neg(s), c, dag.mul(c, arm)),
        (zero, zero, dag.one),
    )
    if reverse:
        back = known_inverse(dag, Fingerprints(dag), carry)
        assert back is not None
        carry = back.matrix
    g.transformer(f"carry{k}", carry)
    sides = [[f"body{k}.{i}" for i in range(3)], [f"gap{k}.{i}" for i in range(3)]]
    for i in range(3):
        g.junction("J0", f"gap{k}.{i}")
        g.junction("J1", f"slip{k}.{i}")
    for tail in sides[reverse]:
        g.bond(tail, f"carry{k}")
    for head in sides[not reverse]:
        g.bond(f"carry{k}", head)
    for i in range(3):
        g.bond(f"gap{k}.{i}", f"body{k + 1}.{i}")
        slip = g.bond(f"slip{k}.{i}", f"gap{k}.{i}")
        if i == 2:
            g.source("Se", f"drive{k}", g.node(1))
            g.bond(f"drive{k}", f"slip{k}.{i}")
            g.derivative(angle, g.flow(slip))
        elif rigid:
            g.source("Sf", f"lock{k}.{i}", zero)
            g.bond(f"lock{k}.{i}", f"slip{k}.{i}")
        else:
            g.storage("C", f"spring{k}.{i}", [[1000]], Form.EFFORT)
            g.resistor(f"damper{k}.{i}", 2)
            g.fan(f"slip{k}.{i}", f"spring{k}.{i}", f"damper{k}.{i}")
