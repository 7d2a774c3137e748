"""Join C files and the runtime's headers to one file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

_OWN_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([^"]+)".*\n', re.MULTILINE)
_GUARD = re.compile(r"^#ifndef (\w+_H)\n#define \1$", re.MULTILINE)
_FEATURE = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(_[A-Z_]+_SOURCE)[ \t]+(\w+)", re.MULTILINE)


def joined(texts: Sequence[tuple[str, str]], runtime_dir: Path) -> str:
    """Join C files, given by name and text, to one that includes no header of the runtime.

    The first include of each of the runtime's headers is replaced by its text, further ones are
    removed; a header without an include guard is included each time. Feature test macros of the
    system headers come first.
    """
    files = sorted((*runtime_dir.glob("*.h"), *runtime_dir.glob("drivers/*.h")))
    headers = {path.relative_to(runtime_dir).as_posix(): path.read_text("utf-8") for path in files}
    glue = sorted(runtime_dir.glob("fmi/*.h"))
    for path in glue:
        headers[path.name] = headers[f"fmi/{path.name}"] = path.read_text("utf-8")
    included: set[str] = set()

    def expanded(text: str) -> str:
        def replace(match: re.Match[str]) -> str:
            name = match.group(1)
            if name in included:
                return ""
            if _GUARD.search(headers[name]):
                included.add(name)
            return expanded(headers[name])

        return _OWN_INCLUDE.sub(replace, text)

    features: dict[tuple[str, str], None] = {}
    for text in (*headers.values(), *(text for _, text in texts)):
        features.update(dict.fromkeys(_FEATURE.findall(text)))
    return "".join(
        f"#ifndef {name}\n#define {name} {value}\n#endif\n" for name, value in features
    ) + "".join(
        f"\n/* ===== {name} {'=' * max(3, 88 - len(name))} */\n\n{expanded(text)}"
        for name, text in texts
    )


def public_header(runtime_dir: Path) -> str:
    """Print `bgc.h` with the header that it includes, as one file."""
    text = (runtime_dir / "bgc.h").read_text("utf-8")
    return _OWN_INCLUDE.sub(lambda own: (runtime_dir / own[1]).read_text("utf-8"), text)
