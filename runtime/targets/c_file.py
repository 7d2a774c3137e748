"""The target `c`: one file of C11 that holds model and runtime, and its header."""

from __future__ import annotations

from time import perf_counter

import click

from bgc.building.build import runtime_directory
from bgc.driver import compile_scene
from bgc.emission.amalgamate import public_header
from bgc.emission.emit import amalgamate_lowered
from bgc.emission.prefix import prefix_problem, with_prefix
from bgc.runtime.targets.target import Order, Product


def make(order: Order, _: str) -> Product:
    """Compile a scene to C; raises click.UsageError for a prefix that is no name."""
    stages = compile_scene(order.file, order.options, until="lower")
    begin = perf_counter()
    text = amalgamate_lowered(stages.lowered, stages.source_hash, runtime_directory())
    seconds = {**stages.seconds, "emit": perf_counter() - begin}
    header = public_header(runtime_directory())
    prefix = order.prefix
    if prefix is not None:
        if problem := prefix_problem(prefix, text):
            raise click.UsageError(f"--prefix {prefix}: {problem}")
        text, header = with_prefix(text, prefix), with_prefix(header, prefix)
    return Product(
        {f"{order.name}.c": text.encode()},
        stages.warnings,
        seconds,
        companions={f"{order.name}.h": header.encode()},
    )
