"""A whole sensitivity analysis of samples: surrogates, extremes, thresholds, and the classical measures beside them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.plugin_manager import Registry
from railsearch.seeding import checked_seed
from railsearch.sensitivity.extremes import ExtremeSurfaces, extreme_surfaces
from railsearch.sensitivity.factors import Factors, factors_on, input_space
from railsearch.sensitivity.fitting import FittedSurrogate, fitted_surrogate, surrogate_fit
from railsearch.sensitivity.inner_search import SearchSettings
from railsearch.sensitivity.screening import ElementaryEffects, OneAtATime, elementary_effects, one_at_a_time
from railsearch.sensitivity.thresholds import UPPER, ThresholdSurfaces, threshold_surfaces
from railsearch.sensitivity.variance_based import SobolIndices, sobol_indices
from railsearch.space import FloatArray

FORMAT = "railsearch sensitivity 1"
QUANTILES = (50.0, 90.0, 99.0)
"""Levels in per cent at which thresholds are added to those asked for."""

BASE_SAMPLE = 4096
TRAJECTORIES = 200
INDEPENDENT_BELOW = 1e-6
"""Probability of a rank correlation as strong as that of two inputs, below which they are not taken as independent."""

WEAK = 0.2
"""Rank correlations that are weaker than this are let pass: a Latin hypercube of few samples has such."""


@dataclass(frozen=True)
class StudySettings:
    """What is asked of the samples.

    thresholds: by output, beside the quantiles; points: grid values of a factor; surrogate: its name and settings; level:
    percentile that bounds an input without bounds; ranges: bounds by input in place of these; limit: `upper` if going
    above a threshold is failing; seed: of everything random.
    """

    thresholds: Mapping[str, Sequence[float]] = field(default_factory=dict)
    points: int = 100
    surrogate: str = "pce"
    surrogate_settings: Mapping[str, object] = field(default_factory=dict)
    level: float = 0.01
    ranges: Mapping[str, Sequence[float]] = field(default_factory=dict)
    limit: str = UPPER
    seed: int = 0


@dataclass(frozen=True)
class SampledOutput:
    """An output with its samples: points (n, d), values (n,), and how many were dropped because they failed or repeat."""

    quantity: Quantity
    points: FloatArray
    values: FloatArray
    failed: int
    repeated: int


@dataclass(frozen=True)
class CriterionStudy:
    """All that was found about one output."""

    output: SampledOutput
    surrogate: FittedSurrogate
    extremes: ExtremeSurfaces
    thresholds: ThresholdSurfaces
    sobol: SobolIndices
    morris: ElementaryEffects
    one_at_a_time: OneAtATime

    def document(self) -> dict[str, Any]:
        """Plain types, ready for JSON."""
        quantity = self.output.quantity
        return {
            "name": quantity.name,
            "unit": quantity.unit,
            "meaning": quantity.meaning,
            "samples": {"used": len(self.output.values), "failed": self.output.failed, "repeated": self.output.repeated},
            "surrogate": self.surrogate.quality.document(),
            "held_out": {"true": self.surrogate.true.tolist(), "predicted": self.surrogate.predicted.tolist()},
            "importances": self.extremes.importances(),
            "extremes": self.extremes.document(),
            "thresholds": self.thresholds.document(),
            "sobol": self.sobol.document() | {"of": "the surrogate"},
            "morris": self.morris.document() | {"of": "the surrogate"},
            "one_at_a_time": self.one_at_a_time.document() | {"of": "the surrogate"},
        }


def sampled_output(quantity: Quantity, points: FloatArray, values: FloatArray) -> SampledOutput:
    """The samples of an output that can be used: those with a value, each design once.

    Raises InputError if designs that are the same have different values: the model has something random.
    """
    known = np.isfinite(values)
    points, kept = points[known], values[known]
    _, first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
    differing = kept != kept[first][inverse]
    if differing.any():
        place = int(np.argmax(differing))
        raise InputError(
            f"{quantity.name}: the same inputs have the values {kept[place]:g} and {kept[first][inverse][place]:g}; "
            "a sensitivity analysis needs a model without randomness"
        )
    unique = np.sort(first)
    return SampledOutput(quantity, points[unique], kept[unique], int((~known).sum()), len(kept) - len(unique))


def check_independent(inputs: RandomVector, points: FloatArray) -> None:
    """Raise InputError if samples (n, d) show that inputs depend on one another."""
    from scipy.stats import spearmanr

    from railsearch.distributions import INDEPENDENT

    for j in range(1, inputs.dimension):
        for i in range(j):
            found = spearmanr(points[:, i], points[:, j])
            if abs(found.statistic) > WEAK and found.pvalue < INDEPENDENT_BELOW:
                raise InputError(
                    f"samples: {inputs.names[i]} and {inputs.names[j]} have a rank correlation of {found.statistic:.2f}; "
                    f"{INDEPENDENT}"
                )


def study_samples(
    registry: Registry,
    inputs: RandomVector,
    units: Mapping[str, str],
    outputs: Sequence[SampledOutput],
    settings: StudySettings,
    watch: Callable[[str], None],
) -> list[CriterionStudy]:
    """Study all outputs; `watch` is told what is done next.

    Raises InputError for samples that cannot occur, and as the surrogate, `factors_on` and `threshold_surfaces` do.
    """
    fit = surrogate_fit(registry, settings.surrogate, settings.surrogate_settings, inputs)
    factors = factors_on(input_space(inputs, settings.level, settings.ranges, units), settings.points)
    studies = []
    for number, output in enumerate(outputs):
        seeds = np.random.SeedSequence([checked_seed(settings.seed), number]).spawn(4)
        generators = [np.random.default_rng(seed) for seed in seeds]
        watch(f"{output.quantity.name}: surrogate {settings.surrogate} of {len(output.values)} samples")
        surrogate = fitted_surrogate(fit, inputs.checked(output.points), output.values, generators[0])
        studies.append(_studied(output, surrogate, inputs, factors, settings, generators[1:], watch))
    return studies


def _studied(
    output: SampledOutput,
    surrogate: FittedSurrogate,
    inputs: RandomVector,
    factors: Factors,
    settings: StudySettings,
    generators: Sequence[np.random.Generator],
    watch: Callable[[str], None],
) -> CriterionStudy:
    name, model = output.quantity.name, surrogate.model
    watch(f"{name}: extremes at {factors.number_of_values} grid values")
    extremes = extreme_surfaces(model, factors, generators[0], SearchSettings(), output.quantity)
    asked = [*settings.thresholds.get(name, ()), *np.percentile(output.values, QUANTILES)]
    watch(f"{name}: classical measures")
    return CriterionStudy(
        output,
        surrogate,
        extremes,
        threshold_surfaces(extremes, asked, settings.limit),
        sobol_indices(model.predict, inputs, BASE_SAMPLE, generators[1]),
        elementary_effects(model.predict, factors.space, TRAJECTORIES, generators[2]),
        one_at_a_time(model.predict, factors),
    )
