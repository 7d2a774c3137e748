"""BG757: exchange of the model of a running loop."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def cannot_exchange(reason: str) -> Diagnostic:
    """BG757: a model cannot take the place of another one in a running loop

    What: the exchange was refused before anything changed; the loop goes on with its model.

    Why: the devices stay open and the period of the loop stays, so both scenes need devices of the
    same names and the same period. One exchange has to be over before the next one begins, and a
    loop that has ended takes no other model.

    Example: `bgc haptic cranes.bg --exchange arm` where `arm` calls its device `stick` in place of
    `hand`.

    Way out: give the devices of both scenes the same names, and both the same `step`.
    """
    return error(
        "BG757",
        f"this model cannot take the place of the one in the loop: {reason}",
        help="scenes of one loop have devices of the same names, and the same `step`",
    )
