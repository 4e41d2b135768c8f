"""The Hessians of all terms in one sparse symmetric matrix, whose sparsity is kept while it suits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from scipy.sparse import csc_matrix

from ..arrays import Array, Integers, Places, add_up
from ..parts import Entries, Hessian


@dataclass(frozen=True, eq=False)
class Sparsity:
    """Places of the lower triangle, by column and then row: `keys` = column n + row in increasing order."""

    n: int
    keys: Integers

    @property
    def columns(self) -> Integers:
        """Column of each entry; not kept, as it is as large as the values."""
        return self.keys // self.n

    @property
    def rows(self) -> Integers:
        """Row of each entry; not kept."""
        return self.keys % self.n

    @cached_property
    def starts(self) -> Integers:
        """First entry of each column, and the number of entries."""
        return np.searchsorted(self.columns, np.arange(self.n + 1))

    @cached_property
    def _compressed(self) -> tuple[Integers, Integers]:
        # of the type that scipy would convert them to for every matrix
        kind = np.int32 if len(self.keys) < 2**31 else np.int64
        return self.rows.astype(kind), self.starts.astype(kind)

    def places(self, keys: Integers) -> Integers | None:
        """Return the place of each key, one past the last for negative keys; None if one has no place."""
        places, count = np.searchsorted(self.keys, keys), len(self.keys)
        places[keys < 0] = count
        inside = places < count
        if (keys[~inside] >= 0).any() or (self.keys[places[inside]] != keys[inside]).any():
            return None
        return places

    def lower(self, values: Array) -> csc_matrix:
        """Return the lower triangle as a sparse matrix."""
        return csc_matrix((values, *self._compressed), shape=(self.n, self.n))

    def product(self, values: Array) -> Callable[[Array], Array]:
        """Return the product with the symmetric matrix, as a function of x, (n,)."""
        lower = self.lower(values)
        upper, diagonal = lower.T, lower.diagonal()
        return lambda x: np.asarray(lower @ x + upper @ x - diagonal * x)


class Assembler:
    """Adds the Hessians of all terms into one sparse matrix over the free degrees of freedom.

    The sparsity is kept, and with it its symbolic factorisation, as long as it has a place for every entry.
    One that lacks a place is replaced by one with places also for entries expected soon.
    changing: keys that Hessians without constant entries brought in during an earlier run; with the same
    sparsity the same matrix gives the same factors to the last bit.
    """

    def __init__(self, n_dofs: int, fixed: Integers, changing: Integers | None = None) -> None:
        free = np.ones(n_dofs, dtype=bool)
        free[fixed] = False
        self.n_dofs, self.free = n_dofs, np.flatnonzero(free)
        self._number = np.where(free, np.cumsum(free) - 1, -1)
        # of entries that are in use: those of a matrix made anew at each step come and go
        self._constant: WeakKeyDictionary[Entries, _Sorted] = WeakKeyDictionary()
        self._sparsity: Sparsity | None = None
        self._restored = changing
        self.changing = np.zeros(0, dtype=np.int64)

    def assemble(self, hessians: list[Hessian]) -> tuple[Sparsity, Array]:
        """Return the sparsity and the values of the sum of the Hessians; raises ValueError for none."""
        if not hessians:
            raise ValueError("no term of the scene resists deformation; add one such as Elastic(...).")
        places = None if self._sparsity is None else self._places_of(hessians, self._sparsity)
        while self._sparsity is None or places is None:  # twice where a restored sparsity lacks a place, too
            self._sparsity = self._extended(hessians)
            places = self._places_of(hessians, self._sparsity)
        count = len(self._sparsity.keys) + 1  # the last place collects what belongs to fixed unknowns
        values = add_up(places[0], hessians[0].values, count)
        for place, more in zip(places[1:], hessians[1:], strict=True):
            np.add.at(values, place.ravel(), more.values.ravel())
        return self._sparsity, values[:-1]

    def _keys(self, entries: Entries) -> Integers:
        if (entries.rows < entries.columns).any():
            raise ValueError(
                "a Hessian has entries above the diagonal, which would count twice; give those of its lower "
                "triangle, rows >= columns."
            )
        row, column = self._number[entries.rows.ravel()], self._number[entries.columns.ravel()]
        key = np.minimum(row, column) * len(self.free) + np.maximum(row, column)
        key[(row < 0) | (column < 0)] = -1
        return key

    def _places_of(self, hessians: list[Hessian], sparsity: Sparsity) -> list[Places] | None:
        """Return where the entries of each Hessian go, or None if the sparsity lacks a place."""
        found: list[Places] = []
        for hessian in hessians:
            known = self._constant.get(hessian.entries)
            if known is not None:
                found.append(known.places)
                continue
            keys = self._keys(hessian.entries)
            places = sparsity.places(keys)
            if places is None:
                return None
            if hessian.constant:
                different, number = np.unique(keys, return_inverse=True)
                self._constant[hessian.entries] = _Sorted(different, _short(number), _short(places))
            found.append(places)
        return found

    def _extended(self, hessians: list[Hessian]) -> Sparsity:
        """Return a sparsity with a place for every entry, also of constant ones seen before."""
        changing: list[Integers] = []
        new: list[tuple[Entries, Integers, Places]] = []
        for hessian in hessians:
            if hessian.entries in self._constant:
                continue
            keys = self._keys(hessian.entries)
            if hessian.constant:
                new.append((hessian.entries, *np.unique(keys, return_inverse=True)))
                continue
            changing.append(keys)
            if hessian.expected is not None:
                changing.append(self._keys(hessian.expected()))
        if self._restored is not None:
            changing, self._restored = [self._restored], None
        self.changing = _unique(changing)
        new += [(entries, known.keys, known.number) for entries, known in self._constant.items()]
        sparsity = Sparsity(len(self.free), _unique([*(keys for _, keys, _ in new), self.changing]))
        for entries, keys, number in new:
            places = sparsity.places(keys)
            assert places is not None
            self._constant[entries] = _Sorted(keys, _short(number), _short(places[number]))
        return sparsity


@dataclass(frozen=True, eq=False)
class _Sorted:
    """Constant entries: the different keys, the number of each entry's key among them, and its place."""

    keys: Integers
    number: Places
    places: Places


def _short(numbers: Places) -> Places:
    """Return numbers of entries in half the space, where they are not too many."""
    return numbers.astype(np.int32) if numbers.max(initial=0) < 2**31 else numbers


def _unique(keys: list[Integers]) -> Integers:
    """Return the keys of free unknowns, each once, in increasing order."""
    ordered = np.sort(np.concatenate([np.zeros(0, dtype=np.int64), *keys]), kind="stable")  # merges runs
    first = np.ones(len(ordered), dtype=bool)
    first[1:] = ordered[1:] != ordered[:-1]
    return ordered[first & (ordered >= 0)]
