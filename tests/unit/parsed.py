"""Texts read as trees: one of the whole language, and trees and refusals in short form."""

from __future__ import annotations

from model_files import model_text

from bgc.diagnostics.render import render
from bgc.diagnostics.source import Source
from bgc.grammar import syntax
from bgc.grammar.parse import parse
from bgc.grammar.syntax import Binary, Call, Index, Member, Name, Number, Range, Unary, Vector

EVERYTHING = model_text("everything")


def items(body: str) -> tuple[syntax.Item, ...]:
    """The items of a model."""
    (model,) = read(f"model M {{ {body} }}").declarations
    assert isinstance(model, syntax.Model)
    return model.items


def read(text: str) -> syntax.File:
    """The tree of a text that must be right."""
    file, wrong = parse(Source("test.bg", text))
    assert not wrong, render(wrong, colour=False)
    return file


def show(expr: syntax.Expr | Range) -> str:
    """An expression with all its parentheses."""
    match expr:
        case Number(value, unit):
            return f"{value}" if unit is None else f"{value}_{unit}"
        case Name(name):
            return name
        case Unary(operator, operand):
            return f"({operator}{show(operand)})"
        case Binary(operator, left, right):
            return f"({show(left)}{operator}{show(right)})"
        case Member(base, name):
            return f"{show(base)}.{name}"
        case Index(base, indices):
            return f"{show(base)}[{','.join(show(index) for index in indices)}]"
        case Range(first, last):
            return f"{show(first)}..{show(last)}"
        case Vector(elements):
            return f"[{','.join(show(element) for element in elements)}]"
        case Call(function, arguments):
            return f"{function}({','.join(show(argument) for argument in arguments)})"
    raise AssertionError(expr)


def wrong(text: str) -> list[tuple[str, str]]:
    """Code and underlined text of every diagnostic."""
    _, found = parse(Source("test.bg", text))
    assert all(d.help or d.labels for d in found), "a message without a way out"
    return [(d.code, d.span.text if d.span else "") for d in found]
