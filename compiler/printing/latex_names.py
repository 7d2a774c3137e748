r"""Typeset names of a model: `crane.boom.omega_x[2]` is `\omega_{x,\mathrm{crane.boom},2}`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable

_GREEK = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau "
    "upsilon phi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega".split()
)
_VARIANTS = {"epsilon": r"\varepsilon", "phi": r"\varphi"}
_PARTS = re.compile(r"(?P<letters>[^\W\d_]+)(?P<digits>\d*)(?P<rest>(?:_\w+)?)")
_SPECIAL = str.maketrans({"_": r"\_", "#": r"\#", "%": r"\%", "&": r"\&", "$": r"\$"})


def latex_name(name: str) -> str:
    """A name as a symbol: its last word, with the path before it and its index as subscripts."""
    if name == "time":
        return "t"
    path, _, last = name.rpartition(".")
    last, _, index = last.partition("[")
    parts = _PARTS.fullmatch(last)
    if parts is None:
        symbol, below = _letters(last), []
    else:
        symbol = _letters(parts["letters"])
        words = [parts["digits"], *parts["rest"].split("_")]
        below = [_letters(word, upright=True) for word in words if word]
    if path:
        below.append(_upright(path))
    if index:
        below.append(index.removesuffix("]"))
    return _with_subscript(symbol, below)


def latex_names(names: Iterable[str]) -> dict[str, str]:
    """Symbols of names; names with equal symbols, such as `x1` and `x_1`, are spelled in full."""
    short = {name: latex_name(name) for name in names}
    alike = Counter(short.values())
    return {
        name: symbol if alike[symbol] == 1 else rf"\mathit{{{name.translate(_SPECIAL)}}}"
        for name, symbol in short.items()
    }


def dotted(symbol: str) -> str:
    """The symbol with a dot above its letter, for its rate."""
    letter, below, rest = symbol.partition("_{")
    return rf"\dot{{{letter}}}{below}{rest}"


def _with_subscript(symbol: str, below: list[str]) -> str:
    return f"{symbol}_{{{','.join(below)}}}" if below else symbol


def _letters(word: str, *, upright: bool = False) -> str:
    if word in _GREEK:
        return _VARIANTS.get(word, rf"\{word}")
    if len(word) == 1 or word.isdigit():
        return word
    return _upright(word) if upright else rf"\mathit{{{word.translate(_SPECIAL)}}}"


def _upright(text: str) -> str:
    return rf"\mathrm{{{text.translate(_SPECIAL)}}}"
