"""Which strategies of a campaign can search which problems, found out before anything runs."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from railsearch.campaign.cells import Campaign, Cell
from railsearch.campaign.identity import cell_settings
from railsearch.design_problem import DesignProblem
from railsearch.errors import CapabilityError, RailsearchError
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import given_designs
from railsearch.run import make_strategy
from railsearch.space import FloatArray


@dataclass(frozen=True)
class Refusal:
    """A strategy that cannot search a problem, by their labels, and why."""

    problem: str
    strategy: str
    reason: str


def refusals(registry: Registry, campaign: Campaign, problems: Mapping[str, DesignProblem]) -> list[Refusal]:
    """Every pair that cannot be run: objectives, integers, constraints, batch, or a budget too small for the strategy."""
    found = []
    for entry in campaign.problems:
        problem = problems[entry.label]
        given = given_designs(problem, entry.given)
        for strategy in campaign.strategies:
            reason = _reason(registry, campaign, Cell(entry.label, strategy.label, 1), problem, given)
            if reason:
                found.append(Refusal(entry.label, strategy.label, reason))
    return found


def check_capable(campaign: Campaign, refused: Iterable[Refusal], skip_incapable: bool = False) -> None:
    """Raise CapabilityError with all refusals; with `skip_incapable` only if nothing is left."""
    rows = [f"{refusal.strategy} on {refusal.problem}: {refusal.reason}" for refusal in refused]
    n_pairs = len(campaign.problems) * len(campaign.strategies)
    if not rows or (skip_incapable and len(rows) < n_pairs):
        return
    remedy = (
        "No pair is left; nothing was run"
        if len(rows) == n_pairs
        else "Nothing was run; change the file, or leave these pairs out with --skip-incapable"
    )
    head = f"{len(rows)} of {n_pairs} pairs of a strategy and a problem cannot be run:"
    raise CapabilityError("\n- ".join((head, *rows)) + f"\n{remedy}")


def capable_cells(campaign: Campaign, refused: Iterable[Refusal]) -> Iterator[Cell]:
    """The cells of a campaign without those refused, in their order."""
    left_out = {(refusal.problem, refusal.strategy) for refusal in refused}
    return (cell for cell in campaign.cells() if (cell.problem, cell.strategy) not in left_out)


def _reason(registry: Registry, campaign: Campaign, cell: Cell, problem: DesignProblem, given: list[FloatArray]) -> str:
    """Why a cell cannot be run; empty if it can."""
    try:
        make_strategy(registry, problem, cell_settings(campaign, cell), len(given))
    except RailsearchError as error:
        return str(error)
    except Exception as error:  # noqa: BLE001 - a stranger's strategy may raise anything when it is made
        return f"the strategy cannot be made: {type(error).__name__}: {error}"
    return ""
