"""A whole sensitivity analysis of samples: surrogates, extremes, thresholds, and the classical measures beside them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.plugin_manager import Registry
from railsearch.result import versions
from railsearch.seeding import checked_seed
from railsearch.sensitivity.extremes import ExtremeSurfaces, extreme_surfaces
from railsearch.sensitivity.factors import Factors, factors_on, input_space
from railsearch.sensitivity.fitting import FittedSurrogate, fitted_surrogate, surrogate_fit
from railsearch.sensitivity.inner_search import SearchSettings
from railsearch.sensitivity.screening import ElementaryEffects, OneAtATime, elementary_effects, one_at_a_time
from railsearch.sensitivity.thresholds import UPPER, ThresholdSurfaces, threshold_surfaces
from railsearch.sensitivity.variance_based import SobolIndices, sobol_indices
from railsearch.sensitivity_study.data import SampledOutput, StudyData

FORMAT = "railsearch sensitivity 1"
QUANTILES = (50.0, 90.0, 99.0)
"""Levels in per cent at which thresholds are added to those asked for."""

BASE_SAMPLE = 4096
TRAJECTORIES = 200


@dataclass(frozen=True)
class StudySettings:
    """What is asked of the samples.

    criteria: outputs, by default those of the data; thresholds: by output, beside the quantiles; points: grid values of a
    factor; surrogate: its name and settings; level: percentile that bounds an input without bounds; limit: `upper` if going
    above a threshold is failing; seed: of everything random.
    """

    criteria: tuple[str, ...] = ()
    thresholds: Mapping[str, Sequence[float]] = field(default_factory=dict)
    points: int = 100
    surrogate: str = "pce"
    surrogate_settings: Mapping[str, object] = field(default_factory=dict)
    level: float = 0.01
    limit: str = UPPER
    seed: int = 0


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


def study_samples(
    registry: Registry, data: StudyData, settings: StudySettings, watch: Callable[[str], None]
) -> list[CriterionStudy]:
    """Study the criteria of the settings; `watch` is told what is done next.

    Raises InputError for samples that cannot occur, and as the surrogate, `factors_on` and `threshold_surfaces` do.
    """
    inputs, outputs = data.inputs, [data.output(name) for name in settings.criteria or data.default]
    fit = surrogate_fit(registry, settings.surrogate, settings.surrogate_settings, inputs)
    factors = factors_on(input_space(inputs, settings.level, data.ranges, data.units), settings.points)
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


def study_document(
    data: StudyData, settings: StudySettings, studies: Sequence[CriterionStudy], command: str
) -> dict[str, Any]:
    """All of it in plain types, ready for JSON."""
    return {
        "format": FORMAT,
        "command": command,
        "of": data.name,
        "seed": settings.seed,
        "surrogate": {"name": settings.surrogate, "settings": dict(settings.surrogate_settings)},
        "inputs": [
            {"name": name, "unit": data.units.get(name, ""), "distribution": str(marginal)}
            for name, marginal in data.inputs.marginals.items()
        ],
        "samples": {"file": str(data.samples.source), "number": data.samples.number},
        "criteria": [study.document() for study in studies],
        "versions": versions(),
    }
