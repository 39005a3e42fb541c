"""The cells of a campaign that have evaluations, in the order in which they are exported."""

from railsearch.campaign.cells import Cell
from railsearch.campaign.results import CampaignResults, CellRecord

Recorded = list[tuple[Cell, CellRecord]]


def recorded_cells(results: CampaignResults) -> Recorded:
    """Cells with one evaluation or more and their records, by problem and strategy as the campaign lists them."""
    problems = [problem.label for problem in results.campaign.problems]
    strategies = [strategy.label for strategy in results.campaign.strategies]
    cells = (cell for cell, record in results.records.items() if len(record.objectives))
    order = sorted(cells, key=lambda c: (problems.index(c.problem), strategies.index(c.strategy), c.repetition))
    return [(cell, results.records[cell]) for cell in order]
