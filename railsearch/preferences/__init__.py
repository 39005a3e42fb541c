"""Preferences of stakeholders: functions from a value to a score of 0 to 100, stated by name, and their aggregation."""

from railsearch.preferences.aggregation import AGGREGATIONS, largest_shortfall
from railsearch.preferences.functions import (
    Desirability,
    Linear,
    MonotoneSpline,
    PiecewiseLinear,
    PreferenceFunction,
)
from railsearch.preferences.physical_programming import PhysicalProgramming
from railsearch.preferences.statement import (
    FUNCTIONS,
    GroupPreferenceParameters,
    PreferenceParameters,
    Stakeholder,
    StatedPreference,
    described,
    quantities_of,
    scores,
    stated,
)

__all__ = [
    "AGGREGATIONS",
    "FUNCTIONS",
    "Desirability",
    "GroupPreferenceParameters",
    "Linear",
    "MonotoneSpline",
    "PhysicalProgramming",
    "PiecewiseLinear",
    "PreferenceFunction",
    "PreferenceParameters",
    "Stakeholder",
    "StatedPreference",
    "described",
    "largest_shortfall",
    "quantities_of",
    "scores",
    "stated",
]
