"""From a `.bg` file to a model: compiled, or taken from the cache."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from bgc.building.built import Built
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.runtime.model import Model
from bgc.runtime.running.parameters import Quantity


def compile_model(
    path: str | Path,
    scene: str | None = None,
    parameters: Mapping[str, Quantity] | None = None,
    *,
    strict: bool = False,
    whole: bool = False,
    uses: Mapping[str, str] | None = None,
    preview: bool = False,
) -> Model:
    """Compile a scene of a `.bg` file, or load it from the cache, and return the model.

    Parameters
    ----------
    path
        The `.bg` file.
    scene
        The scene's name; by default the file's first.
    parameters
        Values by name, SI numbers or texts with a unit. Those that decide the model's structure
        (a `const`, a parameter of a part that the scene replaces) are compiled in, all others
        are set in the model's `parameters`.
    strict
        Whether every warning about the model is an error.
    whole
        Whether to compile all that is written, and not only what the scene requires: then no
        state is left out and no parameter folded.
    uses
        What fills slots of the model, as `{"crane.elbow.lock": "Rigid[5]"}`.
    preview
        Whether to compile fast what runs slowly, with tcc where it is installed.

    Raises
    ------
    BgError
        What is wrong with the model, the machine or the values; its `diagnostics` say where.
    """
    given = dict(parameters or {})
    filled = tuple((uses or {}).items())
    options = Options(scene, strict=strict, whole=whole, uses=filled, preview=preview)
    try:
        model = load_model(Path(path), options)
        known = model.parameters
        structural = {n: value for n, value in given.items() if not known.can_set(n, value)}
    except BgError:
        if not given:
            raise
        # A parameter without a default cannot be compiled without its value.
        structural = given
    if structural:
        overrides = tuple((name, _as_source(value)) for name, value in structural.items())
        model = load_model(Path(path), replace(options, overrides=overrides))
    for name, value in given.items():
        if name not in structural:
            model.parameters[name] = value
    return model


def load_model(path: Path, options: Options) -> Model:
    """Load the model of some options, from the cache or compiled."""
    return Model(load_or_compile(path, options), path.absolute().parent, (path, options))


def load_or_compile(path: Path, options: Options) -> Built:
    """Take the build of an equal, earlier request from the cache, or compile."""
    from bgc.building.recall import recall

    if (found := recall(path, options)) is not None:
        return found
    from bgc.driver import compile_scene

    return compile_scene(path, options).built


def _as_source(value: Quantity) -> str:
    """Write a value in the language."""
    if isinstance(value, str):
        return value
    if isinstance(value, (int, float)) or np.ndim(value) == 0:
        return repr(float(value))  # type: ignore[arg-type]
    return f"[{', '.join(_as_source(item) for item in value)}]"
