"""`bgc.compile`: from a `.bg` file to a model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from bgc.diagnostics.public import public_function
from bgc.options import Options
from bgc.runtime.model import Model
from bgc.runtime.running.model_loading import load_as
from bgc.runtime.running.parameters import ParameterValue


@public_function
def compile_model(
    path: str | Path,
    scene: str | None = None,
    parameters: Mapping[str, ParameterValue] | None = None,
    *,
    strict: bool = False,
    whole: bool = False,
    uses: Mapping[str, str] | None = None,
    preview: bool = False,
    shapes: bool = False,
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
        Whether to compile everything, and not only what the scene requires: then no state is
        left out and no parameter folded.
    uses
        Parts for slots of the model, as `{"crane.elbow.lock": "Rigid[5]"}`.
    preview
        Whether to compile quickly without optimisation (tcc if installed, otherwise -O0).
    shapes
        Whether its runs record the poses of all shapes, as `simulate(shapes=True)` does.

    Raises
    ------
    BgError
        The model, the machine or the values are at fault; its `diagnostics` say where.
    """
    filled = tuple((uses or {}).items())
    options = Options(
        scene, strict=strict, whole=whole, uses=filled, preview=preview, shapes=shapes
    )
    return load_as(Model, Path(path), options, parameters or {})
