"""Inverses that a run computes when parameters are set: their places in h, and the kernel for them.

The entries of each inverse are consecutive elements of h. `prepare` stores the matrix there, calls
`bgc_invert` of `bgc_inverse.h`, and then computes all that depends on the inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isqrt

from bgc.algebra.dag import Dag, Op
from bgc.emission.kernels import KernelText, print_kernel
from bgc.emission.print_steps import print_steps
from bgc.ir.graph import Node
from bgc.ir.lowered import Kernel, Store

_LONG = 200  # nodes of parameters alone from which they are computed by a table of operations


def with_inverses(dag: Dag, hoisted: Sequence[Node]) -> tuple[Node, ...]:
    """Append all entries of the inverses that hoisted nodes need, in their order of computation."""
    lists = dict.fromkeys(dag.a[n] for n in dag.reachable(hoisted) if dag.op[n] == Op.INVERTED)
    entries = [node for listed in lists for node in _entries_of(dag, listed)]
    own = set(entries)
    return (*(node for node in hoisted if node not in own), *entries)


def _entries_of(dag: Dag, listed: Node) -> list[Node]:
    places = range(len(dag.listed(listed)))
    return [dag.call(Op.INVERTED, listed, dag.const(place)) for place in places]


def print_prepare(dag: Dag, kernel: Kernel, hoisted: dict[Node, int]) -> KernelText:
    """Print the kernel `prepare`, whose stores of inverses become calls."""
    inverses = {node: k for node, k in hoisted.items() if dag.op[node] == Op.INVERTED}
    if not inverses:
        return _printed(dag, kernel, {})
    parts, calls, work = list[KernelText](), list[str](), 0
    products = 0
    for listed in dict.fromkeys(dag.a[node] for node in inverses):
        first, entries = hoisted[_entries_of(dag, listed)[0]], dag.listed(listed)
        size, number = isqrt(len(entries)), len(parts) + 1
        matrix = replace(
            kernel,
            name=f"matrix_{number}",
            purpose=f"Matrix {number} of parameters, which is inverted in its place.",
            stores=tuple(Store("h", first + k, node) for k, node in enumerate(entries)),
        )
        parts.append(_printed(dag, matrix, inverses))
        calls += [f"model_{matrix.name}(p, h, w);", f"bgc_invert(h + {first}, {size}, w);"]
        work = max(work, size * (size + 2))
        products += size**3
    stores = tuple(store for store in kernel.stores if store.node not in inverses)
    if stores:
        rest = replace(kernel, name="prepared", stores=stores,
                       purpose="What depends on parameters and on inverses.")  # fmt: skip
        parts.append(_printed(dag, rest, inverses))
        calls.append("model_prepared(p, h, w);")
    body = "".join(f"    {call}\n" for call in calls)
    whole = f"/* {kernel.purpose} */\n{_head(kernel)}\n{{\n{body}}}\n"
    return KernelText(
        text="\n".join([*(part.text for part in parts), whole]),
        work=max(work, *(part.work for part in parts)),
        operations=sum(part.operations for part in parts) + products,
        helpers=frozenset({"bgc_invert"}).union(*(part.helpers for part in parts)),
    )


def _printed(dag: Dag, kernel: Kernel, inverses: dict[Node, int]) -> KernelText:
    """Print a kernel of parameters, a long one as a table; inverses are elements of h."""
    if len(dag.reachable(store.node for store in kernel.stores)) > _LONG:
        return print_steps(dag, kernel, _head(kernel), inverses)
    return print_kernel(dag, kernel, {}, known={n: f"h[{k}]" for n, k in inverses.items()})


def _head(kernel: Kernel) -> str:
    return f"static void model_{kernel.name}(const double *p, double *h, double *w)"
