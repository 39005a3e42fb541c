"""The uncertain inputs of the train-track-bridge system with their distributions: sixteen as published, and a user's own.

Source: Shang, Nogal, Teixeira & Wolfert, Reliability Engineering & System Safety 243 (2024) 109818, in SI units: the
roughness of the irregularity is printed in 1e-7 m² rad/m and the damping ratio of the bridge in per cent. The factors
multiply the carbody mass (not its moment of inertia) and the stiffness (not the damping) of the suspensions; mean and
coefficient of variation of the lognormal ones are those of the factor itself.
"""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from railsearch.distributions import RandomVector, keep_inside, random_vector
from railsearch.errors import InputError
from railsearch.parameters import field_range, parameter
from railsearch.space import FloatArray
from railsearch.wording import did_you_mean

Table = Mapping[str, object]


def _uniform(lower: float, upper: float) -> Table:
    return MappingProxyType({"distribution": "uniform", "lower": lower, "upper": upper})


def _lognormal(mean: float, cov: float) -> Table:
    return MappingProxyType({"distribution": "lognormal", "mean": mean, "cov": cov})


def _normal(mean: float, std: float) -> Table:
    return MappingProxyType({"distribution": "normal", "mean": mean, "std": std})


UNCERTAIN_INPUTS: Mapping[str, Table] = MappingProxyType(
    {
        "carbody_mass_factor": _lognormal(1.0, 0.15),
        "primary_stiffness_factor": _lognormal(1.0, 0.10),
        "secondary_stiffness_factor": _lognormal(1.0, 0.10),
        "pad_stiffness": _uniform(1e8, 1.5e9),
        "pad_damping": _uniform(1e4, 7e4),
        "sleeper_mass": _uniform(220.0, 325.0),
        "ballast_density": _uniform(1500.0, 2100.0),
        "ballast_modulus": _uniform(8e7, 1.6e8),
        "ballast_depth": _uniform(0.3, 0.6),
        "ballast_angle": _uniform(15.0, 35.0),
        "ballast_damping": _uniform(4e4, 2.8e5),
        "irregularity_amplitude": _uniform(4.032e-7, 1.080e-6),
        "bridge_mass": _normal(69000.0, 0.04 * 69000.0),
        "bridge_modulus": _normal(35e9, 0.08 * 35e9),
        "bridge_damping": _normal(0.02, 0.003),
        "bridge_inertia": _normal(51.3, 0.05 * 51.3),
    }
)
"""Parameters of the track model with the tables of their distributions."""


@dataclass(frozen=True)
class Inputs:
    """Which parameters of the track are uncertain, how, and in which range they are searched."""

    distributions: dict[str, Any] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="by parameter of the track: tables in place of the published distributions, or of further inputs"
    )
    fixed: tuple[str, ...] = parameter((), meaning="published inputs that keep the value of the track")
    level: float = parameter(
        0.01,
        meaning="an input without bounds is searched between its percentiles at this level and at one minus it",
        source="Shang et al. 2024",
        above=0.0,
        below=0.5,
    )
    truncate: bool = parameter(
        False, meaning="cut a distribution off where it leaves the physical range, instead of refusing it"
    )


def uncertain_inputs(track: Any, inputs: Inputs | None = None) -> RandomVector:
    """The inputs as a random vector, inside their physical ranges, which are those of the track's parameters.

    Raises InputError for a name that is no number of the track's, for one that has no effect on this track, and for a
    distribution that is not sound or leaves the physical range.
    """
    inputs = inputs or Inputs()
    stated = _stated(track, inputs)
    physical = {name: field_range(type(track), name) for name in stated.names}
    try:
        return keep_inside(stated, physical, truncate=inputs.truncate)
    except InputError as error:
        raise InputError(f"inputs.distributions.{error} with truncate = true under [inputs]") from None


def searched_ranges(track: Any, inputs: Inputs, kept: RandomVector) -> FloatArray:
    """Bounds (d, 2): those of a distribution that has any, percentiles of others, cut off at a physical range or not.

    kept: the `uncertain_inputs`.
    """
    stated = _stated(track, inputs)
    levels = kept.percentiles([inputs.level, 1.0 - inputs.level]).T
    own = zip(stated.marginals.values(), kept.marginals.values(), levels, strict=True)
    return np.array([inside.support if before.bounded else outer for before, inside, outer in own], dtype=float)


def _stated(track: Any, inputs: Inputs) -> RandomVector:
    """The published inputs and those of the user, as they are stated."""
    own = inputs.distributions or {}
    for name in (*own, *inputs.fixed):
        _check_name(track, name)
    if both := [name for name in inputs.fixed if name in own]:
        raise InputError(f"inputs.fixed: {', '.join(both)}: also under inputs.distributions; leave one of them out")
    tables = {name: table for name, table in ({**UNCERTAIN_INPUTS, **own}).items() if name not in inputs.fixed}
    if not tables:
        raise InputError("inputs: one uncertain input or more is needed, all are fixed")
    for name in tables:
        _check_effect(track, name)
    return random_vector(tables, where="inputs.distributions")


def _check_name(track: Any, name: str) -> None:
    numbers = [field.name for field in dataclasses.fields(track) if isinstance(getattr(track, field.name), float)]
    if name not in numbers:
        raise InputError(f"inputs: '{name}' is no number of the track{did_you_mean(name, numbers)}")


def _check_effect(track: Any, name: str) -> None:
    """Raise InputError for an input that this track does not use: no result would depend on it."""
    mass, stiffness = track.ballast_mass is not None, track.ballast_stiffness is not None
    unused = {
        "irregularity_amplitude": bool(track.irregularity_file) or track.irregularity_spectrum == "none",
        "ballast_density": mass,
        "ballast_modulus": stiffness,
        "ballast_depth": mass and stiffness,
        "ballast_angle": mass and stiffness,
    }
    if unused.get(name):
        other = "another profile, or none," if name == "irregularity_amplitude" else "ballast_mass or ballast_stiffness"
        raise InputError(f"inputs: {name} has no effect on this track, for which {other} is given; name it in inputs.fixed")
