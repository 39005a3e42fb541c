"""A whole sensitivity analysis of samples: surrogates, extremes, thresholds, and the classical measures beside them."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railsearch.design_problem import DesignProblem
from railsearch.distributions import RandomVector
from railsearch.errors import InputError
from railsearch.plugin_manager import Registry
from railsearch.projected_gradient import SmoothFunction
from railsearch.result import versions
from railsearch.seeding import checked_seed
from railsearch.sensitivity.bootstrap import ImportanceSpread, bootstrap_importances
from railsearch.sensitivity.extremes import MAXIMUM, MINIMUM, ExtremeSurfaces, extreme_surfaces
from railsearch.sensitivity.factors import FEWEST_POINTS, Factors, factors_on, input_space
from railsearch.sensitivity.fitting import Fit, FittedSurrogate, fitted_surrogate, surrogate_fit
from railsearch.sensitivity.screening import ElementaryEffects, OneAtATime, elementary_effects, one_at_a_time
from railsearch.sensitivity.thresholds import UPPER, ThresholdSurfaces, check_limit, threshold_surfaces
from railsearch.sensitivity.variance_based import SobolIndices, closed_form_indices, sobol_indices
from railsearch.sensitivity_study.data import SampledOutput, StudyData, check_outputs
from railsearch.sensitivity_study.on_model import (
    ConfirmedExtreme,
    ModelMeasures,
    ModelSamples,
    confirmed_extremes,
    model_measures,
)
from railsearch.simulation import Simulators

FORMAT = "railsearch sensitivity 1"
QUANTILES = (50.0, 90.0, 99.0)
"""Levels in per cent at which thresholds are added to those asked for."""

BASE_SAMPLE = 4096
TRAJECTORIES = 200
POOR = 0.01
"""Error of a surrogate, of the variance, from which it is said that it is poor."""

DIFFERENT = 0.1
"""Difference between an extreme and the model there, of the range of the samples, from which it is said."""

STREAMS = ("surrogate", "extremes", "sobol", "morris", "refits", "model")
"""What draws random numbers of its own."""


@dataclass(frozen=True)
class StudySettings:
    """What is asked of the samples.

    criteria: outputs, by default those of the data; thresholds: by output, beside the quantiles; points: grid values of a
    factor; surrogate: its name and settings; level: percentile that bounds an input without bounds; limit: `upper` if going
    above a threshold is failing; refits: to parts of the samples, for the spread of importances; seed: of everything random.
    Raises InputError for another limit, a level that is not between 0 and a half, and thresholds that are not finite.
    """

    criteria: tuple[str, ...] = ()
    thresholds: Mapping[str, Sequence[float]] = field(default_factory=dict)
    points: int = 100
    surrogate: str = "pce"
    surrogate_settings: Mapping[str, object] = field(default_factory=dict)
    level: float = 0.01
    limit: str = UPPER
    refits: int = 0
    seed: int = 0

    def __post_init__(self) -> None:
        check_limit(self.limit)
        if not 0.0 < self.level < 0.5:
            raise InputError(f"level: a fraction between 0 and 0.5 is needed, received {self.level:g}")
        for name, values in self.thresholds.items():
            if not np.isfinite(values).all():
                raise InputError(f"thresholds of {name}: finite numbers are needed, received {', '.join(map(str, values))}")


@dataclass(frozen=True)
class StudyWatcher:
    """Who is told what happens: what is done next in words; a refit of a criterion, how many there are, of how many."""

    stage: Callable[[str], None] = lambda text: None
    refit: Callable[[str, int, int], None] = lambda criterion, number, count: None


@dataclass(frozen=True)
class CriterionStudy:
    """All that was found about one output.

    spread: of the importances over refits; on_model: classical measures on the model itself; confirmed: its values where
    the surrogate has its extremes, by sense; each only if it was asked for. whole: inputs that take whole numbers.
    """

    output: SampledOutput
    surrogate: FittedSurrogate
    extremes: ExtremeSurfaces
    thresholds: ThresholdSurfaces
    sobol: SobolIndices
    morris: ElementaryEffects
    one_at_a_time: OneAtATime
    spread: ImportanceSpread | None = None
    on_model: ModelMeasures | None = None
    confirmed: Mapping[str, ConfirmedExtreme] = field(default_factory=dict)
    whole: tuple[str, ...] = ()

    @property
    def outside(self) -> NDArray[np.bool_]:
        """Which samples (n,) lie outside the ranges that are searched."""
        space, points = self.extremes.factors.space, self.output.points
        return np.asarray(((points < space.lower) | (points > space.upper)).any(axis=1))

    @property
    def warnings(self) -> list[str]:
        """Why the extremes may not be those of the model."""
        values, quality, warnings = self.output.values, self.surrogate.quality, []
        span, unit = float(np.ptp(values)), self.output.quantity.unit
        low, high = self.extremes.extreme(MINIMUM), self.extremes.extreme(MAXIMUM)
        if quality.generalisation > POOR:
            warnings.append(
                f"the surrogate misses {quality.generalisation:.1%} of the variance of samples that it has not seen: take "
                "more samples, or another surrogate"
            )
        if not self.confirmed and max(values.min() - low, high - values.max()) > 0.5 * span:
            warnings.append(
                "the surrogate's extremes lie beyond the samples by more than half of what these span: it extrapolates, and "
                "nothing confirms it"
            )
        beyond = values[self.outside]
        if beyond.size and (beyond.max() > high or beyond.min() < low):
            warnings.append(
                f"{beyond.size} samples lie outside the ranges that are searched, and reach from {beyond.min():.4g} to "
                f"{beyond.max():.4g} {unit}".rstrip()
            )
        if self.whole:
            warnings.append(
                f"{', '.join(self.whole)}: whole numbers, searched as real ones, so that extremes may lie between them"
            )
        for sense, extreme in self.confirmed.items():
            if isinstance(extreme.simulated, str):
                warnings.append(f"where the surrogate has its {sense} the model fails: {extreme.simulated}")
            elif abs(extreme.simulated - extreme.found) > DIFFERENT * span:
                warnings.append(
                    f"where the surrogate has its {sense}, {extreme.found:.4g}, the model has {extreme.simulated:.4g} "
                    f"{unit}".rstrip()
                    + ": importances and ranges are those of a surrogate that is wrong there"
                )
        return warnings

    def document(self) -> dict[str, Any]:
        """Plain types, ready for JSON."""
        quantity, values = self.output.quantity, self.output.values
        return {
            "name": quantity.name,
            "unit": quantity.unit,
            "meaning": quantity.meaning,
            "samples": {
                "used": len(values),
                "failed": self.output.failed,
                "repeated": self.output.repeated,
                "outside": int(self.outside.sum()),
                "minimum": float(values.min()),
                "maximum": float(values.max()),
            },
            "surrogate": self.surrogate.quality.document(),
            "held_out": {"true": self.surrogate.true.tolist(), "predicted": self.surrogate.predicted.tolist()},
            "importances": self.extremes.importances(),
            "extremes": self.extremes.document(),
            "thresholds": self.thresholds.document(),
            "sobol": self.sobol.document() | {"of": "the surrogate"},
            "morris": self.morris.document() | {"of": "the surrogate"},
            "one_at_a_time": self.one_at_a_time.document() | {"of": "the surrogate"},
            "spread": None if self.spread is None else self.spread.document(),
            "on_model": None if self.on_model is None else self.on_model.document(),
            "warnings": self.warnings,
            "confirmed": {sense: extreme.document(self.extremes.factors.names) for sense, extreme in self.confirmed.items()},
        }


def check_study(registry: Registry, settings: StudySettings, inputs: RandomVector, outputs: Collection[str]) -> None:
    """Raise what `study_samples` would raise of the settings, before anything is evaluated.

    InputError for an unknown output and fewer than two grid values, and what `surrogate_fit` raises.
    """
    check_outputs(settings.criteria, outputs)
    if settings.points < FEWEST_POINTS:
        raise InputError(f"points: {FEWEST_POINTS} or more are needed, received {settings.points}")
    surrogate_fit(registry, settings.surrogate, settings.surrogate_settings, inputs)


def study_samples(
    registry: Registry,
    data: StudyData,
    settings: StudySettings,
    watcher: StudyWatcher,
    model: ModelSamples | None = None,
) -> list[CriterionStudy]:
    """Study the criteria of the settings; `watcher` is told what is done next.

    model: samples for classical measures on the model itself. Raises InputError for samples that cannot occur, and as the
    surrogate, `factors_on` and `threshold_surfaces` do.
    """
    inputs, outputs = data.inputs, [data.output(name) for name in dict.fromkeys(settings.criteria or data.default)]
    fit = surrogate_fit(registry, settings.surrogate, settings.surrogate_settings, inputs)
    factors = factors_on(input_space(inputs, settings.level, data.ranges, data.units), settings.points)
    studies = []
    for number, output in enumerate(outputs):
        seeds = np.random.SeedSequence([checked_seed(settings.seed), number]).spawn(len(STREAMS))
        generators = {name: np.random.default_rng(seed) for name, seed in zip(STREAMS, seeds, strict=True)}
        study = _studied(output, fit, inputs, factors, settings, generators, watcher, data.whole)
        name = output.quantity.name
        if settings.refits:
            study = replace(study, spread=_spread(output, fit, factors, settings, generators["refits"], watcher))
        if model is not None:
            study = replace(study, on_model=model_measures(name, factors.space, model, generators["model"]))
        studies.append(study)
    return studies


def confirm(studies: Sequence[CriterionStudy], problem: DesignProblem, simulating: Simulators) -> list[CriterionStudy]:
    """The studies with what the model says where their surrogates have their extremes."""
    found = {study.output.quantity: study.extremes for study in studies}
    confirmed = confirmed_extremes(problem, found, simulating)
    return [replace(study, confirmed=confirmed[study.output.quantity.name]) for study in studies]


def _studied(
    output: SampledOutput,
    fit: Fit,
    inputs: RandomVector,
    factors: Factors,
    settings: StudySettings,
    generators: Mapping[str, np.random.Generator],
    watcher: StudyWatcher,
    whole: tuple[str, ...],
) -> CriterionStudy:
    name = output.quantity.name
    watcher.stage(f"{name}: surrogate {settings.surrogate} of {len(output.values)} samples")
    surrogate = fitted_surrogate(fit, inputs.checked(output.points), output.values, generators["surrogate"])
    model = surrogate.model
    watcher.stage(f"{name}: extremes at {factors.number_of_values} grid values")
    extremes = extreme_surfaces(model, factors, generators["extremes"], output=output.quantity)
    asked = sorted({*settings.thresholds.get(name, ()), *map(float, np.percentile(output.values, QUANTILES))})
    watcher.stage(f"{name}: classical measures")
    return CriterionStudy(
        output,
        surrogate,
        extremes,
        threshold_surfaces(extremes, asked, settings.limit),
        _sobol(model, inputs, generators["sobol"]),
        elementary_effects(model.predict, factors.space, TRAJECTORIES, generators["morris"]),
        one_at_a_time(model.predict, factors),
        whole=whole,
    )


def _sobol(model: SmoothFunction, inputs: RandomVector, generator: np.random.Generator) -> SobolIndices:
    """From the coefficients where there are some, else estimated."""
    expansion = getattr(model, "expansion", None)
    if expansion is not None:
        return closed_form_indices(inputs.names, expansion)
    return sobol_indices(model.predict, inputs, BASE_SAMPLE, generator)


def _spread(
    output: SampledOutput,
    fit: Fit,
    factors: Factors,
    settings: StudySettings,
    generator: np.random.Generator,
    watcher: StudyWatcher,
) -> ImportanceSpread:
    progress = partial(watcher.refit, output.quantity.name)
    return bootstrap_importances(output.points, output.values, settings.refits, fit, factors, generator, progress=progress)


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
