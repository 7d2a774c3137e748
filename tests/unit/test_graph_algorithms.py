"""Disjoint sets, matching, strong components and cycles, against SciPy and by definition."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from bgc.algebra.disjoint_sets import DisjointSets, Joined
from bgc.algebra.matching import Matching, match
from bgc.algebra.strong_components import strong_components, vertices_on_cycles

SIZE = 9
vertices = st.integers(0, SIZE - 1)
edges = st.lists(st.tuples(vertices, vertices), max_size=25)


def matrix(pairs: list[tuple[int, int]]) -> csr_array:
    dense = np.zeros((SIZE, SIZE), dtype=int)
    for a, b in pairs:
        dense[a, b] = 1
    return csr_array(dense)


# --- disjoint sets ----------------------------------------------------------------------------


@given(edges)
def test_sets_are_the_connected_parts(pairs: list[tuple[int, int]]) -> None:
    sets = DisjointSets(SIZE)
    for a, b in pairs:
        apart = sets.find(a) != sets.find(b)
        assert sets.unite(a, b) == apart
    count, label = connected_components(matrix(pairs), directed=False)
    groups = sets.groups()
    assert len(groups) == count
    assert sorted(x for group in groups for x in group) == list(range(SIZE))
    for group in groups:
        assert len({label[x] for x in group}) == 1
        assert {sets.find(x) for x in group} == {min(group)}
    assert [group[0] for group in groups] == sorted(group[0] for group in groups)


def test_groups_of_some_items_leave_the_others_out() -> None:
    sets = DisjointSets(6)
    sets.join([0, 4, 2])
    sets.join([])
    sets.join([3, 5])
    assert sets.groups([5, 2, 1, 0]) == [[5], [2, 0], [1]]


@dataclass(slots=True, eq=False)
class Item(Joined):
    name: str = ""


def test_joined_objects_have_one_root() -> None:
    items = [Item(str(k)) for k in range(20)]
    for k in range(0, 20, 2):
        items[k].absorb(items[k + 1])
    for k in range(16, 0, -2):
        items[k].root().absorb(items[k + 2].root())
    assert {item.root().name for item in items[2:]} == {"2"}
    assert items[1].root() is items[0]
    with pytest.raises(AssertionError):
        items[2].absorb(items[2])


# --- matching ---------------------------------------------------------------------------------


@given(edges)
def test_matchings_are_as_large_as_those_of_scipy(pairs: list[tuple[int, int]]) -> None:
    candidates: list[list[int]] = [[] for _ in range(SIZE)]
    for row, column in pairs:
        candidates[row].append(column)
    expected = int((maximum_bipartite_matching(matrix(pairs), perm_type="column") >= 0).sum())
    start = {k: k for k in range(SIZE) if k in candidates[k]}
    for given_ in ({}, start):
        found = match(candidates, given_)
        assert len(found) == len(set(found.values())) == expected
        assert all(column in candidates[row] for row, column in found.items())
        assert set(given_) <= set(found)  # a row that is matched stays matched


def test_a_row_prefers_its_first_free_column() -> None:
    matching = Matching({0: 0})
    assert matching.augment(1, [[0, 1], [2, 1]].__getitem__)
    assert matching.column_of == {0: 0, 1: 2} and matching.row_of == {0: 0, 2: 1}
    assert not matching.augment(2, lambda row: {0: [0], 1: [2], 2: [0, 2]}[row])


# --- strong components ------------------------------------------------------------------------


@given(edges)
def test_components_are_those_of_scipy_and_come_in_order(pairs: list[tuple[int, int]]) -> None:
    needs: list[list[int]] = [[] for _ in range(SIZE)]
    for a, b in pairs:
        needs[a].append(b)
    _, label = connected_components(matrix(pairs), connection="strong")
    done: dict[int, int] = {}
    for root in range(SIZE):
        if root in done:
            continue
        for number, (members, has_cycle) in enumerate(
            strong_components(root, needs.__getitem__, done.__contains__), start=len(done)
        ):
            assert {x for x in range(SIZE) if label[x] == label[members[0]]} == set(members)
            assert has_cycle == (len(members) > 1 or members[0] in needs[members[0]])
            outside = {b for x in members for b in needs[x]} - set(members)
            assert outside <= done.keys()
            done |= dict.fromkeys(members, number)
    assert done.keys() == set(range(SIZE))


def test_needs_may_depend_on_what_was_made_of_earlier_ones() -> None:
    value: dict[str, int] = {}

    def needs(vertex: str) -> Iterator[str]:
        if vertex == "a":
            yield "b"
            yield "c" if value["b"] == 1 else "d"

    for number, (members, has_cycle) in enumerate(
        strong_components("a", needs, value.__contains__), start=1
    ):
        assert not has_cycle
        value[members[0]] = number
    assert value == {"b": 1, "c": 2, "a": 3}


# --- cycles -----------------------------------------------------------------------------------


@given(edges, st.sets(vertices, min_size=1), st.sets(vertices, max_size=2))
def test_vertices_are_taken_so_that_no_cycle_is_left(
    pairs: list[tuple[int, int]], candidates: set[int], chosen: set[int]
) -> None:
    needs: dict[int, list[int]] = {k: [] for k in range(SIZE)}
    for a, b in pairs:
        if a < b or {a, b} & candidates:  # all others lie on no cycle
            needs[a].append(b)
    taken = vertices_on_cycles(sorted(candidates), needs.__getitem__, chosen)
    assert chosen <= taken <= candidates | chosen
    left = matrix([(a, b) for a in needs for b in needs[a] if not {a, b} & taken])
    assert not np.trace(np.linalg.matrix_power(np.eye(SIZE) + left, SIZE) - np.eye(SIZE))


def test_cycles_that_share_vertices_are_cut_in_polynomial_time() -> None:
    """Layers of two, each joined to the next: as many cycles as numbers of as many bits."""
    layers = 40
    last, asked = 2 * layers, [0] * (2 * layers + 2)

    def needs(vertex: int) -> list[int]:
        asked[vertex] += 1
        if vertex >= last:
            return [0, 1]
        below = vertex // 2 * 2 + 2
        return [below, below + 1]

    taken = vertices_on_cycles([last, last + 1], needs, ())
    assert taken == {last, last + 1}
    assert max(asked) <= 1 + len(taken)
