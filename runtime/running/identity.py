"""What tells a scene from all others: what results that are kept between runs belong to."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from types import MappingProxyType

from bgc.building.cache import file_digest
from bgc.runtime.running.binding import text
from bgc.runtime.running.loaded import LoadedModel

_PRESENT: Mapping[str, float] = MappingProxyType({})


def scene_identity(
    model: LoadedModel, parameters: Mapping[str, float] = _PRESENT
) -> tuple[str, ...]:
    """What was compiled, its parameters, its start, the files of its devices, and this bgc.

    Parameters have their present values, but for those that are given, SI.
    """
    values = {**model.parameters.given({}), **parameters}
    return (
        model.facts.content,
        repr(sorted(values.items())),
        repr(dict(model.facts.solver_options).get("settle")),
        *_device_files(model),
        bgc_version(),
    )


def _device_files(model: LoadedModel) -> list[str]:
    """The contents of the files that the devices read, as hashes."""
    struct = model.library.model
    found = []
    for index in range(struct.n_device):
        for line in text(struct.device[index].options).splitlines():
            key, _, value = line.partition("=")
            if key == "file":
                with suppress(OSError):
                    found.append(file_digest(model.folder / value))
    return found


def bgc_version() -> str:
    """The version of this bgc; empty where it is not installed."""
    # Loads the parser of e-mails that metadata is written in: 10 ms, seldom needed.
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("bgc-lang")
    except PackageNotFoundError:
        return ""
