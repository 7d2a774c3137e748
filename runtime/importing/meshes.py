"""Files of meshes that a robot names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import unquote, urlsplit

from bgc.diagnostics.source import Span
from bgc.language.shape_table import MESH_FILES
from bgc.runtime.importing.notes import Notes


class Meshes:
    """Finds the file of a mesh from its name in the robot's file."""

    def __init__(self, folder: Path, packages: Mapping[str, Path], notes: Notes) -> None:
        self.folder = folder
        self.packages = packages
        self.notes = notes

    def find(
        self, name: str, place: Span | None, scale: tuple[float, ...] = (1, 1, 1), *, quiet: bool
    ) -> Path | None:
        """Return the file of a mesh that can be shown; otherwise note why it is left out."""
        if Path(name).suffix.lower() not in MESH_FILES:
            self._note(
                place,
                f"a mesh in the format `{Path(name).suffix[:10]}` is left out",
                f"convert it to one of {', '.join(sorted(MESH_FILES))}, and name that file",
                quiet,
            )
            return None
        if len(set(scale)) > 1 or scale[0] <= 0:
            cause = "a mesh with different scales along its axes is left out"
            self._note(place, cause, "write the scale into the mesh", quiet)
            return None
        file = self._file(name)
        if file is None:
            package = urlsplit(name).netloc if name.startswith("package://") else ""
            help = f"add `--package {package}=FOLDER`" if package else "put the file there"
            if package in self.packages:
                help = f"it is not below {self.packages[package]}"
            cause = f"a mesh of the package `{package}` was not found, and is left out"
            plain = "a mesh was not found, and is left out"
            self._note(place, cause if package else plain, help, quiet)
        return file

    def _note(self, place: Span | None, cause: str, help: str, quiet: bool) -> None:
        if not quiet:
            self.notes.group(place, cause, help)

    def _file(self, name: str) -> Path | None:
        try:
            for candidate in self._candidates(name):
                if candidate.is_file():
                    return candidate
        except (OSError, ValueError):  # a name that no file can have
            return None
        return None

    def _candidates(self, name: str) -> list[Path]:
        if not name.startswith(("package://", "file://", "model://")):
            return [self.folder / name]
        parts = urlsplit(name)
        path = Path(unquote(parts.path).lstrip("/"))
        if parts.scheme == "file":
            return [Path("/") / path]
        package = parts.netloc
        if package in self.packages:
            return [self.packages[package] / path]
        # A package usually encloses the robot's file, or lies beside a folder that does.
        around = [self.folder.absolute(), *self.folder.absolute().parents][:6]
        return [
            *(folder / path for folder in around if folder.name == package),
            *(folder / package / path for folder in around),
        ]
