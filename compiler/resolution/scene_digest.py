"""The digest of a scene: it changes with the scene and with all that the scene is made of.

Comments, line breaks and other declarations of the files do not count.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from bgc.building.cache import digest_of
from bgc.diagnostics.catalogue.inherited_scenes import changed_since_proof, proof_without_base
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.grammar import syntax
from bgc.resolution.modules import Package, WholeScene

_TOKEN = re.compile(r'//[^\n]*|/\*[\s\S]*?\*/|"[^"]*"|[A-Za-z_]\w*|[\w.]+|\S')
_DIGITS = 12


def scene_digest(package: Package, scene: WholeScene) -> str:
    """Identify a scene by its statements and the declarations that they reach, in 12 digits.

    Data files count that the package has read: elaborate the scene before.
    """
    texts = [scene.model.span.text, *(item.span.text for item in scene.items)]
    found = {"": [token for text in texts for token in _tokens(text)]}
    waiting = set(found[""])
    while waiting:
        name = waiting.pop()
        for kind, table in enumerate(package.root.tables()):
            key = f"{kind} {name}"
            if name in table and key not in found:
                found[key] = list(_tokens(table[name].syntax.span.text))
                waiting.update(found[key])
    reached = {token for tokens in found.values() for token in tokens}
    data = {f"{name} {digest}" for name, _, digest in package.read_files if f'"{name}"' in reached}
    parts = (" ".join((key, *tokens)) for key, tokens in sorted(found.items()))
    return digest_of([*parts, *sorted(data)])[:_DIGITS]


def _tokens(text: str) -> Iterator[str]:
    return (token for token in _TOKEN.findall(text) if not token.startswith(("//", "/*")))


def check_proof(package: Package, name: str | None) -> list[Diagnostic]:
    """Warn where the scene that a scene extends has changed since the proof of the latter.

    `name` is that of a scene of the root file, which has been elaborated; None for the first.
    """
    own = [s for s in package.root.scenes if name in (None, s.declaration.name)]
    found: list[Diagnostic] = []
    for item in own[0].declaration.items if own else ():
        if not isinstance(item, syntax.Proof):
            continue
        base = own[0].declaration.base
        seen = package.root.seen_scenes.get(base.name, []) if base is not None else []
        if base is None or not seen:
            found.append(proof_without_base(item.span, own[0].declaration.name))
        elif item.digest != scene_digest(package, seen[0]):
            found.append(changed_since_proof(item.span, base.name, own[0].declaration.name))
    return found
