"""Sections from files: drawings, tables of points, masks and labels, surfaces."""

from .any_file import read_section as read_section
from .mask import mask_outline as mask_outline
from .mask import sections as sections
from .read import Contours as Contours
from .read import read_outline as read_outline
from .surface import surface_section as surface_section
