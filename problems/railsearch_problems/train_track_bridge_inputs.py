"""The 16 uncertain inputs of the train-track-bridge system with their distributions.

Source: Shang, Nogal, Teixeira & Wolfert, Reliability Engineering & System Safety 243 (2024) 109818, in SI units: the
roughness of the irregularity is printed in 1e-7 m² rad/m and the damping ratio of the bridge in per cent. The factors
multiply the carbody mass (not its moment of inertia) and the stiffness (not the damping) of the suspensions; mean and
coefficient of variation of the lognormal ones are those of the factor itself.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from railsearch.distributions import RandomVector, keep_inside, random_vector


@dataclass(frozen=True)
class UncertainInput:
    """A parameter of the track model `train-track-bridge` with the table of its distribution and its physical range."""

    name: str
    unit: str
    meaning: str
    distribution: Mapping[str, object]
    physical: tuple[float, float] = (0.0, math.inf)


def _uniform(lower: float, upper: float) -> Mapping[str, object]:
    return MappingProxyType({"distribution": "uniform", "lower": lower, "upper": upper})


def _lognormal(mean: float, cov: float) -> Mapping[str, object]:
    return MappingProxyType({"distribution": "lognormal", "mean": mean, "cov": cov})


def _normal(mean: float, std: float) -> Mapping[str, object]:
    return MappingProxyType({"distribution": "normal", "mean": mean, "std": std})


UNCERTAIN_INPUTS = (
    UncertainInput("carbody_mass_factor", "", "factor on the mass of the carbodies", _lognormal(1.0, 0.15)),
    UncertainInput("primary_stiffness_factor", "", "factor on the primary suspension", _lognormal(1.0, 0.10)),
    UncertainInput("secondary_stiffness_factor", "", "factor on the secondary suspension", _lognormal(1.0, 0.10)),
    UncertainInput("pad_stiffness", "N/m", "stiffness of the railpads", _uniform(1e8, 1.5e9)),
    UncertainInput("pad_damping", "N s/m", "damping of the railpads", _uniform(1e4, 7e4)),
    UncertainInput("sleeper_mass", "kg", "mass of a sleeper", _uniform(220.0, 325.0)),
    UncertainInput("ballast_density", "kg/m³", "density of the ballast", _uniform(1500.0, 2100.0)),
    UncertainInput("ballast_modulus", "Pa", "Young's modulus of the ballast", _uniform(8e7, 1.6e8)),
    UncertainInput("ballast_depth", "m", "depth of the ballast", _uniform(0.3, 0.6)),
    UncertainInput("ballast_angle", "deg", "load distribution angle of the ballast", _uniform(15.0, 35.0), (0.0, 90.0)),
    UncertainInput("ballast_damping", "N s/m", "damping of the ballast", _uniform(4e4, 2.8e5)),
    UncertainInput("irregularity_amplitude", "m² rad/m", "roughness A_v of the irregularity", _uniform(4.032e-7, 1.080e-6)),
    UncertainInput("bridge_mass", "kg/m", "mass per length of the bridge", _normal(69000.0, 0.04 * 69000.0)),
    UncertainInput("bridge_modulus", "Pa", "Young's modulus of the bridge", _normal(35e9, 0.08 * 35e9)),
    UncertainInput("bridge_damping", "", "damping ratio of the bridge's first two modes", _normal(0.02, 0.003), (0.0, 1.0)),
    UncertainInput("bridge_inertia", "m⁴", "second moment of area of the bridge", _normal(51.3, 0.05 * 51.3)),
)


def uncertain_inputs() -> RandomVector:
    """The inputs as a random vector, checked against their physical ranges."""
    vector = random_vector({item.name: item.distribution for item in UNCERTAIN_INPUTS}, where="train-track-bridge")
    return keep_inside(vector, {item.name: item.physical for item in UNCERTAIN_INPUTS})
