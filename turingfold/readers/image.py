"""Images of labels or probabilities, turned to right, anterior, superior, and their planes of voxels."""

from __future__ import annotations

import os
import warnings
import zlib
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..arrays import Array
from ..checks import file_path, finite_array, positive, real_array

PLANES = {"sagittal": 0, "coronal": 1, "axial": 2}  # the axis across them, of right, anterior, superior
FEWEST, SLAB = 8, 4  # voxels across a section; times as many along a slab as it has planes
UNITS = {0: 1e-3, 1: 1.0, 2: 1e-3, 3: 1e-6}  # NIfTI's codes of lengths: unknown, metre, mm, micron
PICTURES = (".png", ".tif", ".tiff", ".bmp", ".gif", ".jpg", ".jpeg")
DAMAGE = (EOFError, OSError, zlib.error, ValueError, TypeError, OverflowError)


@dataclass(frozen=True, eq=False)
class Image:
    """Voxels whose axes run to the right, to anterior and to superior, more or less.

    values: (n_right, n_anterior, n_superior), or with a fourth axis of tissues, each a map of probability.
    affine: (4, 4), from voxel numbers to places; m.
    placed: the affine says where the voxels are, not only how large.
    """

    values: Any
    affine: Array
    source: str
    placed: bool = True

    def frame(self, plane: str, index: int) -> tuple[Array, Array]:
        """Return the place of the first voxel of a plane, (2,), and a voxel's edges, columns of (2, 2); m.

        Their axes are orthonormal, the first along the first edge: where the voxels are aligned with right,
        anterior and superior, places are just these coordinates.
        """
        edges = np.delete(self.affine[:3, :3], PLANES[plane], axis=1)
        axes, _ = np.linalg.qr(edges)
        axes = axes * np.sign(np.sum(axes * edges, axis=0))
        first = self.affine[:3, 3] + index * self.affine[:3, PLANES[plane]]
        return axes.T @ first, axes.T @ edges

    def position(self, plane: str, index: int) -> float:
        """Return where a plane of voxels is along its normal; m."""
        step = self.affine[:3, PLANES[plane]]
        normal = np.cross(*np.delete(self.affine[:3, :3], PLANES[plane], axis=1).T)
        normal *= np.sign(normal @ step) / np.linalg.norm(normal)
        return float(normal @ (self.affine[:3, 3] + index * step))


def read_image(image: Any, plane: str, pixel_mm: float | None) -> Image:
    """Return an image from a path, a nibabel image, or a pair (array, affine in mm).

    Pictures and arrays with two axes are a section by themselves, rows from top to bottom, of a given pixel.
    Raises ValueError for files, arrays and affines that cannot be used, where nibabel is missing, and for a
    slab that the plane cuts edge-on.
    """
    found = _read(image, plane, pixel_mm)
    _refuse_edge_on(found, plane)
    return found


def _read(image: Any, plane: str, pixel_mm: float | None) -> Image:
    if isinstance(image, tuple) and len(image) == 2:
        values, affine = real_array("image", image[0]), finite_array("the affine", image[1], (4, 4))
        return _turned(values, affine * _scale(1e-3), "the array")
    if isinstance(image, np.ndarray):
        return _picture(image, plane, pixel_mm, "the array")
    if hasattr(image, "dataobj") and hasattr(image, "affine"):
        return _from_nibabel(image, "the image")
    file = file_path("image", image, "an image") if isinstance(image, str | os.PathLike) else None
    if file is None:
        raise ValueError(f"image={image!r} must be a path, a nibabel image, or a pair (array, affine in mm).")
    if file.suffix.lower() in PICTURES:
        return _picture(_pixels(file), plane, pixel_mm, file.name)
    if pixel_mm is not None:
        raise ValueError(f"pixel_mm={pixel_mm!r}: {file.name} states the size of its voxels; leave it out.")
    return _from_nibabel(_loaded(file), file.name)


def _refuse_edge_on(image: Image, plane: str) -> None:
    """Raise ValueError for a plane whose sections are few voxels high, of an image of few other planes."""
    counts = dict(zip(PLANES, image.values.shape, strict=False))
    few = min(counts, key=counts.__getitem__)
    across = [count for name, count in counts.items() if name != few]
    if few == plane or counts[few] >= FEWEST or min(across) < SLAB * counts[few]:
        return
    first, last = (1e3 * image.position(few, k) for k in (0, counts[few] - 1))
    raise ValueError(
        f"plane={plane!r}: {image.source} has {counts[few]} {few} planes of {across[0]} by {across[1]} "
        f"voxels, so that a {plane} section would be {counts[few]} voxels high, and it must be at least "
        f"{FEWEST}. Give plane={few!r}; the image has such planes at {first:g} to {last:g} mm."
    )


def nibabel_for(file: Path) -> Any:
    """Return the library that reads a file; raises ValueError, with the remedy, where it is missing."""
    try:
        return import_module("nibabel")
    except ImportError as error:
        raise ValueError(
            f"{file.name} needs nibabel, which is missing: pip install 'turingfold[images]'."
        ) from error


def _loaded(file: Path) -> Any:
    nibabel = nibabel_for(file)
    try:
        return nibabel.load(file)
    except (nibabel.filebasedimages.ImageFileError, nibabel.spatialimages.HeaderDataError, *DAMAGE) as error:
        raise ValueError(f"{file.name} is no image that nibabel reads: {error}.") from error


def _from_nibabel(image: Any, source: str) -> Image:
    """Return an image of nibabel's with the unit of its header; a NIfTI that states none is in mm."""
    header = image.header
    unit = 1e-3
    if "xyzt_units" in getattr(header, "keys", list)():
        code = int(header["xyzt_units"]) % 8
        if code not in UNITS:
            raise ValueError(
                f"{source}: xyzt_units has the code {code} for lengths, which NIfTI does not know; set it to "
                "1 (m), 2 (mm) or 3 (micron)."
            )
        unit = UNITS[code]
    if image.affine is None or len(image.shape) not in (3, 4):
        kind = type(image).__name__
        raise ValueError(f"{source}: {kind} of shape {image.shape}; give an image of voxels with three axes.")
    if image.get_data_dtype().names:
        raise ValueError(f"{source} holds colours ({image.get_data_dtype()}); give labels or probabilities.")
    try:
        values = np.asanyarray(image.dataobj)
    except DAMAGE as error:
        raise ValueError(f"{source} is damaged or cut short ({error}); copy or download it again.") from error
    return _turned(values, np.asarray(image.affine, dtype=float) * _scale(unit), source)


def _scale(unit: float) -> Array:
    """Return factors for an affine, (4, 1), whose places are in a unit given in m."""
    return np.array([[unit], [unit], [unit], [1.0]])


def _turned(values: Any, affine: Array, source: str) -> Image:
    """Return an image with its axes exchanged and reversed so that they run to right, anterior, superior."""
    if values.ndim == 4 and values.shape[3] == 1:
        values = values[..., 0]
    if values.ndim not in (3, 4) or 0 in values.shape:
        raise ValueError(f"{source} has shape {values.shape}; give an image of voxels with three axes.")
    edges = affine[:3, :3]
    lengths = np.linalg.norm(edges, axis=0)
    if not np.isfinite(affine).all() or not abs(np.linalg.det(edges)) > 1e-6 * lengths.prod() > 0:
        raise ValueError(
            f"{source}: its affine does not place the voxels in space (edges of {lengths * 1e3} mm, in rows "
            f"{edges.tolist()}); repair its sform or qform."
        )
    _, order = linear_sum_assignment(-np.abs(edges / lengths))
    values = values.transpose(*order, *range(3, values.ndim))
    affine = affine[:, [*order, 3]]
    for axis in range(3):
        if affine[axis, axis] < 0:
            values = np.flip(values, axis)
            affine[:, 3] += affine[:, axis] * (values.shape[axis] - 1)
            affine[:, axis] *= -1
    return Image(values, affine, source)


def _pixels(file: Path) -> Any:
    """Return the pixels of a picture, ([frames,] rows, columns), turned upright as its EXIF data say.

    Of a picture with a list of colours, they are the numbers in it.
    """
    from PIL import Image as Pictures
    from PIL import ImageOps, ImageSequence, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Pictures.DecompressionBombWarning)  # of 9e7 pixels and more
            # from a stream: of a path, Pillow maps the file into memory, and then turns a plain TIFF wrongly
            with file.open("rb") as stream, Pictures.open(stream) as picture:
                upright = map(ImageOps.exif_transpose, ImageSequence.Iterator(picture))
                frames = [np.asarray(frame) for frame in upright]
    except (
        UnidentifiedImageError,
        Pictures.DecompressionBombError,
        Pictures.DecompressionBombWarning,
        SyntaxError,
        *DAMAGE,
    ) as error:
        raise ValueError(f"{file.name} is no picture that can be read ({error}).") from error
    pixels = np.stack(frames) if len(frames) > 1 else frames[0]
    if pixels.ndim == 2 + (len(frames) > 1):
        return pixels
    gray, others = pixels[..., :1], pixels[..., : 3 if pixels.shape[-1] > 2 else 1]
    if (gray != others).any() or (pixels.shape[-1] in (2, 4) and (pixels[..., -1] != pixels.max()).any()):
        raise ValueError(
            f"{file.name} holds colours or transparency; save it in gray, with a value for each tissue."
        )
    return gray[..., 0]


def _picture(pixels: Any, plane: str, pixel_mm: float | None, source: str) -> Image:
    """Return pixels, rows from top to bottom, as an image whose only planes are they."""
    if pixel_mm is None:
        raise ValueError(f"pixel_mm: {source} has no size; give the edge of a pixel in mm.")
    edge = 1e-3 * positive("pixel_mm", pixel_mm)
    if pixels.ndim not in (2, 3) or pixels.dtype.kind not in "buif":
        raise ValueError(f"{source} has shape {pixels.shape}; give rows and columns of numbers.")
    frames = pixels.reshape(-1, *pixels.shape[-2:])
    values = np.moveaxis(frames[:, ::-1].transpose(2, 1, 0), 2, PLANES[plane])
    return Image(values, np.diag([edge, edge, edge, 1.0]), source, placed=False)
