"""Calls that have to be refused, and what they are refused with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from bgc.diagnostics.diagnostic import BgError, Diagnostic


def refusals(function: Callable[..., Any], *arguments: Any, **options: Any) -> list[Diagnostic]:
    """The diagnostics with which a call is refused."""
    with pytest.raises(BgError) as caught:
        function(*arguments, **options)
    return list(caught.value.diagnostics)


def refusal(function: Callable[..., Any], *arguments: Any, **options: Any) -> Diagnostic:
    """The only diagnostic with which a call is refused."""
    (diagnostic,) = refusals(function, *arguments, **options)
    return diagnostic


def codes_of(function: Callable[..., Any], *arguments: Any, **options: Any) -> list[str]:
    """The codes of the diagnostics with which a call is refused."""
    return [diagnostic.code for diagnostic in refusals(function, *arguments, **options)]


def code_of(caught: pytest.ExceptionInfo[BgError]) -> str:
    """The code of the only diagnostic of an error that was caught."""
    (diagnostic,) = caught.value.diagnostics
    return diagnostic.code
