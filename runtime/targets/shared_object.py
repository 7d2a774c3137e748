"""The target `so`: the shared object that `bgc run` uses."""

from __future__ import annotations

from bgc.runtime.running.model_loading import load_or_compile
from bgc.runtime.targets.target import Order, Product


def make(order: Order, _: str) -> Product:
    """Compile a scene, or take it from the cache."""
    seconds: dict[str, float] = {}
    built = load_or_compile(order.file, order.options, seconds)
    return Product({f"{order.name}.so": built.library.read_bytes()}, built.warnings, seconds)
