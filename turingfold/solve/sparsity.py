"""The entries of all terms gathered into one sparse symmetric pattern, kept while it has a place for each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix

from ..arrays import Array, Integers, add_up
from ..parts import Hessian


@dataclass(frozen=True, eq=False)
class Pattern:
    """Places of the lower triangle, by column and then row: `keys` = column n + row in increasing order."""

    n: int
    keys: Integers

    @cached_property
    def columns(self) -> Integers:
        """Column of each entry."""
        return self.keys // self.n

    @cached_property
    def rows(self) -> Integers:
        """Row of each entry."""
        return self.keys % self.n

    @cached_property
    def starts(self) -> Integers:
        """First entry of each column, and the number of entries."""
        return np.searchsorted(self.columns, np.arange(self.n + 1))

    @cached_property
    def _places(self) -> tuple[Integers, Integers]:
        # of the type that scipy would convert them to for every matrix
        kind = np.int32 if len(self.keys) < 2**31 else np.int64
        return self.rows.astype(kind), self.starts.astype(kind)

    @cached_property
    def _diagonal(self) -> Integers:
        return np.flatnonzero(self.rows == self.columns)

    def lower(self, values: Array) -> csc_matrix:
        """Return the lower triangle as a sparse matrix."""
        return csc_matrix((values, *self._places), shape=(self.n, self.n))

    def times(self, values: Array, x: Array) -> Array:
        """Return the product of the symmetric matrix with x."""
        lower, on = self.lower(values), self._diagonal
        product = np.asarray(lower @ x + lower.T @ x)
        product[self.rows[on]] -= values[on] * x[self.rows[on]]
        return product


class Gatherer:
    """Adds the Hessians of all terms into one pattern over the free degrees of freedom.

    The pattern is kept, and with it its symbolic factorisation, as long as it has a place for every entry.
    A pattern that lacks one is replaced by one with room for entries expected soon.
    places: keys that passing Hessians brought into the pattern of an earlier run; with the same pattern the
    same matrix gives the same factors to the last bit.
    """

    def __init__(self, n_dofs: int, fixed: Integers, places: Integers | None = None) -> None:
        free = np.ones(n_dofs, dtype=bool)
        free[fixed] = False
        self.n_dofs, self.free = n_dofs, np.flatnonzero(free)
        self._number = np.where(free, np.cumsum(free) - 1, -1)
        # by id(rows): rows, the different keys, the number of each entry's key among them, and its place
        self._lasting: dict[int, tuple[Integers, Integers, Integers, Integers]] = {}
        self._pattern: Pattern | None = None
        self._restored = places
        self.places = np.zeros(0, dtype=np.int64)

    def gather(self, hessians: list[Hessian]) -> tuple[Pattern, Array]:
        """Return the pattern and the values of the sum of the Hessians; raises ValueError for none."""
        if not hessians:
            raise ValueError("no term of the scene resists deformation; add one such as Elastic(...).")
        slots = self._slots(hessians) if self._pattern is not None else None
        while slots is None:
            self._make_room(hessians)
            slots = self._slots(hessians)
        assert self._pattern is not None
        count = len(self._pattern.keys) + 1  # the last place collects what belongs to fixed unknowns
        values = add_up(slots[0], hessians[0].values, count)
        for places, more in zip(slots[1:], hessians[1:], strict=True):
            np.add.at(values, places.ravel(), more.values.ravel())
        return self._pattern, values[:-1]

    def _keys(self, rows: Integers, columns: Integers) -> Integers:
        row, column = self._number[rows.ravel()], self._number[columns.ravel()]
        key = np.minimum(row, column) * len(self.free) + np.maximum(row, column)
        key[(row < 0) | (column < 0)] = -1
        return key

    def _slots(self, hessians: list[Hessian]) -> list[Integers] | None:
        """Return where the entries of each Hessian go, or None if the pattern lacks a place."""
        found = []
        for hessian in hessians:
            known = self._lasting.get(id(hessian.rows))
            if known is None:
                if hessian.lasting:
                    return None
                slots = self._places(self._keys(hessian.rows, hessian.columns))
                if slots is None:
                    return None
                found.append(slots)
            else:
                found.append(known[3])
        return found

    def _places(self, keys: Integers) -> Integers | None:
        assert self._pattern is not None
        known = self._pattern.keys
        slots = np.searchsorted(known, keys)
        outside = keys < 0
        if not (known[np.minimum(slots, len(known) - 1)] == keys)[~outside].all():
            return None
        slots[outside] = len(known)
        return slots

    def _make_room(self, hessians: list[Hessian]) -> None:
        """Build a pattern with a place for every entry, also of lasting Hessians seen before, and room."""
        passing = []
        for hessian in hessians:
            if id(hessian.rows) in self._lasting:
                continue
            keys = self._keys(hessian.rows, hessian.columns)
            if hessian.lasting:
                different, number = np.unique(keys, return_inverse=True)
                self._lasting[id(hessian.rows)] = hessian.rows, different, number, number
            else:
                passing.append(keys)
                if hessian.room is not None:
                    passing.append(self._keys(*hessian.room()))
        if self._restored is not None:
            passing, self._restored = [self._restored], None
        self.places = _unique(passing)
        lasting = [different for _, different, _, _ in self._lasting.values()]
        self._pattern = Pattern(len(self.free), _unique([*lasting, self.places]))
        for mark, (rows, different, number, _) in list(self._lasting.items()):
            slots = self._places(different)
            assert slots is not None
            self._lasting[mark] = rows, different, number, slots[number]


def _unique(keys: list[Integers]) -> Integers:
    """Return the keys of free unknowns, each once, in increasing order."""
    ordered = np.sort(np.concatenate([np.zeros(0, dtype=np.int64), *keys]), kind="stable")  # merges runs
    first = np.ones(len(ordered), dtype=bool)
    first[1:] = ordered[1:] != ordered[:-1]
    return ordered[first & (ordered >= 0)]
