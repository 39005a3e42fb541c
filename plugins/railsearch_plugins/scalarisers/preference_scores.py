"""Scalarisers `preference-minmax` and `imap`: objectives by how much stakeholders like them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Quantity
from railsearch.preferences import (
    AGGREGATIONS,
    GroupPreferenceParameters,
    PreferenceParameters,
    StatedPreference,
    described,
    largest_shortfall,
    scores,
    stated,
)
from railsearch.preferences.functions import FULL_SCORE
from railsearch.space import FloatArray


class PreferenceScores:
    """What both have in common: stated preferences, and the scores of objectives."""

    ready = True

    def __init__(self, objectives: Sequence[Quantity], preferences: Sequence[StatedPreference]) -> None:
        self._objectives = tuple(objectives)
        self.preferences = tuple(preferences)
        self._weights = np.array([preference.weight for preference in preferences])

    @property
    def values(self) -> Mapping[str, object]:
        """Every preference function with its parameters (`extended`: not clipped to 0 … 100) and its weight."""
        return {"preferences": [described(preference) for preference in self.preferences]}

    def prepare(self, reference: FloatArray) -> None:
        """Nothing depends on the reference design."""

    def _scores(self, objectives: FloatArray) -> FloatArray:
        """The scores P (n, k) of objectives f (n, m)."""
        columns = zip(self._objectives, np.asarray(objectives, dtype=float).T, strict=True)
        return scores(self.preferences, {quantity.name: quantity.sign * column for quantity, column in columns})


class PreferenceMinMax(PreferenceScores):
    """Largest weighted shortfall of a preference score from 100: min max_i w_i [100 − P_i(f_i)]."""

    Parameters = PreferenceParameters

    def __init__(self, parameters: PreferenceParameters, objectives: Sequence[Quantity], worst: Mapping[str, float]) -> None:
        (everybody,) = stated(parameters, objectives, "preference-minmax")
        super().__init__(objectives, everybody.preferences)

    def __call__(self, objectives: FloatArray) -> FloatArray:
        """The scalars g (n,) of objectives f (n, m)."""
        return largest_shortfall(self._scores(objectives), self._weights)


class GroupPreference(PreferenceScores):
    """What aggregated group preference lacks of 100: the scores of several stakeholders, weighted, become one (IMAP).

    Each preference counts with the stakeholder's share in the group times its share in what the stakeholder wants.
    Source: Zhilyaev, Binnekamp and Wolfert 2022.
    """

    Parameters = GroupPreferenceParameters

    def __init__(
        self, parameters: GroupPreferenceParameters, objectives: Sequence[Quantity], worst: Mapping[str, float]
    ) -> None:
        group = stated(parameters, objectives, "imap")
        total = sum(stakeholder.weight for stakeholder in group)
        shares = [
            replace(preference, weight=stakeholder.weight / total * preference.weight / _weight(stakeholder.preferences))
            for stakeholder in group
            for preference in stakeholder.preferences
        ]
        super().__init__(objectives, shares)
        self._aggregation = parameters.aggregation

    @property
    def values(self) -> Mapping[str, object]:
        """Every preference function with its parameters and its share, and the aggregation."""
        return {**super().values, "aggregation": self._aggregation}

    def __call__(self, objectives: FloatArray) -> FloatArray:
        """The scalars g = 100 − A (n,) of objectives f (n, m)."""
        return FULL_SCORE - AGGREGATIONS[self._aggregation](self._scores(objectives), self._weights)


def _weight(preferences: Sequence[StatedPreference]) -> float:
    return sum(preference.weight for preference in preferences)


@hookimpl
def railsearch_scalarisers(register: Register) -> None:
    """Register `preference-minmax` and `imap`."""
    register("preference-minmax", PreferenceMinMax)
    register("imap", GroupPreference)
