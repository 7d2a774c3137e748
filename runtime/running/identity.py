"""The identity of a scene, by which results are kept between runs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from bgc.building.cache import file_digest
from bgc.runtime.running.binding import text
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import NOTHING

_LARGEST_TRACE = 256_000_000  # bytes that the driver `trace` reads


def scene_identity(
    model: LoadedModel, parameters: Mapping[str, float] = NOTHING
) -> tuple[str, ...]:
    """Identify a scene by its compiled content, parameters, start, device files and version of bgc.

    `parameters` replace present values, SI.
    """
    values = {**model.parameters.given({}), **parameters}
    return (
        model.facts.content,
        repr(sorted(values.items())),
        repr((model.facts.solver.settle, model.facts.rest)),
        *(file_digest(path) for _, path in device_files(model)),
        bgc_version(),
    )


def device_files(model: LoadedModel) -> list[tuple[str, Path]]:
    """List the files that the devices read, with their names as the scene gives them."""
    struct = model.library.model
    found = []
    for index in range(struct.n_device):
        for line in text(struct.device[index].options).split("\n"):
            key, _, value = line.partition("=")
            path = model.folder / value
            with suppress(OSError, ValueError):
                # A pipe or a device may never end; files of /proc state no size.
                if key == "file" and path.is_file() and 0 < path.stat().st_size <= _LARGEST_TRACE:
                    found.append((value, path))
    return found


def bgc_version() -> str:
    """Return the version of bgc; empty if it is not installed."""
    # Loads the parser of e-mail, the format of metadata: 10 ms that most runs do without.
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("bgc-lang")
    except PackageNotFoundError:
        return ""
