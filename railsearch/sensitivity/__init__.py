"""Sensitivity near extremes and limit states: all factors but one at a time (A-1AT)."""

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
from railsearch.sensitivity.inner_search import GlobalCheck, SearchSettings
from railsearch.sensitivity.models import ExactModel, ProblemFunction
from railsearch.sensitivity.thresholds import (
    FactorThreshold,
    Threshold,
    ThresholdSurfaces,
    direct_threshold_surfaces,
    margin,
    threshold_surfaces,
)
