"""Trains on bridges that several tests use, and TTB-2D's cases."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from railsearch_plugins.track_models.train_track_bridge import TrainTrackBridgeParameters

FOLDER = Path(__file__).parents[1] / "reference" / "ttb"
PROFILE = FOLDER / "profile_german_Avmid.csv"
CASES = ("c01_smooth", "c02_irr", "c05_irr_1veh_200")


@dataclass(frozen=True)
class Case:
    """A case of TTB-2D: our parameters for it, and what it found."""

    name: str
    parameters: TrainTrackBridgeParameters
    scalars: dict
    frequencies: list
    mesh: dict
    steps: int


def case(name):
    data = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    track, vehicle, bridge = data["track"], data["vehicle"], data["bridge"]
    smooth = data["profile"] == "smooth"
    parameters = TrainTrackBridgeParameters(
        speed=vehicle["speed_m_s"],
        vehicles=vehicle["number"],
        pad_stiffness=track["pad_k"],
        pad_damping=track["pad_c"],
        sleeper_mass=track["sleeper_mass"],
        sleeper_spacing=track["sleeper_spacing"],
        ballast_mass=track["ballast_mass"],
        ballast_stiffness=track["ballast_k"],
        ballast_damping=track["ballast_c"],
        subballast_stiffness=track["subballast_k"],
        subballast_damping=track["subballast_c"],
        irregularity_spectrum="none" if smooth else "german",
        irregularity_file="" if smooth else str(PROFILE),
        bridge_length=bridge["nominal_span"],
        bridge_mass=bridge["mass_per_m"],
        bridge_modulus=bridge["E"],
        bridge_inertia=bridge["I"],
        bridge_damping=bridge["damping_ratio"],
        time_step=1e-3,
        start_position=-24.0,
        end_position={3: 158.4, 1: 108.0}[vehicle["number"]],
    )
    return Case(name, parameters, data["scalars"], bridge["freq_Hz"], data["mesh"], data["time"]["steps"])


def file_profile(x):
    """r, dr/dx, d²r/dx² (3, k), upward, of TTB-2D's profile."""
    spline = CubicSpline(*np.loadtxt(PROFILE, delimiter=",").T)
    return np.array([spline(x), spline(x, 1), spline(x, 2)])


def short_bridge(**changes):
    """One vehicle, a bridge of 9 m, everything else as in the study, and little way to go.

    No axle ever stands on a node, where the second derivative of the Hermite functions has two values.
    """
    start = TrainTrackBridgeParameters(
        vehicles=1, bridge_length=9.0, start_position=-3.0137, end_position=12.0, irregularity_file=str(PROFILE)
    )
    return replace(start, **changes)
