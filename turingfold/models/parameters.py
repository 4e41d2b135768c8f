"""The parameters that cases share: annotations for the keyword arguments of `scenes`.

    from turingfold import parameters as p

    @p.quick(elements=2)
    def scenes(quick=False, *, radius: p.Radius = 0.0404, elements: p.Elements = 6): ...

A parameter of one's own: `Annotated[float, Parameter("m", 0.01, 0.1, "width of the zone")]`. Bodies of the
ferret are in units of their radius and of the shear modulus, with time in units of their own.
"""

from __future__ import annotations

from typing import Annotated

from ..turing.kinetics.named import KINETICS
from .declared import Parameter as Parameter
from .declared import quick as quick

GROWTH = "it is a factor: 1 is no growth, 1.9 growth by 90 per cent"
MODULUS = (1.0, 1e6)  # Pa

# the brain of document 1
Radius = Annotated[float, Parameter("m", 0.005, 0.2, "radius of the brain")]
Width = Annotated[float, Parameter("m", 0.01, 0.4, "width of the brain along its base")]
Height = Annotated[float, Parameter("m", 0.005, 0.2, "height of the brain")]
Thickness = Annotated[float, Parameter("m", 1e-4, 0.02, "thickness of the cortex")]
Elements = Annotated[float, Parameter("", 1, 24, "elements through the cortex")]
Along = Annotated[float, Parameter("", 1, 4, "elements along the cortex over those across it")]
Base = Annotated[str, Parameter(label="what holds the base", choices=("clamped", "roller", "free"))]
Layers = Annotated[str, Parameter(label="how gray turns to white matter", choices=("sharp", "sigmoid"))]
YoungGray = Annotated[float, Parameter("Pa", *MODULUS, "Young's modulus of gray matter")]
YoungWhite = Annotated[float, Parameter("Pa", *MODULUS, "Young's modulus of white matter")]
Poisson = Annotated[float, Parameter("", 0.0, 0.4999, "Poisson's ratio of both layers")]
Halved = Annotated[bool, Parameter(label="one half is computed, the other is its mirror image")]
TwoLayers = Annotated[bool, Parameter(label="white matter has a modulus of its own (DGH)")]
Cortex = Annotated[float, Parameter("", 0.3, 5, "tangential growth of the cortex", remedy=GROWTH)]
Core = Annotated[float, Parameter("", 0.3, 5, "tangential growth of the core", remedy=GROWTH)]
RadialCore = Annotated[float, Parameter("", 0.3, 5, "radial growth of the core", remedy=GROWTH)]
Swelling = Annotated[float, Parameter("", -0.5, 2, "swelling of the inner core, stretch less 1")]
GrowthLaw = Annotated[
    str, Parameter(label="what the core's growth follows", choices=("prescribed", "stress", "cortex"))
]
StressRate = Annotated[float, Parameter("", 1e-3, 1e3, "rate of growth by stress, over modulus and duration")]
Tension = Annotated[bool, Parameter(label="axons pull (ATH)")]
Strength = Annotated[float, Parameter("N/m", 0, 10, "line tension of axons on the gray-white interface")]
Loads = Annotated[str, Parameter(label="what pulls", choices=("tension", "figure1"))]
Traction = Annotated[float, Parameter("Pa", 0, 5e3, "traction of axons on the pial surface")]
Pattern = Annotated[bool, Parameter(label="a Turing pattern says where axons pull (IPH)")]
Kinetics = Annotated[str, Parameter(label="kinetics of the morphogens", choices=tuple(KINETICS))]
HalfWaves = Annotated[int | None, Parameter("", 1, 200, "half waves along the pial surface")]
Dynamics = Annotated[bool, Parameter(label="with inertia, from rest, in seconds")]
Duration = Annotated[float, Parameter("s", 1e-3, 1e5, "duration of growth, with inertia")]
LocalError = Annotated[float, Parameter("T", 1e-5, 1, "largest error of a step, in thicknesses")]
Damping = Annotated[float, Parameter("s", 0, 10, "damping stress over the rate of elastic stress")]
Density = Annotated[float, Parameter("kg/m³", 1, 2e4, "density")]
Pace = Annotated[float, Parameter("", 1e-3, 1e6, "time of the kinetics in the time of growth")]

# sections from files
File = Annotated[str, Parameter(label="file with the section's outline")]
WhiteSurface = Annotated[str, Parameter(label="white surface: a file, a name in the drawing, or labels")]
Holes = Annotated[str, Parameter(label="ventricles: a file, a name in the drawing, or labels")]
GrayLabels = Annotated[str, Parameter(label="labels of gray matter in an image")]
Unit = Annotated[str, Parameter(label="unit of the file's numbers, or a pixel's edge in m")]
Plane = Annotated[str, Parameter(label="plane of the section", choices=("coronal", "sagittal", "axial"))]
At = Annotated[float | None, Parameter("m", -0.3, 0.3, "where the plane cuts surfaces and volumes")]
SectionWidth = Annotated[float | None, Parameter("m", 1e-3, 0.3, "width of the section, left to right")]
Smooth = Annotated[float | None, Parameter("m", 0, 0.02, "details of the outline below this go")]
SkullGap = Annotated[float | None, Parameter("m", 1e-5, 0.05, "gap from the convex hull to the skull")]
OwnThickness = Annotated[float | None, Parameter("m", 1e-4, 0.02, "thickness of the cortex at the start")]
Closing = Annotated[float, Parameter("m", 1e-4, 0.05, "radius of the disc that fills sulci")]
Scale = Annotated[float, Parameter("", 0.2, 2, "size of the start over that of the grown section")]
OutOfPlane = Annotated[str, Parameter(label="growth across the plane", choices=("fixed", "tangential"))]

WeekCurve = Annotated[str, Parameter(label="share of growth by week", choices=("wang", "gompertz"))]
Samples = Annotated[int, Parameter("", 1, 10_000, "samples of what is uncertain")]
Seed = Annotated[int, Parameter("", 0, 2**31, "seed of what is random")]

# the brain of document 2
RelativeThickness = Annotated[float, Parameter("R", 0.01, 0.5, "thickness of the cortex, in radii")]
BulkRatio = Annotated[float, Parameter("", 1, 1e3, "bulk over shear modulus")]
Rate = Annotated[float, Parameter("", -5, 5, "relative tangential growth per unit of time")]
Thinning = Annotated[float, Parameter("", 0, 1, "share of its thickness that the cortex loses per time")]
Amplitude = Annotated[float, Parameter("", 0, 0.5, "amplitude of the noise in the cortex's growth")]
Drag = Annotated[float, Parameter("", 0, 1e4, "drag per area")]
Until = Annotated[float, Parameter("", 1e-3, 2, "time at the end")]
Steps = Annotated[int, Parameter("", 1, 10_000, "equal steps")]
Diffusivity = Annotated[float, Parameter("", 1e-6, 10, "diffusivity of the solvent, in R² per unit of time")]
Inset = Annotated[float, Parameter("R", 1e-4, 0.1, "how far inside the old surface the next stage begins")]
SmoothRadii = Annotated[float, Parameter("R", 0, 0.2, "details of the outline below this go")]
Shorter = Annotated[float, Parameter("", 0.5, 100, "how many times shorter each stage is")]
