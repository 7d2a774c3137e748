"""Write and check 5: look up elements, functions, library parts, diagnostics ..."""

from pathlib import Path

from bgc.diagnostics.catalogue.reference import not_in_file
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.reference.entry import Group
from bgc.reference.index import GROUPS, GUIDES, answer, contents
from bgc.reference.parts import declaration_entry, file_entry
from bgc.runtime.cli.command import argument, command, option, require
from bgc.runtime.cli.printing import AT_FAULT, print_diagnostics, print_paths
from bgc.runtime.documents import method_entries
from bgc.runtime.documents.terminal import print_entries

_INTRO = (
    "`bgc doc NAME` shows what is known of a name; `bgc doc FILE.bg` and `bgc doc FILE.bg NAME` "
    "of a file of your own."
)
_END = "Words that are not a name list what mentions them: `bgc doc wave height`."


@command()
def doc(
    names: tuple[str, ...] = argument(metavar="[GROUP | FILE.bg] [NAME]"),
    gallery: bool = option(
        "Write a page that runs its model for each scene of FILES (by default of the library), "
        "and an index (needs ziglang)."
    ),
    out: Path | None = option("Folder for --gallery, by default `gallery`.", metavar="DIR"),
) -> int | None:
    """Show the documentation of a name, or what mentions some words.

    NAME is an element (TF), a word of the language (observe), a function (sin), a unit (bar), a
    method (rodas5p), a module or part of the library (crane.beam, Beam), the code of a diagnostic
    (BG301), a chapter of the manual (scenes) or a topic (LQR, load chart, Simulink). GROUP is one
    of elements, words, functions, units, methods, library, diagnostics, topics, manual. Without
    arguments, list all names.
    """
    require(gallery or out is None, "--out needs --gallery")
    if gallery:
        return _write_gallery(names, out or Path("gallery"))
    if not names:
        print_entries([contents(all_groups(), _INTRO, _END)])
    elif names[0].endswith(".bg"):
        _show_file(*names)
    else:
        _show_names(names)
    return None


def all_groups() -> tuple[Group, ...]:
    """Return all groups of names, topics and the manual last."""
    return (*GROUPS, method_entries.GROUP, *GUIDES)


def _show_names(names: tuple[str, ...]) -> None:
    """Show the entries of a name, within the group that goes before it, if one does."""
    own = [g for g in all_groups() if names[0] in (g.name, *g.aliases)]
    if len(names) > 1 and own:
        print_entries(answer(" ".join(names[1:]), own))
    else:
        print_entries(answer(" ".join(names), (*GROUPS, method_entries.GROUP), GUIDES))


def _show_file(file: str, *wanted: str) -> None:
    """Show a file of the user's own, or some of its declarations."""
    # Lark parses, which most look-ups do without.
    from bgc.resolution.resolve import load

    package = load(Path(file))
    print_diagnostics(package.warnings)
    root = package.root
    if not wanted:
        print_entries([file_entry(root, file, "file")])
        return
    by_name = {declaration.name: declaration for declaration in root.file.declarations}
    missing = [not_in_file(name, file, list(by_name)) for name in wanted if name not in by_name]
    if missing:
        raise BgError(missing)
    print_entries(
        [declaration_entry(by_name[name], root, name, f"Declared in {file}.") for name in wanted]
    )


def _write_gallery(names: tuple[str, ...], folder: Path) -> int:
    wrong = [name for name in names if not name.endswith(".bg")]
    require(not wrong, f"--gallery takes files that end in .bg, not {', '.join(wrong[:1])}")
    # The compiler, Jinja2 and Lark, which all else does without.
    from bgc.runtime.web.gallery import library_files, write_gallery

    failed: list[Diagnostic] = []
    files = [Path(name) for name in names] or library_files()
    print_paths(write_gallery(files, folder, lambda why: failed.extend(why.diagnostics)))
    print_diagnostics(failed)
    return AT_FAULT if failed else 0
