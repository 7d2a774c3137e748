"""BG04x: what `bgc doc` and `bgc new` are given."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_topic(name: str, near: str, known: Iterable[str]) -> Diagnostic:
    """BG040: a name that the reference does not have

    What: `bgc doc NAME` was given a name without an entry.

    Why: it is spelt differently, or declared in a file of your own, which has to be named first.

    Example: `bgc doc Baem`, `bgc doc MyPart`

    Way out: `bgc doc` lists what there is; `bgc doc FILE.bg NAME` looks in a file.
    """
    help = (
        near
        or did_you_mean(name, known)
        or "`bgc doc` lists what there is; `bgc doc FILE.bg NAME` looks in a file"
    )
    return error("BG040", f"there is no documentation of `{name}`", help=help)


def not_in_file(name: str, file: str, known: Sequence[str]) -> Diagnostic:
    """BG041: a name that a file does not declare

    What: `bgc doc FILE NAME` was given a name that the file does not declare.

    Why: it is spelt differently, or declared in a file that this one imports.

    Example: `bgc doc crane.bg Beam`, where `crane.bg` imports `Beam` from the library.

    Way out: name a declaration of the file; `bgc doc FILE` lists them.
    """
    has = f"it declares {listed(known)}" if known else "it declares nothing"
    help = did_you_mean(name, known) or has
    return error("BG041", f"`{file}` does not declare `{name}`", help=help)


def file_exists(path: str, option: str = "") -> Diagnostic:
    """BG042: a new file that is there already

    What: `bgc new` or `bgc import` was to write a file that exists.

    Why: it never replaces a file, which may hold your own work.

    Example: `bgc new crane` beside a `crane.bg`

    Way out: take another name, or move the file; `bgc import --force` replaces it.
    """
    help = "take another name, or move the file" + (f"; {option} replaces it" if option else "")
    return error("BG042", f"{path} exists already", help=help)


def bad_new_name(name: str, stem: str) -> Diagnostic:
    """BG043: a name from which no model can be named

    What: the name given to `bgc new` is not a name of the language, or is one of its words.

    Why: the file's name is that of its scene, and with a capital letter that of its model.

    Example: `bgc new 2dof`, `bgc new scene`

    Way out: letters, digits and `_`, with a letter first: `bgc new two_dof`.
    """
    return error(
        "BG043",
        f"`{stem}` cannot name a model and its scene",
        help="use letters, digits and `_`, with a letter first, and no word of the language"
        if stem == name
        else f"only the last part of {name} names the model: letters, digits and `_`",
    )
