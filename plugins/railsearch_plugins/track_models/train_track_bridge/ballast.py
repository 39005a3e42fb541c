"""Ballast under one sleeper as a cone that spreads its load (Zhai, Wang & Lin 2004).

symbol  meaning                                                    unit     source
l_e     effective length of half a sleeper                         m        Zhai et al. 2004
l_b     width of a sleeper                                         m        Zhai et al. 2004
l_s     distance of the sleepers for which the cone stands         m        Zhai et al. 2004
h       depth of the ballast                                       m
t       tan α, α the load distribution angle                       -
h₀      depth of the part in which neighbouring cones overlap      m        h₀ = h − (l_s − l_b)/(2t)
ρ, E    density and Young's modulus of the ballast                 kg/m³, Pa
m, k    mass and stiffness of the cone                             kg, N/m

The section of the cone at depth z is (l_e + 2zt)(l_b + 2zt) where it stands alone and l_s wide where cones overlap; 1/k is
∫ dz/(E · section), with the mean section over h₀.

Zhai, W. M., Wang, K. Y. & Lin, J. H. (2004). Modelling and experiment of railway ballast vibrations. Journal of Sound
and Vibration 270, 673-683.
"""

import math
from dataclasses import dataclass

from railsearch.errors import InputError
from railsearch_plugins.track_models.train_track_bridge.parameters import TrainTrackBridgeParameters


@dataclass(frozen=True)
class Cone:
    """Vibrating mass in kg and stiffness in N/m of the ballast under a sleeper, and the depth h₀ ≥ 0 of overlap in m."""

    mass: float
    stiffness: float
    overlap: float


def ballast_cone(
    depth: float,
    angle: float,
    density: float,
    modulus: float,
    *,
    half_length: float = 0.95,
    width: float = 0.273,
    spacing: float = 0.545,
    doubled: bool = False,
) -> Cone:
    """The cone of ballast under half a sleeper, or with `doubled` the two of a whole one.

    Where h₀ > 0: m = ρ[l_b h(l_e + ht) + l_e(h² − h₀²)t + 4/3 (h³ − h₀³)t²] and 1/k = 1/K₁ + 1/K₂ with
    1/K₁ = ln[l_e l_s/(l_b(l_e + l_s − l_b))]/(2(l_e − l_b)tE) and 1/K₂ = (l_b − l_s + 2ht)/(l_s(l_s − l_b + 2l_e + 2ht)tE);
    elsewhere m = ρh[l_e l_b + (l_e + l_b)ht + 4/3 h²t²] and 1/k = ln[l_e(l_b + 2ht)/(l_b(l_e + 2ht))]/(2(l_e − l_b)tE).

    `depth` h, `half_length` l_e, `width` l_b and `spacing` l_s in m, `angle` α in degrees, `density` ρ in kg/m³ and
    `modulus` E in Pa. Raises InputError for a value that makes the cone degenerate: any that is not positive, an angle
    of 90° and more, a width not below half_length and spacing. Source: Zhai et al. 2004, with the mass as printed.
    """
    _check(depth, angle, density, modulus, half_length, width, spacing)
    t = math.tan(math.radians(angle))
    spread = min(2.0 * depth * t, spacing - width)
    overlap = max(depth - (spacing - width) / (2.0 * t), 0.0)
    mass = density * _volume(depth, overlap, t, half_length, width)
    # log1p keeps the ratio of logarithm and tangent down to a column, for which both vanish.
    logarithm = math.log1p(spread * (half_length - width) / (width * (half_length + spread)))
    upper = logarithm / (2.0 * (half_length - width) * t * modulus)
    lower = 2.0 * overlap / (spacing * (spacing - width + 2.0 * half_length + 2.0 * depth * t) * modulus)
    copies = 2.0 if doubled else 1.0
    return Cone(copies * mass, copies / (upper + lower), overlap)


def ballast_values(parameters: TrainTrackBridgeParameters) -> tuple[float, float]:
    """Vibrating mass in kg and stiffness in N/m of the ballast under a sleeper: given, or of the cone of half a sleeper.

    With `ballast_doubled` those of both halves. The cone is that of `ballast_cone`, whatever the sleeper spacing is.
    """
    mass, stiffness = parameters.ballast_mass, parameters.ballast_stiffness
    if mass is None or stiffness is None:
        cone = ballast_cone(
            parameters.ballast_depth,
            parameters.ballast_angle,
            parameters.ballast_density,
            parameters.ballast_modulus,
            doubled=parameters.ballast_doubled,
        )
        mass, stiffness = cone.mass if mass is None else mass, cone.stiffness if stiffness is None else stiffness
    return mass, stiffness


def _volume(h: float, h0: float, t: float, l_e: float, l_b: float) -> float:
    return l_b * h * (l_e + h * t) + l_e * (h * h - h0 * h0) * t + 4.0 / 3.0 * (h**3 - h0**3) * t * t


def _check(
    depth: float, angle: float, density: float, modulus: float, half_length: float, width: float, spacing: float
) -> None:
    _require(0.0 < depth < math.inf, "ballast_depth", "above 0 m", depth, "give the depth under the sleepers")
    _require(0.0 < angle < 90.0, "ballast_angle", "above 0° and below 90°", angle, "15° to 45° are usual")
    _require(0.0 < density < math.inf, "ballast_density", "above 0 kg/m³", density, "1500 to 2100 kg/m³ are usual")
    _require(0.0 < modulus < math.inf, "ballast_modulus", "above 0 Pa", modulus, "8e7 to 1.6e8 Pa are usual")
    _require(0.0 < width < math.inf, "sleeper_width", "above 0 m", width, "0.2 to 0.3 m are usual")
    _require(
        width < half_length < math.inf,
        "sleeper_half_length",
        f"longer than the sleeper is wide, {width:g} m,",
        half_length,
        "0.95 m is usual",
    )
    _require(
        width < spacing < math.inf,
        "cone_spacing",
        f"above the width of a sleeper, {width:g} m, for cones to stand beside one another,",
        spacing,
        "0.545 m is usual",
    )


def _require(holds: bool, field: str, rule: str, value: float, remedy: str) -> None:
    if not holds:
        raise InputError(f"{field}: {rule} is needed for the ballast cone, received {value:g}; {remedy}")
