"""Every registered strategy, for tests that hold for all of them."""

import pytest

from railsearch.plugin_manager import load_plugins

SLOW = {"ego": 25, "hypervolume-improvement": 25, "optuna-tpe": 20, "optuna-gp": 14}
"""Budgets for strategies that are slow by their nature: their start and a few proposals of their model."""

SMALL_SETTINGS = {
    "ego": {"polished": 1, "tree_search_nodes": 4},
    "fixed-surrogate": {"starts": 2, "population_size": 20, "generations": 10, "further_generations": 5},
    "hypervolume-improvement": {"evolution_size": 20, "evolution_generations": 8},
}
"""Settings with which strategies do the same with less effort."""

NEEDS_TORCH = ("optuna-gp",)

every_strategy = pytest.mark.parametrize(
    "entry",
    [
        pytest.param(entry, id=entry.name, marks=[pytest.mark.torch] if entry.name in NEEDS_TORCH else [])
        for entry in load_plugins().entries("strategy")
    ],
)


def small_budget(name: str) -> int:
    """Evaluations that take a strategy past its start."""
    return SLOW.get(name, 30)
