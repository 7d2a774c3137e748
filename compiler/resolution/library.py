"""The files of the installed library, by the names of its modules."""

from __future__ import annotations

from functools import cache
from importlib import resources
from pathlib import Path


@cache
def library_folder() -> Path:
    """Return the folder of the `.bg` files of the installed library."""
    return Path(str(resources.files("bgc.library")))


@cache
def library_modules() -> tuple[str, ...]:
    """Return the dotted names of the library's modules, sorted."""
    folder = library_folder()
    return tuple(
        sorted(".".join(p.relative_to(folder).with_suffix("").parts) for p in folder.rglob("*.bg"))
    )


def scene_file(name: str) -> Path | None:
    """Return the file of the library's scenes or examples that has a name, such as `ur5.bg`."""
    places = (library_folder() / folder / name for folder in ("scenes", "examples"))
    return next((place for place in places if place.suffix == ".bg" and place.is_file()), None)


def module_path(module: str) -> Path:
    """Return the file of a module."""
    return library_folder().joinpath(*module.split(".")).with_suffix(".bg")
