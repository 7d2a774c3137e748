"""The description of a scene for the page: shapes, observed quantities, panels, parameters.

It is plain data for JSON. Rows of the page have the columns that the description refers to by
index; a shape has each quantity either as numbers or as columns.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from bgc.building.build_result import ENERGY_ACCOUNTS
from bgc.language.column_names import column_of, component_of, name_in_si
from bgc.language.scene import Plot
from bgc.runtime.results.recorded_shapes import Shape
from bgc.runtime.results.result import Result
from bgc.runtime.running.device_drivers import NO_CHOICES, Choices
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import Parameter
from bgc.runtime.view.hands import describe_devices, handle_devices
from bgc.values.shown_units import Shown

Description: TypeAlias = dict[str, Any]

VERSION: Final = 1
_SEEN: Final = 3e-3  # of the range of a column: smaller errors are hidden by its curve
_MESHES: Final = (".glb", ".gltf", ".stl", ".obj")


def describe_model(model: LoadedModel, name: str, devices: Choices = NO_CHOICES) -> Description:
    """Describe a model that was compiled with shapes; `name` is that of its file.

    Its rows are those that C writes: `measured`, then the energy accounts if there are any.
    `devices` are drivers other than the scene's.
    """
    facts = model.facts
    places = {variable.name: k for k, variable in enumerate(model.measured)}
    chosen = model.selection()
    observed = [
        _quantity(v.name, Shown(v.shown.unit, v.shown.factor * factor), place)
        for v, place, factor in zip(model.outputs, chosen.places, chosen.factors, strict=True)
    ]
    shapes = []
    for entry in json.loads(facts.shapes or "[]"):
        values = {}
        for field, shape, content in entry.pop("values"):
            varies = bool(content) and isinstance(content[0], str)
            columns = [places[column] for column in content] if varies else None
            values[field] = _value(shape, content if columns is None else None, columns)
        shapes.append({**entry, "values": values})
    _name_devices(model, shapes)
    instance = model.parameters.instance({})
    return {
        "version": VERSION,
        "scene": facts.name,
        "model": facts.model,
        "file": name,
        "width": model.row_width,
        "duration": facts.duration,
        "shapes": shapes,
        "observed": observed,
        "panels": panels_of(facts.plots, observed),
        "parameters": [_parameter(p) for p in model.parameters.all_in(instance)],
        "folded": [[name, value] for name, value in model.parameters.folded.items()],
        "devices": describe_devices(model, devices),
    }


def describe_result(result: Result, name: str) -> tuple[Description, np.ndarray[Any, Any]]:
    """Describe a finished run; return the values of its rows too, (n, width)."""
    columns: list[np.ndarray[Any, Any]] = list(result.columns.values())
    observed = [_quantity(c, result.shown_in(c), k) for k, c in enumerate(result.columns)]
    shapes = [_recorded(shape, columns) for shape in result.shapes]
    for quantity, (name, column) in zip(observed, result.columns.items(), strict=True):
        quantity.update(_error(column, result.errors.get(name), columns))
    end = float(result.time[-1]) if len(result.time) else 0.0
    values = np.column_stack(columns) if columns else np.empty((len(result.time), 0))
    description = {
        "version": VERSION,
        "scene": result.scene,
        "model": "",
        "file": name,
        "width": values.shape[1],
        "duration": end,
        "shapes": shapes,
        "observed": observed,
        "panels": panels_of(result.panels, observed),
        "parameters": [],
        "folded": [],
        "devices": [],
        "message": result.message,
    }
    return description, values


def panels_of(panels: Iterable[Plot], observed: Sequence[Description]) -> list[Description]:
    """The plots of a scene: its own panels, then the other quantities by vector and unit.

    Energy accounts share one panel; the residual, which is much smaller, has its own.
    """
    known = {quantity["name"]: k for k, quantity in enumerate(observed)}
    found: list[Description] = []
    shown: set[int] = set()
    for panel in panels:
        drawn = [k for name in panel.columns for k in _expand(name, known)]
        across = None if panel.across == "time" else next(iter(_expand(panel.across, known)), None)
        if drawn and (panel.across == "time" or across is not None):
            found.append({"quantities": drawn, "across": across})
            shown.update(drawn)
    groups: dict[tuple[str, str], list[int]] = {}
    for k, quantity in enumerate(observed):
        if k not in shown:
            groups.setdefault(_group(quantity), []).append(k)
    return [*found, *({"quantities": ks, "across": None} for ks in groups.values())]


def meshes_of(description: Description, folder: Path) -> list[Path]:
    """The files of meshes that lie beside the model, and mark their shapes with their numbers.

    A shape whose file is not found is marked with `missing`.
    """
    found: list[Path] = []
    for shape in description["shapes"]:
        if not shape["file"]:
            continue
        path = folder / shape["file"]
        if path.suffix.lower() in _MESHES and path.is_file():
            if path not in found:
                found.append(path)
            shape["mesh"] = found.index(path)
        else:
            shape["missing"] = True
    return found


def _name_devices(model: LoadedModel, shapes: Sequence[Description]) -> None:
    """Add to each handle the device that moves it, and the axes of the device that do."""
    handles = {shape["name"]: shape for shape in shapes if shape["kind"] == "handle"}
    columns = {name: s["values"]["position"].get("columns") for name, s in handles.items()}
    moved = handle_devices(model, {name: c for name, c in columns.items() if c})
    for name, (device, axes) in moved.items():
        handles[name].update(device=device, axes=axes)


def _group(quantity: Description) -> tuple[str, str]:
    """Quantities of one group share a plot: components of a vector, or equal units."""
    name, unit = quantity["name"], quantity["unit"]
    account = name_in_si(name).removeprefix("energy.")
    if account in ENERGY_ACCOUNTS:
        return ("residual" if account == "residual" else "energy", unit)
    vector, index = component_of(name)
    return (vector, unit) if index else ("", unit)


def _expand(name: str, known: Mapping[str, int]) -> list[int]:
    """The quantities of a name: itself, or the components of a vector."""
    for written in (name, column_of(name)):
        if written in known:
            return [known[written]]
    return [k for other, k in known.items() if component_of(other)[0] == name]


def _quantity(name: str, shown: Shown, place: int) -> Description:
    return {"name": name, "unit": shown.label, "factor": shown.factor, "column": place}


def _error(
    column: np.ndarray[Any, Any],
    error: np.ndarray[Any, Any] | None,
    columns: list[np.ndarray[Any, Any]],
) -> Description:
    """Append the errors of a column where a plot shows them: their place, None where unknown."""
    if error is None or not len(error):
        return {}
    if np.isnan(error).any():
        return {"error": None}
    if not error.max() > _SEEN * np.ptp(column):
        return {}
    columns.append(error)
    return {"error": len(columns) - 1}


def _value(
    shape: Sequence[int], numbers: Sequence[float] | None, columns: list[int] | None
) -> Description:
    content = {"numbers": list(numbers)} if numbers is not None else {"columns": columns}
    return {"shape": list(shape), **content}


def _recorded(shape: Shape, columns: list[np.ndarray[Any, Any]]) -> Description:
    """Describe a recorded shape, and append the columns of what varies."""
    values = {}
    for name, constant in shape.constant.items():
        values[name] = _value(constant.shape, constant.ravel().tolist(), None)
    for name, array in shape.varying.items():
        flat = array.reshape(len(array), -1)
        places = list(range(len(columns), len(columns) + flat.shape[1]))
        columns.extend(flat.T)
        values[name] = _value(array.shape[1:], None, places)
    return {
        "name": shape.name,
        "part": shape.part,
        "kind": shape.kind,
        "colour": shape.colour,
        "file": shape.file,
        "values": values,
    }


def _parameter(parameter: Parameter) -> Description:
    def finite(number: float) -> float | None:
        return number if np.isfinite(number) else None

    return {
        "name": parameter.name,
        "unit": parameter.shown.label,
        "factor": parameter.shown.factor,
        "value": parameter.value,
        "low": finite(parameter.low),
        "high": finite(parameter.high),
    }
