"""One way in for all files of sections: drawings, tables of points, masks and labels, surfaces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..checks import file_path, positive
from ..geometry.units import metres
from ..outlines.section import Section
from .image import PICTURES
from .mask import sections
from .read import COLUMNS, contours
from .surface import surface_section

VOLUMES = (".nii", ".nii.gz", ".mgz", ".mgh", ".img", ".hdr")
KINDS = f"a drawing (.svg), points ({', '.join(COLUMNS)}), an image or a surface"


def read_section(
    outline: str | Path, *, white: str = "", holes: str = "", gray: str = "", unit: str = "",
    plane: str = "coronal", at: float | None = None, width: float | None = None,
) -> Section:  # fmt: skip
    """Return the section in a file, whatever its kind; what it means is told by the end of its name.

    Drawing (.svg) or points (.csv, .txt, ...): all closed curves are pial surface, but those of the layers,
    groups or shapes of the drawing that `white` and `holes` name.  Picture (.png, .tif, ...) or volume (.nii,
    .mgz, ...): a mask, or labels named by `gray`, `white` and `holes`, such as "2" or "3,42"; of a volume the
    `plane` that lies `at` (m), else the one with the most tissue.  Other names are pial surfaces in GIFTI or
    FreeSurfer's format, one or several separated by commas, cut by the `plane` that lies `at`.
    white, holes: also files of their own, of points, drawings or surfaces.
    unit: of the file's numbers, such as "mm", or in m; of pictures the edge of a pixel. "": as the file says;
    volumes say it always.
    width: of the section from left to right, to which it is scaled; m.
    Raises ValueError for files that cannot be read, and where a picture has neither unit nor width.
    """
    kind = _ending(outline)
    if width is not None and kind in (".svg", *COLUMNS, *PICTURES):
        unit = unit or "nm"  # any will do; in this one nothing is too large
    if unit and kind in VOLUMES:
        raise ValueError(
            f"unit={unit}: {Path(outline).name} states the size of its voxels; leave unit out, and where "
            "that is wrong give the width of the section, such as width=0.14 (m)."
        )
    if kind in (".svg", *COLUMNS):
        found = _drawn(outline, white, holes, unit, told=width is None)
    elif kind in (*PICTURES, *VOLUMES):
        labels = [_labels(*each) for each in (("gray", gray), ("white", white), ("holes", holes))]
        found = _imaged(outline, labels, unit, plane, at)
    else:
        names, below = (_files(name, given) for name, given in (("outline", outline), ("white", white)))
        if at is None:
            raise ValueError(f"at is missing: where, in m, the {plane} plane cuts {names[0].name}.")
        found = surface_section(names, below, plane=plane, at=at, unit=_unit(unit) or "mm")
    return found if width is None else _scaled(found, positive("width", width))


def _drawn(outline: str | Path, white: str, holes: str, unit: str, *, told: bool) -> Section:
    """Return the curves of a drawing or of points, and those of others files or names of the drawing."""
    whole = contours(outline, unit=_unit(unit), told=told)

    def others(given: str) -> tuple[Array, ...]:
        if not given:
            return ()
        if _ending(outline) == ".svg" and not Path(given).is_file():
            return contours(outline, given, _unit(unit), told=False).loops
        return contours(given, unit=_unit(unit), told=told).loops

    inner, ventricles = others(white), others(holes)
    apart = [loop.tobytes() for loop in (*inner, *ventricles)]
    pial = [loop for loop in whole.loops if loop.tobytes() not in apart]
    return Section(pial, inner, ventricles, source=whole.source, unit=whole.unit)


def _imaged(
    file: str | Path, labels: list[tuple[int, ...] | None], unit: str, plane: str, at: float | None
) -> Section:
    pixel = None
    if _ending(file) in PICTURES:
        if not unit:
            raise ValueError(
                f"{Path(file).name} does not say how large it is: give the edge of a pixel as unit, such as "
                "unit=0.0001 (m), or the width of the section, such as width=0.14 (m)."
            )
        pixel = 1e3 * metres(_unit(unit) or 1.0)
    gray, white, hole = labels
    (found,) = sections(
        file, plane=plane, at_mm=None if at is None else 1e3 * at, gray=gray, white=white, hole=hole,
        pixel_mm=pixel,
    )  # fmt: skip
    return found


def _labels(name: str, given: str) -> tuple[int, ...] | None:
    try:
        return None if not given else tuple(int(word) for word in given.split(","))
    except ValueError as error:
        raise ValueError(f"{name}={given}: give labels of the image, such as 2 or 3,42.") from error


def _unit(given: str) -> str | float | None:
    """Return a unit as `metres` takes it, None for ""."""
    try:
        return float(given)
    except ValueError:
        return given or None


def _ending(file: str | Path) -> str:
    name = Path(file).name.lower()
    both = next((end for end in (*VOLUMES, ".gii.gz") if name.endswith(end)), None)
    return both or Path(name).suffix


def _files(name: str, given: str | Path) -> list[Path]:
    one = Path(given)
    words = [] if not str(given) else [str(given)] if one.is_file() else str(given).split(",")
    return [file_path(name, word.strip(), KINDS) for word in words]


def _scaled(section: Section, width: float) -> Section:
    scale = width / float(np.ptp(np.concatenate(list(section.pial), axis=1)[0]))
    pial, white, holes = (
        [scale * curve for curve in curves] for curves in (section.pial, section.white, section.holes)
    )
    cuts = [((scale * a, scale * b), (scale * c, scale * d)) for (a, b), (c, d) in section.cuts]
    voxel = None if section.voxel is None else scale * section.voxel
    return replace(
        section, pial=pial, white=white, holes=holes, position=None, voxel=voxel, cuts=cuts,
        lacking=scale**2 * section.lacking,
    )  # fmt: skip
