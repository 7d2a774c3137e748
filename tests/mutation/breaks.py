"""Deliberate breaks of C and Python texts: one changed place each.

C is changed by patterns in lines without comments and strings, Python at the places of nodes of its
syntax tree: all else of the text stays.
"""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial


@dataclass(frozen=True, slots=True)
class Break:
    """A change of one place; `before` and `after` are its line, or the changed expression.

    `text` gives the whole file with the change.
    """

    line: int
    before: str
    after: str
    text: Callable[[], str]
    function: str = ""  # of Python: `Class.method`, "" in a module's own statements

    @property
    def name(self) -> str:
        return f"{self.before.strip()}  ->  {self.after.strip()}"


# --- C: what replaces a match, group 1 or all of it --------------------------------------------

_SWAPS = {
    " < ": " >= ", " <= ": " > ", " > ": " <= ", " >= ": " < ", " == ": " != ", " != ": " == ",
    " && ": " || ", " || ": " && ", " + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ",
    " += ": " -= ", " -= ": " += ", " *= ": " /= ", " |= ": " = ", " &= ": " = ",
    "fmax(": "fmin(", "fmin(": "fmax(", "fabs(": "(", "!": "", "++;": "--;",
}  # fmt: skip
_LIMITS = {" < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > "}  # of loops
_SWAP = re.compile("|".join(re.escape(key) for key in sorted(_SWAPS, key=len, reverse=True)))
_NUMBER = re.compile(r"(?<![\w.\"])(\d+\.\d*(?:e[-+]?\d+)?|\d+e-?\d+|\d+)(?![\w.])")
_STATEMENT = re.compile(r"^\s+(?!return|break|continue|const |static |double |int |size_t |long )"
                        r"[\w*(].*;$")  # fmt: skip
_ARGUMENTS = re.compile(r"(?<=[(,] )?\b([a-z]\w*), ([a-z]\w*)\b(?=[,)])")


def _code(line: str) -> str:
    """The line with comments and strings blanked, of the same length."""
    return re.sub(r"/\*.*?(\*/|$)|^ \*.*|\"[^\"]*\"", lambda match: " " * len(match[0]), line)


def _other_numbers(number: str, before: str) -> tuple[str, ...]:
    if number == "1" and re.search(r"(?:[=(,?:]|return) -$", before):
        return ("0",)  # negative numbers that mean none are all alike
    if re.fullmatch(r"\d+", number):
        return (str(int(number) + 1),)
    return (repr(float(number) * 1.7 + (1.0 if float(number) == 0.0 else 0.0)),)


def breaks_of_c(text: str) -> Iterator[Break]:
    """All breaks of a C file."""
    lines = text.split("\n")
    in_comment = False
    for number, line in enumerate(lines):
        code = _code(line)
        in_comment = ("/*" in line and "*/" not in line) or (in_comment and "*/" not in line)
        if in_comment or ("*/" in line and "/*" not in line) or code.startswith(("#", " *")):
            continue
        swaps = {**_SWAPS, **_LIMITS} if "for (" in line else _SWAPS
        changed = [_with(line, match.span(), swaps[match[0]]) for match in _SWAP.finditer(code)]
        changed += [
            _with(line, match.span(1), new)
            for match in _NUMBER.finditer(code)
            for new in _other_numbers(match[1], code[: match.start()])
        ]
        changed += [
            _with(line, match.span(), f"{match[2]}, {match[1]}")
            for match in _ARGUMENTS.finditer(code)
            if match[1] not in ("m", "d") and "(" in code[: match.start()] and code[0] == " "
        ]
        if _STATEMENT.match(code.rstrip()) and code.count("(") == code.count(")"):
            changed.append(line[: len(line) - len(line.lstrip())] + ";")
        for new_line in changed:
            yield Break(number + 1, line, new_line, partial(_joined, lines, number, new_line))


def _joined(lines: list[str], number: int, line: str) -> str:
    return "\n".join([*lines[:number], line, *lines[number + 1 :]])


def _with(line: str, span: tuple[int, int], new: str) -> str:
    """The line with another text in a span."""
    return line[: span[0]] + new + line[span[1] :]


# --- Python ------------------------------------------------------------------------------------

_OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.And: ast.Or, ast.Or: ast.And,
    ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr,
}  # fmt: skip
_SYMMETRIC = {"mul", "add", "equal", "isclose", "max", "min", "gcd"}  # functions of two arguments
_SKIPPED = {"annotation", "returns", "decorator_list", "type_params"}
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


def _nodes(node: ast.AST, function: str = "") -> Iterator[tuple[ast.AST, str]]:
    """Nodes that run, with their functions; without annotations and what is raised."""
    for field, value in ast.iter_fields(node):
        children = value if isinstance(value, list) else [value]
        for child in children:
            if not isinstance(child, ast.AST) or field in _SKIPPED:
                continue
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue  # a check
            if isinstance(child, ast.Assert | ast.JoinedStr) or _is_docstring(child):
                continue
            yield child, function
            if not isinstance(child, ast.Raise):
                named = isinstance(child, _FUNCTIONS)
                inner = f"{function}.{child.name}".lstrip(".") if named else function  # type: ignore[attr-defined]
                yield from _nodes(child, inner)


def _is_docstring(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _changes(node: ast.AST, strings: bool) -> Iterator[tuple[ast.AST, ast.AST]]:
    """Parts of a node, and what takes their place: one fault each."""
    if isinstance(node, ast.Compare) and type(node.ops[0]) in _OPERATORS:
        new = copy.deepcopy(node)
        new.ops[0] = _OPERATORS[type(node.ops[0])]()  # type: ignore[call-overload]
        yield node, new
    if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in _OPERATORS:
        changed = copy.deepcopy(node)
        changed.op = _OPERATORS[type(node.op)]()  # type: ignore[assignment]
        yield node, changed
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield node, node.operand
    if isinstance(node, ast.If | ast.IfExp | ast.While):
        yield node.test, ast.UnaryOp(ast.Not(), node.test)
    if isinstance(node, ast.comprehension) and node.ifs:
        yield node.ifs[0], ast.Constant(True)
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield node, ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield node, ast.Constant(node.value + 1)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str) and strings:
        yield node, ast.Constant(node.value + "x")
    if _may_be_left_out(node):
        yield node, ast.Pass()
    if isinstance(node, ast.Call) and len(node.args) > 1 and _name_of(node) not in _SYMMETRIC:
        swapped = copy.deepcopy(node)
        swapped.args[-2:] = swapped.args[:-3:-1]
        if ast.dump(swapped) != ast.dump(node):
            yield node, swapped


def _may_be_left_out(node: ast.AST) -> bool:
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Call)
    if isinstance(node, ast.Assign):
        return isinstance(node.targets[0], ast.Subscript | ast.Attribute)
    return isinstance(node, ast.AugAssign | ast.Continue | ast.Break | ast.Raise)


def _name_of(node: ast.Call) -> str:
    return ast.unparse(node.func).rsplit(".", 1)[-1]


def breaks_of_python(text: str, strings: bool = False) -> Iterator[Break]:
    """All breaks of a Python file; `strings` adds changed texts."""
    lines = text.encode().splitlines(keepends=True)
    for node, function in _nodes(ast.parse(text)):
        for old, new in _changes(node, strings):
            before, after = ast.unparse(old), ast.unparse(new)
            put = after if isinstance(new, ast.stmt | ast.Constant) else f"({after})"
            assert isinstance(old, ast.expr | ast.stmt)
            yield Break(old.lineno, before, after, partial(_put, lines, old, put), function)


def _put(lines: list[bytes], old: ast.expr | ast.stmt, new: str) -> str:
    """The text with another one in the place of a node."""
    assert old.end_lineno is not None and old.end_col_offset is not None
    first, last = lines[old.lineno - 1], lines[old.end_lineno - 1]
    whole = b"".join(lines[: old.lineno - 1]) + first[: old.col_offset] + new.encode()
    return (whole + last[old.end_col_offset :] + b"".join(lines[old.end_lineno :])).decode()
