"""Print kernels as straight-line C functions of bounded size.

Statements are in depth-first post-order from the outputs, so that values are used soon after they
are computed (in the order of creation the same code ran 1.3 times slower). A value used once is
part of the expression that uses it. A long kernel is split into several functions, and values used
beyond such a cut are passed in the work array `w`. Compile time therefore grows linearly, and no
function exceeds the capacity of the register allocator.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.emission.print_c import DOUBLES, Numbers, is_number_test
from bgc.emission.windows import pointer_argument, shift_indices
from bgc.ir.graph import Node
from bgc.ir.lowered import SCRATCH, Kernel, Reads, Store
from bgc.record_class import dataclass

_INLINE = 20  # operations of an expression from which it becomes a statement
_LOOP = 8  # number of elements from which a loop copies them
_ARGUMENT = re.compile(r"\b(?:\w+(?=\[)|t\b)")

# As plain ints: comparing with a member of an enumeration takes several times longer.
_CONST, _SYMBOL, _SELECT, _PARAM = int(Op.CONST), int(Op.SYMBOL), int(Op.SELECT), int(Level.PARAM)


@dataclass(frozen=True, slots=True)
class KernelText:
    """The C functions of one kernel, with their scratch memory and number of operations.

    `work` counts the doubles of `w`; `helpers` are the functions to define or declare.
    """

    text: str
    work: int
    operations: int
    helpers: frozenset[str]


@dataclass(frozen=True, slots=True)
class Schedule:
    """Nodes to compute, operands first; `uses` counts the references to each node."""

    order: list[Node]
    uses: dict[Node, int]


def hoisted_nodes(dag: Dag, kernels: Sequence[Kernel]) -> tuple[Node, ...]:
    """The largest subexpressions of parameters in the kernels, in the order of first use."""
    roots = [s.node for k in kernels if k.reads is Reads.HOISTED for s in k.stores]
    op, level, a, b, c = dag.op, dag.level, dag.a, dag.b, dag.c
    found: dict[Node, None] = {}
    seen: set[Node] = set()
    stack = roots[::-1]
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if level[node] <= _PARAM:
            if op[node] != _CONST:
                found[node] = None
        elif op[node] != _SYMBOL:
            if c[node] >= 0:
                stack.append(c[node])
            if b[node] >= 0:
                stack.append(b[node])
            stack.append(a[node])
    return tuple(found)


def print_kernel(
    dag: Dag,
    kernel: Kernel,
    hoisted: dict[Node, int],
    shared: bool = False,
    numbers: Numbers = DOUBLES,
    known: Mapping[Node, str] | None = None,
) -> KernelText:
    """Print a kernel as C; `hoisted` maps a node to its index in h.

    A `shared` kernel is visible to other units; others are static. A kernel that reads parameters
    does not compute the nodes in `known`, which maps them to their text.
    """
    if kernel.reads is Reads.HOISTED:
        floor, leaves = int(Level.PARAM), {n: f"h[{k}]" for n, k in hoisted.items()}
        leaves |= {n: f"{SCRATCH}[{k}]" for k, n in enumerate(kernel.found)}
    else:
        floor, leaves = int(Level.CONST) - 1, dict(known or {})
    stores, finish, reserved = kernel.stores, list[str](), len(kernel.left) + len(kernel.found)
    if kernel.in_place:  # compute all new values before the first is stored
        stores = tuple(Store("w", k, s.node) for k, s in enumerate(stores))
        finish = [f"{s.array}[{s.index}] = w[{k}];" for k, s in enumerate(kernel.stores)]
        reserved = len(finish)
    body = _Body(dag, stores, floor, leaves, reserved=reserved, numbers=numbers)
    return KernelText(
        text=_functions(kernel, body, finish, shared, numbers),
        work=body.work,
        operations=body.operations,
        helpers=frozenset(body.helpers),
    )


def print_defaults(dag: Dag, values: Sequence[tuple[int, Node]]) -> KernelText:
    """Print `defaults`: each parameter follows those on which its default depends."""
    blocks = []
    operations = 0
    helpers: set[str] = set()
    for index, node in by_dependence(dag, values):
        body = _Body(dag, (Store("p", index, node),), int(Level.CONST) - 1, {}, 0, whole=True)
        inner = "\n".join(f"        {line}" for line in body.chunks[0].lines)
        blocks.append(f"    if (!is_set[{index}]) {{\n{inner}\n    }}")
        operations += body.operations
        helpers |= body.helpers
    unused = ["w"] if blocks else ["p", "is_set", "w"]
    lines = [f"    (void){name};" for name in unused] + blocks
    text = (
        "/* Defaults of the parameters that are given by other parameters. */\n"
        "static void model_defaults(double *p, const unsigned char *is_set, double *w)\n"
        "{\n" + "\n".join(lines) + "\n}\n"
    )
    return KernelText(text, 0, operations, frozenset(helpers))


def by_dependence(dag: Dag, values: Sequence[tuple[int, Node]]) -> list[tuple[int, Node]]:
    """Order defaults of parameters, by index, so that each is behind those that it reads."""
    node_of = dict(values)
    ordered: dict[int, Node] = {}

    def place(index: int, under_way: tuple[int, ...]) -> None:
        assert index not in under_way, f"parameter {index} depends on itself"
        for node in dag.reachable([node_of[index]]):
            symbol = dag.symbol_of(node)
            if symbol is not None and symbol.kind is Kind.PARAM:
                other = symbol.index
                if other in node_of and other not in ordered:
                    place(other, (*under_way, index))
        ordered.setdefault(index, node_of[index])

    for index, _ in values:
        place(index, ())
    return list(ordered.items())


def schedule(dag: Dag, roots: Sequence[Node], floor: int, leaves: Set[Node]) -> Schedule:
    """Order what the roots need above the level `floor`, in depth-first post-order."""
    op, level = dag.op, dag.level
    a, b, c = dag.a, dag.b, dag.c
    uses: dict[Node, int] = {}
    order: list[Node] = []
    for root in roots:
        stack = [root]
        while stack:
            node = stack.pop()
            if node < 0:
                order.append(~node)
            elif node in uses:
                uses[node] += 1
            else:
                uses[node] = 1
                if op[node] <= _SYMBOL or level[node] <= floor or node in leaves:
                    continue
                stack.append(~node)
                if c[node] >= 0:
                    stack.append(c[node])
                if b[node] >= 0:
                    stack.append(b[node])
                stack.append(a[node])
    return Schedule(order, uses)


@dataclass(frozen=True, slots=True)
class _Chunk:
    """The statements of one function, and the arguments that they use."""

    lines: list[str]
    used: frozenset[str]


class _Body:
    """The statements of one kernel, split into chunks.

    Nodes at or below the level `floor`, and the nodes in `leaves` (with their text), are not
    computed. The first `reserved` elements of w are not used for intermediate results. `whole`
    prevents splitting.
    """

    def __init__(
        self,
        dag: Dag,
        stores: Sequence[Store],
        floor: int,
        leaves: dict[Node, str],
        reserved: int,
        numbers: Numbers = DOUBLES,
        whole: bool = False,
    ) -> None:
        self._dag = dag
        self._targets: dict[Node, list[str]] = {}
        for store in stores:
            self._targets.setdefault(store.node, []).append(f"{store.array}[{store.index}]")
        planned = schedule(dag, [s.node for s in stores], floor, leaves.keys())
        self._order, self._uses = planned.order, planned.uses
        self.operations = len(self._order)
        self._statement: dict[Node, int] = {}  # node -> chunk of the statement that computes it
        self._limit = len(self._order) + len(stores) + 1 if whole else numbers.part
        self._cut(self._limit)
        self._last: dict[Node, int] = {}  # node -> last chunk that reads it
        self._local: set[Node] = set()  # nodes read in the chunk that computes them
        self._find_crossings()
        self.work = reserved
        self._work_places = self._assign_slots(reserved)
        self._type = numbers.type
        self._printer = numbers.printer(dag, leaves)
        self.chunks = self._print()
        self.helpers = self._printer.helpers

    def _cut(self, limit: int) -> None:
        """Choose the nodes that become statements, and the chunk of each."""
        dag, uses, targets, statement = self._dag, self._uses, self._targets, self._statement
        a, b, c = dag.a, dag.b, dag.c
        conditions = {  # a choice reads its condition twice
            a[n] for n in self._order if dag.op[n] == _SELECT and not is_number_test(dag, a[n])
        }
        tests = self._tests_of_modes()
        size: dict[Node, int] = {}  # operations of a node that is part of a larger expression
        chunk, filled = 0, 0
        for node in self._order:
            n = 1 + size.get(a[node], 0)
            if b[node] >= 0:
                n += size.get(b[node], 0)
                if c[node] >= 0:
                    n += size.get(c[node], 0)
            if node in tests or (
                uses[node] == 1 and n < _INLINE and node not in targets and node not in conditions
            ):
                size[node] = n
                continue
            if filled and filled + n > limit:
                chunk, filled = chunk + 1, 0
            filled += n
            statement[node] = chunk

    def _tests_of_modes(self) -> set[Node]:
        """The tests of modes for NaN that only choices read, which print them in place."""
        dag = self._dag
        tests = {
            dag.a[n]
            for n in self._order
            if dag.op[n] == _SELECT
            and is_number_test(dag, dag.a[n])
            and dag.op[dag.a[dag.a[n]]] == _SYMBOL
        } - self._targets.keys()
        for n in self._order:
            others = dag.operands(n)[1:] if dag.op[n] == _SELECT else dag.operands(n)
            tests.difference_update(others)
        return tests

    def _find_crossings(self) -> None:
        """Find the values that are read in their own chunk, and those read in later ones."""
        dag, statement = self._dag, self._statement
        home: dict[Node, int] = {}  # chunk of the statement that contains an inlined node
        last = self._last
        for node in reversed(self._order):
            chunk = statement[node] if node in statement else home[node]
            for operand in dag.operands(node):
                made = statement.get(operand)
                if made is None:
                    home[operand] = chunk
                elif made == chunk:
                    self._local.add(operand)
                elif chunk > last.get(operand, -1):
                    last[operand] = chunk

    def _assign_slots(self, reserved: int) -> dict[Node, int]:
        """Elements of w for the values that cross a cut, reused after their last reader."""
        work_places: dict[Node, int] = {}
        free: list[int] = []
        ends: dict[int, list[int]] = {}
        present = 0
        for node, chunk in self._statement.items():
            while present < chunk:
                free.extend(ends.pop(present, ()))
                present += 1
            if node in self._last:
                if not free:
                    free.append(self.work)
                    self.work += 1
                work_places[node] = free.pop()
                ends.setdefault(self._last[node], []).append(work_places[node])
        return work_places

    def _print(self) -> list[_Chunk]:
        printer, work_places = self._printer, self._work_places
        chunks: list[_Chunk] = []
        lines: list[str] = []
        crossing: list[Node] = []
        count = 0
        for node, chunk in self._statement.items():
            if chunk != len(chunks):
                chunks.append(_Chunk(lines, frozenset(printer.used)))
                lines = []
                printer.used.clear()
                for other in crossing:  # later chunks read them from w
                    printer.name(other, f"w[{work_places[other]}]")
                crossing = []
            text = printer.expression(node)
            places = list(self._targets.get(node, ()))
            if node in work_places:
                places.append(f"w[{work_places[node]}]")
                crossing.append(node)
            printer.used.update(place[: place.index("[")] for place in places)
            if node in self._local or len(places) > 1:
                count += 1
                printer.name(node, f"v{count}")
                lines.append(f"const {self._type} v{count} = {text};")
                text = f"v{count}"
            lines.extend(f"{place} = {text};" for place in places)
        used = frozenset(printer.used)
        copies = [
            (place, printer.leaf(node))
            for node, places in self._targets.items()
            if node not in self._statement
            for place in places
        ]
        statements = list(_copies(copies))
        room = max(self._limit - len(lines), 0)
        chunks.append(_Chunk(lines + statements[:room], used | _read(statements[:room])))
        for begin in range(room, len(statements), self._limit):
            part = statements[begin : begin + self._limit]
            chunks.append(_Chunk(part, _read(part)))
        return chunks


def _copies(stores: Iterable[tuple[str, str]]) -> Iterator[str]:
    """Statements that store constants and array elements, with loops over consecutive ones.

    Each store is a target and the text of a number or element. Without loops, the thousands of
    statements of a Jacobian with constant entries would take the C compiler seconds.
    """
    runs: list[list[tuple[str, str]]] = []
    expected = None
    for store in sorted(stores, key=lambda s: _element(s[0])):
        if store != expected:
            runs.append([])
        runs[-1].append(store)
        expected = (_next(store[0]), _next(store[1]))
    for run in runs:
        if len(run) < _LOOP:
            yield from (f"{place} = {text};" for place, text in run)
            continue
        (array, first), text = _element(run[0][0]), run[0][1]
        if "[" in text:
            source, begin = _element(text)
            text = f"{source}[k + {begin - first}]".replace("k + -", "k - ").replace(" + 0]", "]")
        yield f"for (int k = {first}; k < {first + len(run)}; k++) {array}[k] = {text};"


def _read(statements: Sequence[str]) -> frozenset[str]:
    """The arguments that statements of `_copies` use."""
    return frozenset(_ARGUMENT.findall("\n".join(statements)))


def _element(text: str) -> tuple[str, int]:
    """The array and the index of `array[index]`."""
    array, _, index = text.partition("[")
    return array, int(index[:-1])


def _next(text: str) -> str:
    """The next array element; a number is returned unchanged."""
    if "[" not in text:
        return text
    array, index = _element(text)
    return f"{array}[{index + 1}]"


def _functions(
    kernel: Kernel, body: _Body, finish: list[str], shared: bool, numbers: Numbers
) -> str:
    """Print one function, or several parts and a function that calls them in turn."""
    results = kernel.results
    names = (*kernel.inputs, *results, "w")
    comment = f"/* {kernel.purpose} */\n"
    own = f"{numbers.prefix}_{kernel.name}"
    head = f"void {numbers.shared}_{kernel.name}" if shared else f"static void {own}"
    if len(body.chunks) == 1:
        chunk = body.chunks[0]
        used = chunk.used.union((*results, "w") if finish else ())
        return comment + _function(
            head, _declared(names, results, numbers), chunk.lines + finish, used
        )
    parts, calls = [], []
    used = frozenset(results)
    for k, chunk in enumerate(body.chunks, 1):
        passed = [name for name in names if name in chunk.used]
        # Parts of an in-place kernel only read its array: new values are kept in w.
        declared = _declared(passed, () if kernel.in_place else results, numbers, "restrict ")
        part = f"{own}_{k}"
        arrays = [name for name in passed if name != "t"]
        lines, places = shift_indices(chunk.lines, arrays, numbers.reach)
        parts.append(_function(f"static void {part}", declared, lines, chunk.used))
        calls.append(f"{part}({', '.join(pointer_argument(name, places) for name in passed)});")
        used |= chunk.used
    parts.append(_function(head, _declared(names, results, numbers), calls + finish, used))
    return comment + "\n".join(parts)


def _declared(
    names: Sequence[str], results: Sequence[str], numbers: Numbers, restrict: str = ""
) -> dict[str, str]:
    """The C declarations of arguments, by name."""
    number = numbers.type
    declared = {}
    for name in names:
        if name == "t":
            declared[name] = f"{number} t"
        elif name == "w" or name in results:
            declared[name] = f"{number} *{restrict}{name}"
        else:
            declared[name] = f"const {number} *{restrict}{name}"
    return declared


def _function(head: str, declared: dict[str, str], lines: Sequence[str], used: Set[str]) -> str:
    """The text of a C function; unused arguments are marked by a cast to void."""
    signature = f"{head}({', '.join(declared.values())})"
    if len(signature) > 100:
        signature = signature.replace("(", "(\n    ", 1)
    unused = ", ".join(f"(void){name}" for name in declared if name not in used)
    statements = [f"{unused};"] if unused else []
    body = "".join(f"    {_fold(line)}\n" for line in [*statements, *lines])
    return f"{signature}\n{{\n{body}}}\n"


def _fold(line: str) -> str:
    """Break a statement at spaces into lines of at most 100 characters."""
    if len(line) <= 96:
        return line
    parts = []
    while len(line) > 96 and (cut := line.rfind(" ", 8, 96)) > 0:
        parts.append(line[:cut])
        line = f"        {line[cut + 1 :]}"
    return "\n    ".join([*parts, line])


def prototype(kernel: Kernel, numbers: Numbers = DOUBLES) -> str:
    """The declaration of a kernel that other units call."""
    declared = _declared((*kernel.inputs, *kernel.results, "w"), kernel.results, numbers)
    return f"void {numbers.shared}_{kernel.name}(\n    {', '.join(declared.values())});\n"
