"""The construction cost of design problem B against its published values."""

import numpy as np
import pytest

from railsearch.errors import InputError
from railsearch.parameters import make_parameters
from railsearch_problems.construction_cost import Prices, construction_cost


@pytest.mark.parametrize(
    ("spacing", "strengthened", "euro"), [(13, 6, 9967.7), (14, 4, 9362.2), (10, 15, 12413.0), (11, 0, 9207.0)]
)
def test_published_checks(spacing: int, strengthened: int, euro: float) -> None:
    assert construction_cost([spacing], [strengthened], Prices())[0] == pytest.approx(euro, abs=1e-9)


def test_a_strengthened_sleeper_costs_what_it_is_dearer() -> None:
    cost = construction_cost(12, np.arange(16), Prices())
    assert np.allclose(np.diff(cost), 200.0)
    assert cost[0] == 3000.0 + 15 * 400.0


def test_wider_spacings_are_cheaper() -> None:
    assert np.all(np.diff(construction_cost(np.arange(10, 15), 7, Prices())) < 0.0)


def test_own_prices() -> None:
    prices = Prices(spacings=(8, 12), spacing_costs=(50.0, 20.0), sleepers=4, sleeper=1.0, strengthened_sleeper=10.0)
    assert construction_cost([8, 12, 12], [0, 1, 4], prices).tolist() == [54.0, 33.0, 60.0]


@pytest.mark.parametrize("spacing", [9, 15, 11.5])
def test_a_spacing_without_cost(spacing: float) -> None:
    with pytest.raises(InputError, match=rf"costs for 10, 11, 12, 13, 14 \(0.05 m\), received {spacing:g}"):
        construction_cost([12, spacing], [0, 0], Prices())


@pytest.mark.parametrize("strengthened", [-1, 16])
def test_strengthened_sleepers_that_are_not_laid(strengthened: int) -> None:
    with pytest.raises(InputError, match=f"15 sleepers are laid, received {strengthened} strengthened ones"):
        construction_cost([12, 12], [3, strengthened], Prices())


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"spacings": [10, 12]}, "spacing_costs: one cost for each of the 2 spacings is needed, received 5"),
        ({"spacings": [], "spacing_costs": []}, "one cost for each of the 0 spacings"),
        ({"spacings": [12, 10], "spacing_costs": [1.0, 2.0]}, r"ascending is needed, received \[12, 10\]"),
        ({"spacings": [10, 10], "spacing_costs": [1.0, 2.0]}, "each once"),
        ({"sleeper": -1.0}, "cost.sleeper: allowed is ≥ 0, received -1.0 €"),
    ],
)
def test_prices_that_are_not_allowed(values: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make_parameters(Prices, values, "cost")
