"""The targets `fmu2` and `fmu3`: a Functional Mock-up Unit."""

from __future__ import annotations

from bgc.runtime.fmi.binaries import read_platforms
from bgc.runtime.fmi.export import fmu_files
from bgc.runtime.fmi.fmu_model import prepare_model
from bgc.runtime.targets.target import Order, Product


def make(order: Order, target: str) -> Product:
    """Compile a scene to an FMU of the version in the target's name, and the files beside it."""
    platforms = read_platforms(order.platforms)
    model = prepare_model(order.file, order.options, int(target.removeprefix("fmu")), order.inputs)
    files = fmu_files(model, platforms, order.reference)
    return Product(files, model.built.warnings, model.stages.seconds)
