"""The share of each tissue in the voxels of images: labels, masks, and maps of probability."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..arrays import Array, Integers
from ..checks import whole
from .image import PLANES, Image, read_image

NAMES = ("gray", "white", "hole")
SHOWN = 12  # labels listed in a message
LEAST = -(2**31)  # of all labels
FRAME = 0.5  # of the edges of planes: what fills more is what is round the brain
MANY = 1_000_000  # labels that are counted one by one

Labels = int | Sequence[int] | None


@dataclass(frozen=True)
class Tissue:
    """A tissue of an image: `share` turns values of voxels into what part of each it fills, 0 to 1.

    level: of the share on the tissue's surface.
    """

    image: Image
    share: Callable[[Any], Any]
    level: float = 0.5

    def at(self, plane: str, index: int) -> Array:
        """Return the shares in a plane of voxels; ValueError if values there are not finite."""
        values = np.moveaxis(self.image.values, PLANES[plane], 0)[index]
        if unknown := int((~np.isfinite(values)).sum()):
            raise ValueError(
                f"{self.image.source}: {unknown} voxels of {plane} plane {index} are not finite; give them "
                "the value outside the brain, or choose another plane."
            )
        return np.asarray(self.share(values), dtype=float)


def tissues_of(
    image: Any, plane: str, pixel_mm: float | None, wanted: Mapping[str, Labels], level: float | None
) -> dict[str, Tissue]:
    """Return the tissues of an image, or of a mapping of images, by name; "gray" is always among them.

    wanted: the labels of each tissue, or the numbers of its maps where the image has four axes.
    Raises ValueError for labels that the image does not have, and for an image of which none are named though
    it has several.
    """
    labels = {name: _labels(name, given) for name, given in wanted.items() if given is not None}
    if isinstance(image, Mapping):
        if labels or level is not None:
            raise ValueError("labels and level are for one image; a mapping holds a map of probability each.")
        return _maps({name: read_image(item, plane, pixel_mm) for name, item in image.items()}, plane)
    read = read_image(image, plane, pixel_mm)
    if not labels:
        return {"gray": _map(read, level, plane)}
    if "gray" not in labels:
        raise ValueError(f"gray is missing beside {' and '.join(labels)}; give its labels, too.")
    if level is not None:
        raise ValueError(f"level={level:g}: labels are inside or outside; leave it out.")
    several = read.values.ndim == 4
    usable = several or _are_whole(read.values)
    for name, each in labels.items():
        for label in each.tolist():
            if several and not 0 <= label < read.values.shape[3]:
                raise ValueError(
                    f"{name}={label}: {read.source} has the maps 0 to {read.values.shape[3] - 1}."
                )
            if not several and not (usable and (read.values == label).any()):
                raise ValueError(
                    f"{name}={label}: {read.source} holds {_listed(_whole_values(read.values))}."
                )
    used = np.concatenate(list(labels.values()))
    if len(np.unique(used)) < len(used):
        raise ValueError("gray, white and hole share a label; each label belongs to one tissue.")
    share = _sum_of_maps if several else _is_one_of
    return {name: Tissue(read, partial(share, each)) for name, each in labels.items()}


def _labels(name: str, given: Any) -> Integers:
    several = list(given) if np.iterable(given) and not isinstance(given, str) else [given]
    if not several:
        raise ValueError(f"{name} is an empty list; give its labels, or leave it out.")
    return np.array([whole(name, label, at_least=LEAST) for label in several])


def _is_one_of(labels: Integers, values: Any) -> Any:
    return np.isin(values, labels)


def _sum_of_maps(numbers: Integers, values: Any) -> Any:
    return values[..., numbers].sum(axis=-1)


def _maps(images: Mapping[str, Image], plane: str) -> dict[str, Tissue]:
    """Return the tissues of which each image is a map of probability."""
    if not {"gray"} <= set(images) <= set(NAMES):
        raise ValueError(f"the names of images are gray, white and hole, not {', '.join(images)}.")
    first = images["gray"]
    for name, item in images.items():
        same = item.values.shape == first.values.shape
        if not (same and np.allclose(item.affine, first.affine, rtol=1e-4, atol=1e-6)):
            raise ValueError(f"the images of gray and {name} have other voxels; bring them to one grid.")
    return {name: _map(item, None, plane, name) for name, item in images.items()}


def _map(image: Image, level: float | None, plane: str, name: str = "") -> Tissue:
    """Return the tissue of which an image is the mask or the map of probability.

    Of the two values of a mask the higher one is tissue; of one that is alone the lower, where the higher
    fills most of the edges of the planes.
    name: of one of several images, which are taken as they are.
    """
    values, source = image.values, image.source
    if values.ndim != 3:
        raise ValueError(f"{source} has shape {values.shape}; say which map is which, such as gray=0.")
    known = _whole_values(values)
    some = values[np.isfinite(values)] if known is None else known
    low, high = float(some.min(initial=np.inf)), float(some.max(initial=-np.inf))
    if not low < high or (level is not None and not low <= level < high):
        shown = "" if level is None else f"level={level:g}: "
        raise ValueError(f"{shown}{source} has values from {low:g} to {high:g}; the level must lie between.")
    mask = known is not None and len(known) == 2
    if mask and not name:
        filled = _of_edges(values == high, plane)
        if filled > FRAME:
            warnings.warn(
                f"{source}: the value {high:g} fills {filled:.0%} of the image's edges, so "
                f"that {low:g} is taken as tissue; if {high:g} is, give gray={high:g}.",
                stacklevel=4,
            )
        return Tissue(image, partial(np.equal, low if filled > FRAME else high))
    if known is not None and level is None and not mask:
        raise ValueError(f"{source} holds {_listed(known)}; name those of gray, white and hole.")
    if level is None and not mask and not (low >= -1e-3 and high <= 1.001):
        raise ValueError(
            f"{source} has values from {low:g} to {high:g}: neither labels nor probabilities; give a level."
        )
    least = low if mask else 0.5 if level is None else level
    filled = _of_edges(values > least, plane)
    if filled > FRAME:
        remedy = f"{low + high if mask else 1:g} minus it as {name}" if name else "its negative"
        warnings.warn(
            f"{source}: values above the level {least:g} fill {filled:.0%} of the image's "
            f"edges, so that the outline follows them. Where tissue has the lower values, give {remedy}.",
            stacklevel=4,
        )
    return Tissue(image, np.asarray, least) if known is None else Tissue(image, partial(np.less, least))


def _of_edges(tissue: Any, plane: str) -> float:
    """Return which share of the edges of planes tissue fills; 0 unless it reaches all sides of the image."""
    sides = [[tissue.take(end, axis=axis) for end in (0, -1)] for axis in range(3)]
    if not all(side.any() for pair in sides for side in pair):
        return 0.0
    edges = [side.ravel() for axis, pair in enumerate(sides) if axis != PLANES[plane] for side in pair]
    return float(np.mean(np.concatenate(edges)))


def _are_whole(values: Any) -> bool:
    """Return whether all values that are finite are whole numbers."""
    return values.dtype.kind in "bui" or bool(((values == np.round(values)) | ~np.isfinite(values)).all())


def _whole_values(values: Any) -> Array | None:
    """Return the different values of an image of whole numbers, or None for others."""
    if not _are_whole(values):
        return None
    values = values.ravel(order="K")
    values = values if values.dtype.kind in "bui" else values[np.isfinite(values)]
    low, high = (int(values.min()), int(values.max())) if values.size else (0, 0)
    if high - low > MANY:
        return np.unique(values).astype(float)
    return np.asarray(np.flatnonzero(np.bincount(values.astype(np.int64) - low)) + low, dtype=float)


def _listed(values: Array | None) -> str:
    if values is None:
        return "fractions, no labels"
    shown = ", ".join(f"{value:g}" for value in values[:SHOWN])
    return "the labels " + shown + (f", ... {values[-1]:g}" if len(values) > SHOWN else "")
