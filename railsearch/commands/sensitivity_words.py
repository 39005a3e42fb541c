"""What a sensitivity analysis says in the terminal."""

from rich.table import Table

from railsearch.commands.options import results
from railsearch.sensitivity.extremes import SENSES
from railsearch.sensitivity_study import CriterionStudy
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
    table = Table("input", "worst case", "Sobol' total", "one at a time", "mean |effect|", box=None, pad_edge=False)
    spread = None if study.spread is None else study.spread.interval()
    for name in sorted(importances, key=lambda name: -importances[name])[:SHOWN]:
        place = names.index(name)
        worst = f"{importances[name]:.1%}"
        if spread is not None:
            worst += f" ({spread[0, place]:.1%} to {spread[1, place]:.1%})"
        shares = (study.sobol.total[place], study.one_at_a_time.importances[place])
        table.add_row(name, worst, *(f"{share:.1%}" for share in shares), readable(float(study.morris.mean_absolute[place])))
    return table
