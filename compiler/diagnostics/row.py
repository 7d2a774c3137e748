"""Rows of the catalogue: code, severity and texts of a diagnostic as data, with typed parameters.

A row decorates the signature of its parameters, and is called with them::

    @error("BG431: `{name}`, {kind:an}, has no law", "{way}")
    def law_missing(span: Span, name: str, kind: str, way: str) -> None: ...

The first text is the code and the message, the second the help. The type checker compares each
call with the signature. In a text `{name}` is the value of a parameter, `{step:.3g}` the value as
`format` writes it, `{names:listed}` and `{kind:an}` its form in words (`FORMS`), and
`{runs:counted run}` a number with its noun. Other braces stand for themselves. A parameter named
`span`, `note`, `labels`, `help` or `edits` is that field of the diagnostic; the text of the row,
if there is one, is used where it is empty. `labels` of a row gives the text at each parameter
that is a span, or a sequence of spans. `fault` of a row tells whether other choices may help.

A row that has to compute returns further values by name, or other values of its parameters.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, Generic, ParamSpec, TypeAlias

from bgc.diagnostics.diagnostic import Diagnostic, Edit, Fault, Label, Severity
from bgc.diagnostics.source import Span
from bgc.diagnostics.words import FORMS, counted
from bgc.record_class import dataclass, field

Values: TypeAlias = Mapping[str, Any]
"""Values of a row by the names that its texts use."""

_P = ParamSpec("_P")
PLACE = re.compile(r"\{(\w+)(?::([^{}]+))?\}")
"""A value in a text: its name, and its form if it has one."""


@dataclass(frozen=True, slots=True)
class Row(Generic[_P]):
    """A diagnostic of the catalogue: called with its parameters, it makes the `Diagnostic`."""

    code: str
    severity: Severity
    message: str
    help: str
    note: str
    labels: Mapping[str, str]
    fault: Fault
    function: Callable[_P, Values | None] = field(repr=False)

    def __call__(self, *args: _P.args, **kwargs: _P.kwargs) -> Diagnostic:
        """Fill the texts with the arguments and with what the row computes from them."""
        bound = inspect.signature(self.function).bind(*args, **kwargs)
        bound.apply_defaults()
        values: Values = {**bound.arguments, **(self.function(*args, **kwargs) or {})}
        own = (
            Label(span, fill(text, values))
            for name, text in self.labels.items()
            for span in _spans(values[name])
        )
        labels: Iterable[Label] = values.get("labels", own)
        edits: Iterable[Edit] = values.get("edits", ())
        return Diagnostic(
            self.code,
            self.severity,
            fill(self.message, values),
            values.get("span"),
            values.get("note") or fill(self.note, values),
            tuple(labels),
            values.get("help") or fill(self.help, values),
            tuple(edits),
            self.fault,
        )


def _spans(places: Span | Sequence[Span] | None) -> Sequence[Span]:
    if places is None:
        return ()
    return (places,) if isinstance(places, Span) else places


def fill(text: str, values: Values) -> str:
    """Put values into the places of a text."""
    return PLACE.sub(lambda place: _shown(values[place[1]], place[2] or ""), text)


def _shown(value: Any, form: str) -> str:
    if form in FORMS:
        return FORMS[form](value)
    word, _, noun = form.partition(" ")
    return counted(value, noun) if word == "counted" else format(value, form)


@dataclass(frozen=True, slots=True)
class _Texts:
    """The texts of a row, which decorate the function of its parameters."""

    severity: Severity
    text: str
    help: str = ""
    note: str = field(default="", kw_only=True)
    labels: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    fault: Fault = field(default=Fault.MODEL, kw_only=True)

    def __call__(self, function: Callable[_P, Values | None]) -> Row[_P]:
        code, _, message = self.text.partition(": ")
        texts = (message, self.help, self.note, self.labels)
        return Row(code, self.severity, *texts, self.fault, function)


error = partial(_Texts, Severity.ERROR)
"""Texts of a diagnostic that ends the compilation."""

warning = partial(_Texts, Severity.WARNING)
"""Texts of a diagnostic that does not end the compilation."""

info = partial(_Texts, Severity.INFO)
"""Texts of a diagnostic that reports a fact, and is no warning in strict mode either."""
