"""The note of a study in Optuna's dashboard: what was searched, in which units, from which reference design."""

from railsearch.design_problem import DesignProblem
from railsearch.result import RunCommand, quantities


def study_note(problem: DesignProblem, command: RunCommand) -> str:
    """A note in Markdown: problem, units, reference design, strategy, budget, seed, and the command."""
    identity = command.identity
    reference = None if problem.reference is None else problem.space.named(problem.reference)
    lines = [
        f"# {problem.label}",
        "",
        f"Strategy `{identity['strategy']['name']}`, {identity['budget']} evaluations, seed {identity['seed']}. "
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
        "Trial n is evaluation n + 1 of the tables and of result.json (column `evaluation`). Columns `origin` and "
        "`trajectory` tell how a design came about and after how many resets; a failed trial has its `reason`.",
        "",
        f"    {command.line}",
    ]
    return "\n".join(lines)
