"""Compare the Python statements of each room with the budget in `statements.toml`.

A room is a folder below `compiler` and `runtime`, or `grammar`; the modules directly in `compiler`
or `runtime` are a room of their own. A statement is a node `ast.stmt`, so that neither comments nor
the breaking of lines count. A room above its budget, or without one, is an error. The budget is
raised by a commit of its own that gives the reason, and lowered by what saves statements.

    python .ci/statements.py          compare; exit status 1 above the budget
    python .ci/statements.py --write  write the present numbers as the budget
"""

from __future__ import annotations

import ast
import sys
import tomllib
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUDGET = Path(__file__).with_suffix(".toml")
HEAD = "# Python statements by room, at most: see statements.py\n"


def count_statements() -> dict[str, int]:
    """Count the statements of each room."""
    rooms: Counter[str] = Counter()
    for top in ("compiler", "grammar", "runtime"):
        for path in sorted((ROOT / top).rglob("*.py")):
            if "node_modules" not in path.parts:
                tree = ast.parse(path.read_text("utf-8"))
                rooms[_room(path)] += sum(isinstance(node, ast.stmt) for node in ast.walk(tree))
    return dict(sorted(rooms.items()))


def _room(path: Path) -> str:
    return "/".join(path.relative_to(ROOT).parts[:-1][:2])


def main(arguments: list[str]) -> int:
    """Compare with the budget, or write it; return the exit status."""
    found = count_statements()
    if arguments == ["--write"]:
        rows = "".join(f'"{room}" = {number}\n' for room, number in found.items())
        BUDGET.write_text(HEAD + rows, "utf-8")
        return 0
    budget: dict[str, int] = tomllib.loads(BUDGET.read_text("utf-8"))
    above = [
        f"{room}: {number} statements, budget {budget.get(room, 0)}"
        for room, number in found.items()
        if number > budget.get(room, 0)
    ]
    gone = [f"{room}: has a budget but no modules" for room in sorted(budget.keys() - found)]
    print("\n".join([*above, *gone, f"{sum(found.values())} of {sum(budget.values())} statements"]))
    return 1 if above or gone else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
