"""The account of an import: what was read, assumed and missing, and how the checks came out."""

from __future__ import annotations

from bgc.diagnostics.catalogue.imported import contradicting, left_out
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Given:
    """Values that the user gives where the files lack them; None for none."""

    density: float | None = None
    length_scale: float | None = None


class Account:
    """Collects lines of the report, in four groups, and warnings."""

    def __init__(self) -> None:
        self._lines: dict[str, list[str]] = {"read": [], "assumed": [], "missing": [], "check": []}
        self.warnings: list[Diagnostic] = []

    def read(self, text: str) -> None:
        """Note what was found in a file."""
        self._lines["read"].append(text)

    def missing(self, text: str) -> None:
        """Note what the data lack, without harm for the ship."""
        self._lines["missing"].append(text)

    def assumed(self, text: str, help: str) -> None:
        """Note a value that the data lack, and warn of it."""
        self._lines["assumed"].append(text)
        self.warnings.append(left_out(None, text, help))

    def checked(self, what: str, found: float, limit: float, cause: str = "") -> None:
        """Note a relative difference; warn above the limit, which is a share as well."""
        self._lines["check"].append(f"{what}: {100 * found:.2g} %")
        if not found <= limit:
            share = f"{what} differ by {100 * found:.2g} %, more than {100 * limit:.2g} %"
            self.warnings.append(contradicting(share, cause))

    def unchecked(self, what: str, reason: str) -> None:
        """Note a check for which the data do not suffice."""
        self._lines["check"].append(f"{what}: not checked, {reason}")

    def lines(self) -> list[str]:
        """Return the report, a line for each entry."""
        return [f"{group}: {text}" for group, texts in self._lines.items() for text in texts]
