"""Samples for a sensitivity analysis: of a problem, or a user's own with a file of distributions."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.distributions import INDEPENDENT, RandomVector, random_vector
from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.result import quantities
from railsearch.samples import Samples, input_distributions, read_samples
from railsearch.sensitivity.factors import input_space
from railsearch.site import read_toml
from railsearch.space import FloatArray

INDEPENDENT_BELOW = 1e-6
"""Probability of a rank correlation as strong as that of two inputs, below which they are not taken as independent."""

WEAK = 0.2
"""Rank correlations that are weaker than this are let pass: a Latin hypercube of few samples has such."""


@dataclass(frozen=True)
class SampledOutput:
    """An output with its samples: points (n, d), values (n,), and how many were dropped because they failed or repeat."""

    quantity: Quantity
    points: FloatArray
    values: FloatArray
    failed: int
    repeated: int


@dataclass(frozen=True)
class StudyData:
    """What is analysed: random inputs with units, samples, and the outputs that may be asked for.

    ranges: bounds of inputs, in place of percentiles; default: the outputs that are analysed if none is named; whole: inputs
    that take whole numbers.
    """

    name: str
    inputs: RandomVector
    units: Mapping[str, str]
    ranges: Mapping[str, Sequence[float]]
    samples: Samples
    outputs: Mapping[str, Quantity]
    default: tuple[str, ...]
    whole: tuple[str, ...] = ()

    def output(self, name: str) -> SampledOutput:
        """The samples of an output that can be used. Raises InputError for an unknown one, and as `sampled_output`."""
        check_outputs([name], self.outputs)
        points = self.samples.input_matrix(self.inputs.names)
        return sampled_output(self.outputs[name], points, self.samples.output(name))


def check_outputs(names: Iterable[str], known: Collection[str]) -> None:
    """Raise InputError for an output that there is not."""
    for name in names:
        if name not in known:
            raise InputError(f"criterion: unknown '{name}'; there are {', '.join(known)}")


def problem_data(problem: DesignProblem, file: Path) -> StudyData:
    """Samples of a problem in a file; its variables are the inputs, searched within their bounds.

    Raises InputError for a file that lacks one of them, and as `check_samples` and `check_independent`.
    """
    inputs, variables = input_distributions(problem), problem.space.variables
    return _checked(
        StudyData(
            problem.name,
            inputs,
            {variable.name: variable.unit for variable in variables},
            {variable.name: (variable.lower, variable.upper) for variable in variables},
            read_samples(file, inputs.names),
            {quantity.name: quantity for quantity in quantities(problem)},
            tuple(objective.name for objective in problem.objectives),
            tuple(variable.name for variable in variables if variable.integer),
        )
    )


def own_data(file: Path, distributions: Path) -> StudyData:
    """Samples of a user's own, with a TOML file of tables [distributions.INPUT] and, if wanted, [ranges].

    Raises InputError for anything else in that file, correlations among it, a table without one of the inputs or with
    another unit than stated, and as `check_samples`.
    """
    stated = read_toml(distributions)
    tables, ranges = stated.pop("distributions", None), stated.pop("ranges", {})
    if "correlation" in stated:
        raise InputError(f"{distributions}: correlation: {INDEPENDENT}")
    if stated or not isinstance(tables, dict) or not tables or not all(isinstance(table, dict) for table in tables.values()):
        unknown = f"; unknown: {', '.join(stated)}" if stated else ""
        raise InputError(f"{distributions}: tables [distributions.INPUT], and [ranges] if wanted, are needed{unknown}")
    units = {name: str(table.pop("unit", "")) for name, table in tables.items()}
    inputs = random_vector(tables, where=f"{distributions}: distributions")
    samples = read_samples(file, inputs.names)
    outputs = {name: Quantity(name, samples.output_units.get(name, "")) for name in samples.outputs}
    for name in inputs.names:
        unit, there = units[name], samples.input_units.get(name, "")
        if unit and there and unit != there:
            raise InputError(f"{name}: the unit is '{unit}' in {distributions} and '{there}' in {file}; convert one of them")
        units[name] = unit or there
    return _checked(StudyData(file.name, inputs, units, ranges, samples, outputs, tuple(outputs)))


def _checked(data: StudyData) -> StudyData:
    points = data.samples.input_matrix(data.inputs.names)
    check_samples(data.inputs, points, data.ranges)
    check_independent(data.inputs, points[np.isfinite(points).all(axis=1)])
    return data


def check_samples(inputs: RandomVector, points: FloatArray, ranges: Mapping[str, Sequence[float]]) -> None:
    """Raise InputError for an input that is the same in all samples (n, d), or never within the range that is searched."""
    bounds = input_space(inputs, ranges=ranges)
    for variable, column in zip(bounds.variables, points.T, strict=True):
        known, name = column[np.isfinite(column)], variable.name
        if not known.size:
            raise InputError(f"{name}: none of {len(column)} samples has a value")
        if np.ptp(known) == 0.0:
            raise InputError(
                f"{name}: it is {known[0]:g} in all {known.size} samples, so nothing can be said of it; leave it out of the "
                "inputs, or take samples in which it varies"
            )
        if not ((known >= variable.lower) & (known <= variable.upper)).any():
            raise InputError(
                f"{name}: samples from {known.min():g} to {known.max():g} never come into the range that is searched, "
                f"{variable.lower:g} to {variable.upper:g}: has the distribution another unit?"
            )


def sampled_output(quantity: Quantity, points: FloatArray, values: FloatArray) -> SampledOutput:
    """The samples of an output that can be used: those with a value, each design once.

    Raises InputError if no sample has a value, and if designs that are the same have different values: the model has
    something random.
    """
    known = np.isfinite(values) & np.isfinite(points).all(axis=1)
    if not known.any():
        raise InputError(f"{quantity.name}: none of {len(values)} samples has a value; look at why they failed")
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

    for j in range(1, inputs.dimension):
        for i in range(j):
            found = spearmanr(points[:, i], points[:, j])
            if abs(found.statistic) > WEAK and found.pvalue < INDEPENDENT_BELOW:
                raise InputError(
                    f"samples: {inputs.names[i]} and {inputs.names[j]} have a rank correlation of {found.statistic:.2f}; "
                    f"{INDEPENDENT}"
                )
