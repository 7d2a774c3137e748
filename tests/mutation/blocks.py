"""Number the blocks of a Python text: function bodies, branches, loops, handlers, cases.

A branch that is not written, such as the `else` of a plain `if`, counts as a block.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

_LISTS = ("body", "orelse", "finalbody")


def block_lists(tree: ast.Module) -> Iterator[tuple[ast.AST, str]]:
    """Each node with a block and the name of the field that holds it, in a fixed order."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef):
            continue
        for name in _LISTS:
            block = getattr(node, name, None)
            if isinstance(block, list) and (block or (isinstance(node, ast.If))):
                yield node, name


def spans(text: str) -> list[tuple[int, int]]:
    """First and last line of each block; (0, 0) of one that is not written."""
    found = []
    for node, name in block_lists(ast.parse(text)):
        block = getattr(node, name)
        found.append((block[0].lineno, block[-1].end_lineno) if block else (0, 0))
    return found


def marked(text: str, first: int) -> ast.Module:
    """The tree of a text in which each block marks its number, from `first` on."""
    tree = ast.parse(text)
    for number, (node, name) in enumerate(list(block_lists(tree)), first):
        block = getattr(node, name)
        place = 0
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and ast.get_docstring(node):
            place = 1
        (mark,) = ast.parse(f"__hits__[{number}] = 1").body
        at = block[min(place, len(block) - 1)] if block else node
        for each in ast.walk(mark):
            if hasattr(each, "lineno"):
                ast.copy_location(each, at)
                each.end_lineno, each.end_col_offset = each.lineno, each.col_offset  # type: ignore[attr-defined]
        block.insert(place, mark)
    (given,) = ast.parse("from sitecustomize import hits as __hits__").body
    place = 0
    for k, node in enumerate(tree.body):
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        future = isinstance(node, ast.ImportFrom) and node.module == "__future__"
        if docstring or future:
            place = k + 1
        else:
            break
    tree.body.insert(place, given)
    return ast.fix_missing_locations(tree)
