"""Deliberate breaks of C and Python texts: one changed place each.

C is changed by patterns in lines without comments and strings, Python by its syntax tree.
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


def _nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes that run, without annotations and what is raised."""
    for field, value in ast.iter_fields(node):
        children = value if isinstance(value, list) else [value]
        for child in children:
            if not isinstance(child, ast.AST) or field in _SKIPPED:
                continue
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue  # a check
            if not isinstance(child, ast.Raise | ast.Assert | ast.JoinedStr):
                yield child
                yield from _nodes(child)


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    """Copies of a node with one change."""
    new: ast.AST
    if isinstance(node, ast.Compare) and type(node.ops[0]) in _OPERATORS:
        new = copy.deepcopy(node)
        new.ops[0] = _OPERATORS[type(node.ops[0])]()  # type: ignore[call-overload]
        yield new
    if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in _OPERATORS:
        new = copy.deepcopy(node)
        new.op = _OPERATORS[type(node.op)]()  # type: ignore[assignment]
        yield new
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield copy.deepcopy(node.operand)
    if isinstance(node, ast.If | ast.IfExp | ast.While):
        new = copy.deepcopy(node)
        new.test = ast.UnaryOp(ast.Not(), new.test)
        yield new
    if isinstance(node, ast.comprehension) and node.ifs:
        new = copy.deepcopy(node)
        new.ifs = new.ifs[1:]
        yield new
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield ast.Constant(node.value + 1)
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield ast.Pass()
    if isinstance(node, ast.Assign | ast.AugAssign) and isinstance(_target(node), ast.Subscript):
        yield ast.Pass()
    if isinstance(node, ast.Continue | ast.Break):
        yield ast.Pass()
    if isinstance(node, ast.Call) and len(node.args) > 1 and _name_of(node) not in _SYMMETRIC:
        new = copy.deepcopy(node)
        new.args[-2:] = new.args[:-3:-1]
        if ast.dump(new) != ast.dump(node):
            yield new


def _name_of(node: ast.Call) -> str:
    return ast.unparse(node.func).rsplit(".", 1)[-1]


def _target(node: ast.Assign | ast.AugAssign) -> ast.expr:
    return node.target if isinstance(node, ast.AugAssign) else node.targets[0]


def breaks_of_python(text: str) -> Iterator[Break]:
    """All breaks of a Python file."""
    tree = ast.parse(text)
    for place, node in enumerate(_nodes(tree)):
        for count, new in enumerate(_changes(node)):
            at = node.target if isinstance(node, ast.comprehension) else node
            line = getattr(at, "lineno", 0)
            yield Break(line, _shown(node), _shown(new), partial(_unparsed, text, place, count))


def _unparsed(text: str, place: int, count: int) -> str:
    tree = ast.parse(text)
    node = list(_nodes(tree))[place]
    changed = _Replace(node, list(_changes(node))[count]).visit(tree)
    return ast.unparse(ast.fix_missing_locations(changed))


def _shown(node: ast.AST) -> str:
    if isinstance(node, ast.If | ast.While):
        return f"if {ast.unparse(node.test)}"
    return (
        ast.unparse(node).split("\n")[0]
        if not isinstance(node, ast.comprehension)
        else (
            f"for {ast.unparse(node.target)} {' '.join('if ' + ast.unparse(i) for i in node.ifs)}"
        )
    )


class _Replace(ast.NodeTransformer):
    def __init__(self, old: ast.AST, new: ast.AST) -> None:
        self.old, self.new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        return self.new if node is self.old else super().visit(node)
