"""Outlines from segmented images of brains in the NIfTI format."""

from __future__ import annotations

import zlib
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import file_path, finite, one_of, whole

SECTIONS = {"sagittal": 0, "coronal": 1, "axial": 2}  # the axis across them, of right, anterior, superior
UNITS = {"meter": 1.0, "mm": 1e-3, "micron": 1e-6, "unknown": 1e-3}


def mask_outline(
    path: str | Path, *, section: str = "coronal", index: int | None = None, level: float = 0.5
) -> Array:
    """Return the longest closed curve (2, n) at a level of a section of an image; m.

    section: "coronal" (x to the right, y up), "sagittal" (x forward, y up) or "axial" (x to the right, y
    forward), in the image's orientation turned to right, anterior, superior.
    index: of the section, counted from left, back or bottom; left out: that with most voxels above `level`.
    A section is a plane of voxels: an image that is oblique to the scanner has sections as oblique, named by
    the closest axes.
    The curve runs between voxel centres, so that of a 0-1 mask has steps: give `outline` a `smooth` of some
    voxels. A file that states no unit of length is taken to be in mm.
    Raises ValueError for files, sections and levels without such a curve, for a section with values that are
    not finite, and where nibabel (the extra `images`) is missing.
    """
    one_of("section", section, tuple(SECTIONS))
    finite("level", level)
    file = file_path("path", path, "an image")
    image, voxels = _image(file)
    across = SECTIONS[section]
    voxels = np.moveaxis(voxels, across, 0)
    known = f"the image has {section} sections 0 to {len(voxels) - 1}"
    if index is None and not (voxels > level).any():
        raise ValueError(
            f"level={level:g}: no voxel is above it, {file} has values from {np.nanmin(voxels):g} to "
            f"{np.nanmax(voxels):g}; choose a level between."
        )
    if index is None:
        index = int(np.argmax((voxels > level).sum((1, 2))))
    if whole("index", index, at_least=0, remedy=known) >= len(voxels):
        raise ValueError(f"index={index}: {known}.")
    if unknown := int((~np.isfinite(voxels[index])).sum()):
        raise ValueError(
            f"{file}: {unknown} voxels of {section} section {index} are not finite; give them the value "
            "outside the brain, or choose another section."
        )
    from contourpy import contour_generator

    outside = 0.0 if level > 0 else level - 1.0
    plane = np.pad(voxels[index], 1, constant_values=outside)  # so that every curve closes
    lines: Any = contour_generator(z=plane.T).lines(level)
    if not lines:
        raise ValueError(
            f"level={level:g}: the {section} section {index} has values from {voxels[index].min():g} to "
            f"{voxels[index].max():g}; choose a level between, or another section."
        )
    edges = np.delete(np.asarray(image.header.get_zooms()[:3], dtype=float), across)
    unit = UNITS[image.header.get_xyzt_units()[0]]
    curves = [unit * edges[:, None] * line.T for line in lines]
    return np.asarray(max(curves, key=lambda curve: float(np.hypot(*np.diff(curve)).sum()))[:, :-1])


def _image(file: Path) -> tuple[Any, Array]:
    """Return a three-dimensional image turned to right, anterior, superior, and its voxels."""
    try:
        nibabel: Any = import_module("nibabel")
    except ImportError as error:
        raise ValueError(
            f"{file.name} needs nibabel, which is missing: pip install 'turingfold[images]'."
        ) from error
    try:
        image = nibabel.load(file)
    except (nibabel.filebasedimages.ImageFileError, EOFError, zlib.error) as error:
        raise ValueError(f"{file.name} is no image that nibabel reads: {error}.") from error
    if not isinstance(image, nibabel.Nifti1Pair) or len(image.shape) != 3:
        kind = type(image).__name__
        raise ValueError(f"{file.name}: {kind} of shape {image.shape}; give a NIfTI image with three axes.")
    turned = nibabel.as_closest_canonical(image)
    try:
        return turned, np.asarray(turned.dataobj, dtype=float)
    except (EOFError, OSError, zlib.error, ValueError) as error:
        raise ValueError(
            f"{file.name} is damaged or cut short ({error}); copy or download it again."
        ) from error
