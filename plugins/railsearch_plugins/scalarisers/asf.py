"""Scalariser `asf`: the achievement scalarising function of the level-crossing study (Shang et al. 2023)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from railsearch.errors import InputError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Quantity, parameter
from railsearch.objective_values import minimised, natural
from railsearch.scalarise import augmented_chebyshev
from railsearch.space import FloatArray


@dataclass(frozen=True)
class AchievementParameters:
    """Aspirations, worst values and augmentation. The dictionaries go by objective name, in its unit and with its sign."""

    aspiration_fraction: float = parameter(
        0.8,
        meaning="aspiration as a fraction of the reference design's value: 0.8 asks for an improvement by 20 %",
        source="level-crossing study, Shang et al. 2023",
        above=0.0,
        maximum=1.0,
    )
    rho: float = parameter(
        0.05,
        meaning="augmentation coefficient: how much the sum of the achievements counts beside the largest one",
        source="level-crossing study, Shang et al. 2023",
        minimum=0.0,
    )
    aspiration: dict[str, float] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="aspiration values by objective, in place of the fraction of the reference design's"
    )
    worst: dict[str, float] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="worst values by objective, in place of those of the problem"
    )


class AchievementScalarisingFunction:
    """Augmented Chebyshev distance of the objectives from the values aspired to, in units of worst minus aspired."""

    Parameters = AchievementParameters

    def __init__(
        self, parameters: AchievementParameters, objectives: Sequence[Quantity], worst: Mapping[str, float]
    ) -> None:
        explicit = minimised(parameters.aspiration or {}, objectives, "asf.aspiration")
        self._parameters = parameters
        self._objectives = tuple(objectives)
        self._worst = _worst_values(objectives, {**worst, **minimised(parameters.worst or {}, objectives, "asf.worst")})
        self._explicit = np.array([explicit.get(objective.name, np.nan) for objective in objectives])
        self._aspiration = self._checked(self._explicit)

    @property
    def ready(self) -> bool:
        """False as long as an aspiration depends on the reference design and that is unknown."""
        return not bool(np.isnan(self._aspiration).any())

    @property
    def aspiration(self) -> Mapping[str, float]:
        """The aspiration point by objective name, with its natural sign; NaN where it is not known yet."""
        return self._by_name(self._aspiration)

    @property
    def worst(self) -> Mapping[str, float]:
        """The worst values by objective name, with their natural sign."""
        return self._by_name(self._worst)

    @property
    def values(self) -> Mapping[str, object]:
        """Aspirations, worst values and augmentation in use."""
        return {"aspiration": self.aspiration, "worst": self.worst, "rho": self._parameters.rho}

    def prepare(self, reference: FloatArray) -> None:
        """Set the aspirations that are not explicit to f − (1 − fraction) |f|, with f (m,) of the reference design.

        That is the fraction of f where f is positive. Raises InputError for an aspiration not below its worst value.
        """
        values = np.asarray(reference, dtype=float)
        wished = values - (1.0 - self._parameters.aspiration_fraction) * np.abs(values)
        self._aspiration = self._checked(np.where(np.isnan(self._explicit), wished, self._explicit))

    def __call__(self, objectives: FloatArray) -> FloatArray:
        """The scalars g (n,) of objectives f (n, m)."""
        return augmented_chebyshev(objectives, self._aspiration, self._worst, self._parameters.rho)

    def _checked(self, aspiration: FloatArray) -> FloatArray:
        for objective, wished, worst in zip(self._objectives, aspiration, self._worst, strict=True):
            if wished >= worst:
                side = "above" if objective.maximised else "below"
                raise InputError(
                    f"asf: the aspiration of {objective.name} must lie {side} its worst value, received "
                    f"{objective.sign * wished:g} and {objective.sign * worst:g}; set aspiration or worst for "
                    f"{objective.name}"
                )
        return aspiration

    def _by_name(self, values: FloatArray) -> dict[str, float]:
        names = [objective.name for objective in self._objectives]
        return natural(dict(zip(names, values.tolist(), strict=True)), self._objectives)


def _worst_values(objectives: Sequence[Quantity], worst: Mapping[str, float]) -> FloatArray:
    missing = [objective.name for objective in objectives if objective.name not in worst]
    if missing:
        raise InputError(
            f"asf: the worst value of {', '.join(missing)} is not known: sample it with `railsearch sample PROBLEM` and "
            "set it under worst"
        )
    return np.array([worst[objective.name] for objective in objectives], dtype=float)


@hookimpl
def railsearch_scalarisers(register: Register) -> None:
    """Register `asf`."""
    register("asf", AchievementScalarisingFunction)
