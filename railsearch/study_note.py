"""The note of a study in Optuna's dashboard: what was searched, in which units, from which reference design."""

from collections.abc import Mapping
from typing import Any

from railsearch.design_problem import DesignProblem
from railsearch.result import RunCommand, quantities


def study_note(problem: DesignProblem, command: RunCommand) -> str:
    """A note in Markdown: problem, units, reference design, strategy, budget, seed, and the command."""
    identity = command.identity
    reference = None if problem.reference is None else problem.space.named(problem.reference)
    lines = [
        f"# {problem.label}",
        "",
        *_place(identity),
        f"Strategy `{identity['strategy']['name']}`, {identity['budget']} evaluations, seed {identity['seed']}"
        f"{_initial(identity)}. "
        "All values are stored as minimised; a maximised quantity is negated.",
        "",
        "## Quantities",
        "",
        "| quantity | unit | meaning |",
        "|---|---|---|",
        *(f"| {quantity.name} | {quantity.unit or '-'} | {quantity.meaning} |" for quantity in quantities(problem)),
        "",
        "## Variables",
        "",
        "| variable | unit | range | reference | meaning |",
        "|---|---|---|---|---|",
        *(
            f"| {v.name} | {v.unit or '-'} | {v.lower:g} to {v.upper:g}{', whole' if v.integer else ''} "
            f"| {'-' if reference is None else format(reference[v.name], 'g')} | {v.meaning} |"
            for v in problem.space.variables
        ),
        "",
        "Column `evaluation` is the number of the tables, from 1 in the order of proposal. Columns `origin` and "
        "`trajectory` tell how a design came about and after how many resets; a failed trial has its `reason`.",
        "",
        f"    {command.line}",
    ]
    return "\n".join(lines)


def _place(identity: Mapping[str, Any]) -> list[str]:
    """Where a run belongs in a campaign, if it does."""
    cell = identity.get("cell")
    if cell is None:
        return []
    return [
        f"Campaign **{cell['campaign']}**, problem **{cell['problem']}**, strategy **{cell['strategy']}**, "
        f"repetition {cell['repetition']}.",
        "",
    ]


def _initial(identity: Mapping[str, Any]) -> str:
    return f" (initial design: {identity['initial_seed']})" if "initial_seed" in identity else ""
