"""What a sensitivity analysis says in the terminal."""

from collections.abc import Sequence

from rich.table import Table

from railsearch.commands.options import results
from railsearch.sensitivity.extremes import SENSES
from railsearch.sensitivity_study import CriterionStudy
from railsearch.space import FloatArray
from railsearch.wording import quantity_label, readable

SHOWN = 6


def print_study(study: CriterionStudy) -> None:
    """Errors, extremes, importances and thresholds of one output."""
    quantity, quality, console = study.output.quantity, study.surrogate.quality, results()
    console.rule(quantity_label(quantity.name, quantity.unit), align="left")
    dropped = f", {study.output.failed} failed and {study.output.repeated} repeated left out"
    console.print(
        f"{quality.samples} samples{dropped}; error of the surrogate on {quality.held_out} of them, held out, "
        f"{quality.generalisation:.2g} of the variance"
    )
    _print_extremes(study)
    console.print(_importances(study))
    for threshold in study.thresholds.thresholds:
        console.print(study.thresholds.message(threshold))
        units = {variable.name: variable.unit for variable in study.extremes.factors.space.variables}
        for factor in threshold.factors:
            if factor.critical and factor.safe:
                spans = " or ".join(f"{readable(low)} to {readable(high)}" for low, high in factor.safe)
                console.print(f"  out of reach with {factor.name} in {spans} {units[factor.name]}".rstrip())


def _print_extremes(study: CriterionStudy) -> None:
    """The extremes beside those of the samples and of the problem, and what speaks against them."""
    values, unit, console = study.output.values, study.output.quantity.unit, results()
    for sense, sampled in zip(SENSES, (values.max(), values.min()), strict=True):
        words = f"{sense} {readable(study.extremes.extreme(sense))}, of the samples {readable(float(sampled))}"
        if sense in study.confirmed:
            simulated = study.confirmed[sense].simulated
            words += f", of the problem there {simulated if isinstance(simulated, str) else readable(simulated)}"
        console.print(f"{words} {unit}".rstrip())
    for warning in study.warnings:
        console.print(f"warning: {warning}")


def _importances(study: CriterionStudy) -> Table:
    importances, names = study.extremes.importances(), study.extremes.factors.names
    columns = {"worst case": {name: f"{share:.1%}" for name, share in importances.items()}}
    if study.spread is not None:
        bounds = study.spread.interval().T
        columns["95 % of refits"] = {
            name: f"{low:.1%} to {high:.1%}" for name, (low, high) in zip(names, bounds, strict=True)
        }
    columns["Sobol' total"] = _shares(names, study.sobol.total)
    columns["one at a time"] = _shares(names, study.one_at_a_time.importances)
    columns["mean |effect|"] = dict(zip(names, map(readable, study.morris.mean_absolute.tolist()), strict=True))
    if study.on_model is not None:
        columns["Sobol' total, model"] = _shares(names, study.on_model.sobol.total)
        effects = study.on_model.morris.mean_absolute.tolist()
        columns["mean |effect|, model"] = dict(zip(names, map(readable, effects), strict=True))
    table = Table("input", *columns, box=None, pad_edge=False)
    for name in sorted(importances, key=lambda name: -importances[name])[:SHOWN]:
        table.add_row(name, *(cells[name] for cells in columns.values()))
    return table


def _shares(names: Sequence[str], values: FloatArray) -> dict[str, str]:
    return {name: f"{share:.1%}" for name, share in zip(names, values, strict=True)}
