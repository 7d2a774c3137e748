"""The target `html`: a page that runs the model."""

from __future__ import annotations

from bgc.runtime.targets.target import Order, Product
from bgc.runtime.web.page_export import live_page


def make(order: Order, _: str) -> Product:
    """Compile a scene to WebAssembly in its page."""
    page = live_page(order.file, order.options)
    return Product({f"{order.name}.html": page.document.encode()}, page.notices, page.seconds)
