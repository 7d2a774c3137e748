"""BG544, BG545, BG547, BG548: pages that run their model themselves."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, info
from bgc.diagnostics.diagnostic import Diagnostic


def page_without_graph(bonds: int, most: int) -> Diagnostic:
    """BG544: a page has no bond graph, since it is too large"""
    return info(
        "BG544",
        f"the page has no bond graph: the model has {bonds:,} bonds, and a page draws at most "
        f"{most:,}",
        help="the page runs the model all the same; for its graph, build a page of a smaller model",
    )


def page_needs_zig() -> Diagnostic:
    """BG545: a page with its model needs ziglang"""
    return error(
        "BG545",
        "a page that runs its model needs the package `ziglang`, which is missing",
        help='install it (`pip install "bgc-lang[zig]"`), or write a recorded run as one file with '
        "`bgc view FILE --export FILE.html`",
    )


def page_not_compiled(compiler: str, output: str) -> Diagnostic:
    """BG547: a model could not be compiled to WebAssembly"""
    lines = output.splitlines()
    if any(line.startswith("Traceback ") for line in lines):
        return error(
            "BG547",
            f"the package of the C compiler `{compiler}` does not work",
            note=lines[-1].strip(),
            help="install it again: `pip install --force-reinstall ziglang`",
        )
    return error(
        "BG547",
        f"the C compiler `{compiler}` cannot compile the model to WebAssembly",
        note="\n".join(lines[:20]),
        help="remove the reason above; the compiler keeps its files in `~/.cache/zig`, or in the "
        "folder that ZIG_GLOBAL_CACHE_DIR names",
    )


def solver_not_in_page(solver: str, methods: Sequence[str]) -> Diagnostic:
    """BG548: a page cannot hold this solver"""
    names = ", ".join(f"`{name}`" for name in methods)
    return error(
        "BG548",
        f"a page cannot hold the solver `{solver}`, which belongs to another package",
        help=f"choose one of bgc's own methods in the scene: {names}",
    )
