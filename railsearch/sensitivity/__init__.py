"""Sensitivity near extremes and limit states: all factors but one at a time (A-1AT)."""

from railsearch.sensitivity.bootstrap import ImportanceSpread, bootstrap_importances, importances_over_designs
from railsearch.sensitivity.extremes import (
    MAXIMUM,
    MINIMUM,
    SENSES,
    Curve,
    Effort,
    ExtremeSurfaces,
    extreme_surfaces,
)
from railsearch.sensitivity.factors import EQUAL, LOGARITHMIC, RANDOM, SPACINGS, Factors, factors_on, input_space
from railsearch.sensitivity.inner_search import FRUGAL, GlobalCheck, SearchSettings
from railsearch.sensitivity.models import ExactModel, ProblemFunction
from railsearch.sensitivity.strategy_search import StrategySettings, strategy_surfaces
from railsearch.sensitivity.surrogates import BoxSurrogate, input_surrogate
from railsearch.sensitivity.thresholds import (
    FactorThreshold,
    Threshold,
    ThresholdSurfaces,
    direct_threshold_surfaces,
    margin,
    threshold_surfaces,
)

__all__ = [
    "EQUAL",
    "FRUGAL",
    "LOGARITHMIC",
    "MAXIMUM",
    "MINIMUM",
    "RANDOM",
    "SENSES",
    "SPACINGS",
    "BoxSurrogate",
    "Curve",
    "Effort",
    "ExactModel",
    "ExtremeSurfaces",
    "FactorThreshold",
    "Factors",
    "GlobalCheck",
    "ImportanceSpread",
    "ProblemFunction",
    "SearchSettings",
    "StrategySettings",
    "Threshold",
    "ThresholdSurfaces",
    "bootstrap_importances",
    "direct_threshold_surfaces",
    "extreme_surfaces",
    "factors_on",
    "importances_over_designs",
    "input_space",
    "input_surrogate",
    "margin",
    "strategy_surfaces",
    "threshold_surfaces",
]
