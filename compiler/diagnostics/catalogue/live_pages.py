"""Diagnostics: pages that run their model."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, info


@info(
    "BG544: the page has no bond graph: the model has {bonds:,} bonds, and a page draws at "
    "most {most:,}",
    "the page runs the model all the same; for its graph, build a page of a smaller model",
)
def page_without_graph(bonds: int, most: int) -> None: ...
@error(
    "BG545: a page that runs its model needs the package `ziglang`, which is missing",
    'install it (`pip install "bgc-lang[zig]"`), or write a recorded run as one file '
    "with `bgc view FILE --export FILE.html`",
)
def page_needs_zig() -> None: ...
@error("BG547: {problem}")
def page_not_compiled(compiler: str, output: str) -> Values:
    lines = output.splitlines()
    if any(line.startswith("Traceback ") for line in lines):
        return {
            "problem": f"the package of the C compiler `{compiler}` does not work",
            "note": lines[-1].strip(),
            "help": "install it again: `pip install --force-reinstall ziglang`",
        }
    return {
        "problem": f"the C compiler `{compiler}` cannot compile the model to WebAssembly",
        "note": "\n".join(lines[:20]),
        "help": "remove the reason above; the compiler keeps its files in `~/.cache/zig`, or in "
        "the folder that ZIG_GLOBAL_CACHE_DIR names",
    }


@error(
    "BG548: a page cannot hold the solver `{solver}`, which belongs to another package",
    "choose one of bgc's own methods in the scene: {methods:quoted}",
)
def solver_not_in_page(solver: str, methods: Sequence[str]) -> None: ...
