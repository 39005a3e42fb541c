"""Values by quantity: as users write them, with their natural sign, and as they are minimised."""

import sys
from collections.abc import Mapping, Sequence
from typing import Any

from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.wording import closest


def minimised(values: Mapping[str, Any], quantities: Sequence[Quantity], where: str) -> dict[str, float]:
    """Natural values by quantity as they are minimised: those of maximised quantities negated.

    Raises InputError, `where` naming the field, for an unknown objective and for anything but a finite number.
    """
    signs = {quantity.name: quantity.sign for quantity in quantities}
    for name, value in values.items():
        if name not in signs:
            hint = closest(name, list(signs))
            raise InputError(f"{where}: unknown objective '{name}'{hint}; the objectives are {', '.join(signs)}")
        check_finite(value, f"{where}.{name}")
    return {name: signs[name] * float(value) for name, value in values.items()}


def natural(values: Mapping[str, float], quantities: Sequence[Quantity]) -> dict[str, float]:
    """Values by quantity, as they are minimised, with their natural sign."""
    signs = {quantity.name: quantity.sign for quantity in quantities}
    return {name: signs[name] * value for name, value in values.items()}


def weights_by_name(values: Mapping[str, Any] | None, names: Sequence[str], where: str) -> dict[str, float]:
    """The weights of all names, 1 where none is given.

    Raises InputError for an unknown name, a negative weight, anything but a finite number, and weights that are all zero.
    """
    for name, value in (values or {}).items():
        if name not in names:
            raise InputError(f"{where}: unknown '{name}'{closest(name, names)}; there are {', '.join(names)}")
        check_finite(value, f"{where}.{name}")
        if value < 0.0:
            raise InputError(f"{where}.{name}: a weight ≥ 0 is needed, received {value!r}; 0 leaves {name} out")
    weights = {name: float((values or {}).get(name, 1.0)) for name in names}
    if names and not any(weights.values()):
        raise InputError(f"{where}: all weights are zero ({', '.join(names)}); one of them must be above 0")
    return weights


def check_finite(value: object, field: str) -> None:
    """Raise InputError for anything but a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise InputError(f"{field}: a finite number is needed, received {value!r}")
