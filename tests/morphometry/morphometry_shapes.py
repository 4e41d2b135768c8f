"""Curves whose measures are known."""

import contourpy
import numpy as np
import shapely


def angles(n, arc=2 * np.pi):
    """Angles of an outline (default), or of an open arc with both ends."""
    return np.linspace(0, arc, n, endpoint=arc < 2 * np.pi)


def flower(lobes, amplitude, n=1200, arc=2 * np.pi, height=1.0):
    """r = 1 + amplitude cos(lobes theta), stretched in y; concave where amplitude lobes^2 > 1 or so."""
    theta = angles(n, arc)
    r = 1 + amplitude * np.cos(lobes * theta)
    return np.stack((r * np.cos(theta), height * r * np.sin(theta)))


def ellipse(width, height, n=1200, arc=2 * np.pi):
    return flower(1, 0.0, n, arc) * [[width], [height]]


def mushrooms(lobes, amplitude, n=2400, arc=2 * np.pi):
    """r = 1 + amplitude cos u, n phi = u + 1.4 sin u + 0.6 sin 2u: gyri that overhang sulci with necks.

    Going up a sulcus, its half width n (pi/n - phi) = v - 1.4 sin v + 0.6 sin 2v, v = pi - u, grows to 0.39,
    falls to 0.16 in the neck, and grows again.
    """
    u = lobes * angles(n, arc)
    r = 1 + amplitude * np.cos(u)
    phi = (u + 1.4 * np.sin(u) + 0.6 * np.sin(2 * u)) / lobes
    return np.stack((r * np.cos(phi), r * np.sin(phi)))


def polygon(corners, step):
    """Outline with straight sides, points at most `step` apart."""
    points = []
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        pieces = int(np.ceil(np.hypot(b[0] - a[0], b[1] - a[1]) / step))
        points += [np.array(a) + (np.array(b) - np.array(a)) * k / pieces for k in range(pieces)]
    return np.array(points).T


def comb(fingers, width, slot, depth, base=1.0, step=0.01):
    """A slab with rectangular fingers on top, points at most `step` apart, counter-clockwise."""
    total = fingers * width + (fingers - 1) * slot
    corners = [(0.0, -base), (total, -base)]
    for k in reversed(range(fingers)):
        left = k * (width + slot)
        corners += [(left + width, depth), (left, depth)]
        if k:
            corners += [(left, 0.0), (left - slot, 0.0)]
    return polygon(corners, step)


def banana(middle=3.0, half=1.0, turn=np.pi, step=0.01):
    """A strip of width 2 half bent to an arc of radius `middle`, with round ends; counter-clockwise."""

    def arc(radius, centre, start, end):
        at = np.linspace(start, end, max(3, int(abs(end - start) * radius / step)), endpoint=False)
        return np.array(centre)[:, None] + radius * np.array([np.cos(at), np.sin(at)])

    tip = middle * np.array([np.cos(turn), np.sin(turn)])
    return np.hstack((
        arc(middle + half, (0, 0), 0, turn), arc(half, tip, turn, turn + np.pi),
        arc(middle - half, (0, 0), turn, 0), arc(half, (middle, 0), np.pi, 2 * np.pi),
    ))  # fmt: skip


def voxels(inside, size, extent, diagonal=False):
    """Outline of the voxels with middles `inside(x, y)`: round their sides, or through the sides' middles."""
    at = np.arange(-round(extent / size), round(extent / size) + 1.0)
    mask = inside(*np.meshgrid(at * size, at * size))
    if diagonal:
        (line,) = contourpy.contour_generator(at, at, mask.astype(float)).lines(0.5)
        return size * line.T[:, :-1]
    y, x = at[np.argwhere(mask).T]
    squares = shapely.union_all(shapely.box(x - 0.5, y - 0.5, x + 0.5, y + 0.5))
    return size * shapely.get_coordinates(squares.exterior.segmentize(1.0)).T[:, :-1]


def moved(points, angle=0.0, scale=1.0, shift=(0.0, 0.0)):
    """Turned, scaled and shifted copy."""
    c, s = np.cos(angle), np.sin(angle)
    return scale * np.array([[c, -s], [s, c]]) @ points + np.reshape(shift, (2, 1))
