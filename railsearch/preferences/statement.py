"""Preferences as they are stated, in Python or in a file: a function per quantity, weights, and stakeholders.

[preferences.E_max]          # a function of the quantity's values, with their natural sign and in its unit
function = "linear"
unit = "N·m"                 # optional; refused if it is not the quantity's
best = 0.1
worst = 1.4

[weights]                    # 1 where none is given; 0 leaves a quantity out
E_max = 2.0

[stakeholders.manager]       # for a group: their own functions and weights in place of those above
weight = 1.0
weights = { C_cap = 3.0 }
preferences.C_cap = { function = "linear", best = 8500.0, worst = 12500.0 }
"""

import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.objective_values import weights_by_name
from railsearch.parameters import make_parameters, parameter
from railsearch.preferences.aggregation import AGGREGATIONS
from railsearch.preferences.functions import Desirability, Linear, MonotoneSpline, PiecewiseLinear, PreferenceFunction
from railsearch.preferences.physical_programming import GROWTH_STEP, PhysicalProgramming
from railsearch.space import FloatArray
from railsearch.wording import closest, did_you_mean

FUNCTIONS: Mapping[str, type] = {
    cast(Any, kind).function: kind for kind in (Linear, PiecewiseLinear, MonotoneSpline, PhysicalProgramming, Desirability)
}
Tables = Mapping[str, Any]


@dataclass(frozen=True)
class StatedPreference:
    """What one stakeholder (or, with an empty name, everybody) thinks of a quantity, and how much that weighs."""

    quantity: Quantity
    function: PreferenceFunction
    weight: float
    stakeholder: str = ""


@dataclass(frozen=True)
class Stakeholder:
    """A stakeholder's own preferences, and the weight of the stakeholder in the group."""

    name: str
    weight: float
    preferences: tuple[StatedPreference, ...]


@dataclass(frozen=True)
class PreferenceParameters:
    """Preference functions by objective name, as tables or as functions, and weights."""

    preferences: dict[str, Any] | None = parameter(  # noqa: RUF009 - a field, not a value
        None,
        meaning="preference functions by objective name, for instance "
        "{ E_max = { function = 'linear', unit = 'N·m', best = 0.1, worst = 1.4 } }; docs/preferences.md has all",
    )
    weights: dict[str, Any] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="weights by objective name, 1 where none is given"
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "preferences", _tables(self.preferences, "preferences"))


@dataclass(frozen=True)
class GroupPreferenceParameters(PreferenceParameters):
    """Those of a group: the preferences above hold for stakeholders without one of their own."""

    stakeholders: dict[str, Any] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="by stakeholder's name: weight, weights and preferences of their own"
    )
    aggregation: str = parameter(
        "mean", meaning="how the weighted scores of all stakeholders become one", choices=tuple(AGGREGATIONS)
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.stakeholders is not None:
            made = {name: _stakeholder_table(name, table) for name, table in self.stakeholders.items()}
            object.__setattr__(self, "stakeholders", made)


def stated(parameters: PreferenceParameters, quantities: Sequence[Quantity], where: str) -> list[Stakeholder]:
    """The preferences of all stakeholders on these quantities; without stakeholders of one that has no name.

    Functions of physical programming without a growth get one in common, above the number of preferences less one.
    Raises InputError, `where` naming the place, for a quantity that is unknown, that nobody has stated a preference on
    (unless its weight is 0), or whose unit or direction does not fit, and for weights that are negative or all zero.
    """
    tables = getattr(parameters, "stakeholders", None) or {"": {}}
    shares = weights_by_name(
        {name: table.get("weight", 1.0) for name, table in tables.items()}, list(tables), f"{where}.stakeholders.weight"
    )
    found = []
    for name, table in tables.items():
        place = f"{where}.stakeholders.{name}" if name else where
        functions = {**(parameters.preferences or {}), **(table.get("preferences") or {})}
        weights = {**(parameters.weights or {}), **(table.get("weights") or {})}
        preferences = tuple(_preferences(functions, weights, quantities, name, place))
        if name and not preferences:
            raise InputError(f"{place}: there are no preferences; state one in [stakeholders.{name}.preferences.OBJECTIVE]")
        found.append(Stakeholder(name, shares[name], preferences))
    _check_complete(found, quantities, parameters.weights or {}, where)
    return _commensurate(found)


def scores(preferences: Sequence[StatedPreference], values: Mapping[str, FloatArray]) -> FloatArray:
    """The scores (n, k) of k preferences for values (n,) by quantity, with their natural sign."""
    return np.column_stack([stated.function.score(values[stated.quantity.name]) for stated in preferences])


def described(preference: StatedPreference) -> dict[str, Any]:
    """A stated preference in plain types: whose, on what, the function with its parameters, and what it weighs."""
    parameters = dataclasses.asdict(cast(Any, preference.function))
    function, extended = parameters.pop("function"), parameters.pop("extended")
    return {
        "stakeholder": preference.stakeholder,
        "quantity": preference.quantity.name,
        "unit": preference.quantity.unit,
        "weight": preference.weight,
        "function": function,
        "parameters": {name: value for name, value in parameters.items() if value is not None},
        "extended": extended,
    }


def quantities_of(tables: Tables) -> dict[str, list[PreferenceFunction]]:
    """The functions that a statement {preferences, stakeholders} has on each quantity, by name. Raises InputError."""
    found: dict[str, list[PreferenceFunction]] = {}
    for group in (tables, *(tables.get("stakeholders") or {}).values()):
        for name, table in (group.get("preferences") or {}).items():
            found.setdefault(name, []).append(_function(table, f"preferences.{name}"))
    return found


def _tables(preferences: object, where: str) -> dict[str, dict[str, Any]] | None:
    """Preferences by name as tables in plain types, checked."""
    if preferences is None:
        return None
    if not isinstance(preferences, Mapping):
        raise InputError(f"{where}: tables by the name of an objective are needed, received {preferences!r}")
    return {name: _table(entry, f"{where}.{name}") for name, entry in preferences.items()}


def _table(entry: object, where: str) -> dict[str, Any]:
    """A preference as a table with the name of its function, all of its parameters, and the unit if one is given."""
    function = _function(entry, where)
    values = dataclasses.asdict(cast(Any, function))
    table = {"function": values.pop("function"), **values}
    return {**table, "unit": entry["unit"]} if isinstance(entry, Mapping) and "unit" in entry else table


def _function(entry: object, where: str) -> PreferenceFunction:
    """The preference function of a table, or one made in Python as it is."""
    if isinstance(entry, tuple(FUNCTIONS.values())):
        return cast(PreferenceFunction, entry)
    if not isinstance(entry, Mapping):
        raise InputError(f'{where}: a table is needed, for instance {{ function = "linear", … }}, received {entry!r}')
    values = dict(entry)
    name, unit = values.pop("function", None), values.pop("unit", "")
    if not isinstance(unit, str):
        raise InputError(f"{where}.unit: a string is needed, received {unit!r}")
    kind = FUNCTIONS.get(name.replace("_", "-")) if isinstance(name, str) else None
    if kind is None:
        problem = "must be given" if name is None else f"unknown {name!r}"
        raise InputError(f"{where}.function: {problem}{did_you_mean(str(name), list(FUNCTIONS))}")
    return cast(PreferenceFunction, make_parameters(kind, values, where))


def _stakeholder_table(name: str, table: object) -> dict[str, Any]:
    """The table of a stakeholder in plain types, checked."""
    where = f"stakeholders.{name}"
    if not name or not isinstance(table, Mapping):
        raise InputError(f"{where}: a name and a table with weight, weights and preferences are needed, received {table!r}")
    made = make_parameters(_StakeholderTable, table, where)
    return dataclasses.asdict(made) | {"preferences": _tables(made.preferences, f"{where}.preferences")}


@dataclass(frozen=True)
class _StakeholderTable:
    weight: float = parameter(1.0, meaning="weight of the stakeholder in the group", minimum=0.0)
    weights: dict[str, Any] | None = None
    preferences: dict[str, Any] | None = None


def _preferences(
    tables: Tables, weights: Mapping[str, Any], quantities: Sequence[Quantity], stakeholder: str, where: str
) -> Iterator[StatedPreference]:
    """The preferences of a stakeholder in the order of the quantities."""
    names = [quantity.name for quantity in quantities]
    for name in tables:
        if name not in names:
            hint = closest(name, names)
            raise InputError(f"{where}.preferences: unknown objective '{name}'{hint}; the objectives are {', '.join(names)}")
    checked = weights_by_name(weights, names, f"{where}.weights")
    for name in weights:
        if name not in tables and checked[name] > 0.0:
            raise InputError(
                f"{where}.weights.{name}: there is no preference function on {name}; state one, or set its weight to 0"
            )
    own = weights_by_name({name: checked[name] for name in tables}, [*tables], f"{where}.weights")
    for quantity in quantities:
        if quantity.name in tables:
            place = f"{where}.preferences.{quantity.name}"
            _check_unit(tables[quantity.name], quantity, place)
            yield StatedPreference(quantity, _function(tables[quantity.name], place), own[quantity.name], stakeholder)


def _check_unit(table: Tables, quantity: Quantity, where: str) -> None:
    if table.get("unit", quantity.unit) != quantity.unit:
        raise InputError(
            f"{where}.unit: the unit of {quantity.name} is '{quantity.unit}', received '{table['unit']}'; give the values "
            f"in '{quantity.unit}'"
        )


def _check_complete(
    stakeholders: Sequence[Stakeholder], quantities: Sequence[Quantity], weights: Mapping[str, float], where: str
) -> None:
    """Raise InputError for a quantity on which nobody has a preference, or none in the direction of the search."""
    preferences = [preference for stakeholder in stakeholders for preference in stakeholder.preferences]
    missing = []
    for quantity in quantities:
        functions = [preference.function for preference in preferences if preference.quantity == quantity]
        if not functions and weights.get(quantity.name) != 0.0:
            missing.append(quantity.name)
        against = "smaller" if quantity.maximised else "larger"
        if functions and all(function.liking == against for function in functions):
            raise InputError(
                f"{where}.preferences.{quantity.name}: {quantity.name} is {'max' if quantity.maximised else 'min'}imised, "
                f"but this function likes {against} values better; exchange its ends"
            )
    if missing:
        raise InputError(
            f"{where}.preferences: a function on {', '.join(missing)} is missing; state it in [preferences.{missing[0]}] "
            f"of a preference file, or leave {missing[0]} out with weight 0"
        )


def _commensurate(stakeholders: Iterable[Stakeholder]) -> list[Stakeholder]:
    """Give all functions of physical programming the same growth, so that an end of a range is worth the same in all."""
    group = list(stakeholders)
    preferences = [preference for stakeholder in group for preference in stakeholder.preferences]
    free = [p.function for p in preferences if isinstance(p.function, PhysicalProgramming) and p.function.growth is None]
    growth = max([GROWTH_STEP * (len(preferences) - 1), *(function.least_growth for function in free)])
    return [
        replace(stakeholder, preferences=tuple(_with_growth(preference, growth) for preference in stakeholder.preferences))
        for stakeholder in group
    ]


def _with_growth(preference: StatedPreference, growth: float) -> StatedPreference:
    function = preference.function
    if isinstance(function, PhysicalProgramming) and function.growth is None:
        return replace(preference, function=replace(function, growth=growth))
    return preference
