"""Statistics of repeated runs: curves of the best value, runlengths, and comparisons of strategies."""

from railsearch.statistics.comparisons import (
    Friedman,
    PairwiseComparison,
    friedman,
    holm,
    pairwise_comparison,
    probability_best,
    vargha_delaney,
)
from railsearch.statistics.curves import best_so_far, bootstrap_median_band, quantile_bands
from railsearch.statistics.runlengths import Targets, expected_running_time, relative_targets, runlength_ecdf, runlengths

__all__ = [
    "Friedman",
    "PairwiseComparison",
    "Targets",
    "best_so_far",
    "bootstrap_median_band",
    "expected_running_time",
    "friedman",
    "holm",
    "pairwise_comparison",
    "probability_best",
    "quantile_bands",
    "relative_targets",
    "runlength_ecdf",
    "runlengths",
    "vargha_delaney",
]
