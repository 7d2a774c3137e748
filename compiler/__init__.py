"""bgc: a declarative language for bond graphs, its compiler, and the runtime of its models.

>>> import bgc
>>> model = bgc.compile("crane.bg", scene="lift")  # doctest: +SKIP
>>> result = model.simulate()  # doctest: +SKIP
>>> result["tip_height"]  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bgc.diagnostics.diagnostic import BgError
    from bgc.diagnostics.python_warnings import BgWarning
    from bgc.runtime import control
    from bgc.runtime.compiling import compile_model as compile
    from bgc.runtime.model import Model
    from bgc.runtime.reduce.reduce import Reduction, reduce
    from bgc.runtime.reduced_parts.reduced_part import ReducedPart, reduced_part
    from bgc.runtime.results.ensemble import Ensemble
    from bgc.runtime.results.result import Result
    from bgc.runtime.running.failures import SimulationError
    from bgc.runtime.trade.trade import Trade, trade

__all__ = [
    "BgError",
    "BgWarning",
    "Ensemble",
    "Model",
    "ReducedPart",
    "Reduction",
    "Result",
    "SimulationError",
    "Trade",
    "compile",
    "control",
    "reduce",
    "reduced_part",
    "trade",
]

# Imported when first asked for: a pass of the compiler needs nothing of the runtime.
_HOMES = {
    "BgWarning": ("bgc.diagnostics.python_warnings", "BgWarning"),
    "BgError": ("bgc.diagnostics.diagnostic", "BgError"),
    "Ensemble": ("bgc.runtime.results.ensemble", "Ensemble"),
    "Model": ("bgc.runtime.model", "Model"),
    "ReducedPart": ("bgc.runtime.reduced_parts.reduced_part", "ReducedPart"),
    "Reduction": ("bgc.runtime.reduce.reduce", "Reduction"),
    "Result": ("bgc.runtime.results.result", "Result"),
    "SimulationError": ("bgc.runtime.running.failures", "SimulationError"),
    "Trade": ("bgc.runtime.trade.trade", "Trade"),
    "compile": ("bgc.runtime.compiling", "compile_model"),
    "control": ("bgc.runtime.control", ""),  # the module itself
    "reduce": ("bgc.runtime.reduce.reduce", "reduce"),
    "reduced_part": ("bgc.runtime.reduced_parts.reduced_part", "reduced_part"),
    "trade": ("bgc.runtime.trade.trade", "trade"),
    "load_ipython_extension": ("bgc.runtime.magic", "load_ipython_extension"),
}


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", "__doc__"})


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("bgc-lang")
    if name not in _HOMES:
        raise AttributeError(f"module 'bgc' has no attribute {name!r}")
    module, attribute = _HOMES[name]
    found = import_module(module)
    return getattr(found, attribute) if attribute else found
