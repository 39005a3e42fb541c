"""Parameters as frozen dataclasses whose fields carry unit, meaning, source and allowed range.

The same description serves validation at the door, `railsearch describe` and the commented site file.
"""

import dataclasses
import math
import sys
import types
import typing
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar, cast

from railsearch.errors import InputError, located
from railsearch.wording import did_you_mean

P = TypeVar("P")


@dataclass(frozen=True)
class NoParameters:
    """For plugins that have nothing to set."""


@dataclass(frozen=True)
class Description:
    """What is known of one parameter: dotted name, default, unit, meaning, source and the allowed values in words."""

    name: str
    default: object
    unit: str
    meaning: str
    source: str
    allowed: str


def parameter(
    default: Any = dataclasses.MISSING,
    *,
    meaning: str,
    unit: str = "",
    source: str = "",
    minimum: float | None = None,
    above: float | None = None,
    maximum: float | None = None,
    below: float | None = None,
    choices: Sequence[object] = (),
) -> Any:
    """A dataclass field with its unit, meaning, source and allowed range; without a default it must be given.

    `minimum` and `maximum` are allowed themselves, `above` and `below` are not; `choices` lists the allowed strings.
    The range holds for every number of a sequence. A frozen dataclass may stand as the default of a nested group.
    """
    metadata = {
        "unit": unit,
        "meaning": meaning,
        "source": source,
        "minimum": minimum,
        "above": above,
        "maximum": maximum,
        "below": below,
        "choices": tuple(choices),
    }
    return dataclasses.field(default=default, metadata=metadata)


def make_parameters(cls: type[P], values: Mapping[str, object], where: str) -> P:
    """Build the frozen dataclass `cls` from (nested) `values`; `where` names their origin in messages.

    Raises InputError for unknown and missing names, wrong types, NaN or infinity, and values outside the allowed range, all
    at once.
    """
    check_table(values, where)
    missing = [field.name for field in _settable(cls) if _required(field) and field.name not in values]
    faults = [f"{where}: {', '.join(missing)} must be given"] if missing else []
    checked = _checked_values(cls, values, where, faults)
    with located(where):
        return cls(**checked)


def amend_parameters(start: P, values: Mapping[str, object], where: str) -> P:
    """Replace fields of the frozen dataclass `start` by (nested) `values`, checked as in `make_parameters`."""
    check_table(values, where)
    changes = _checked_values(start, values, where, [])
    with located(where):
        return dataclasses.replace(start, **changes)  # type: ignore[type-var]


def check_table(values: object, where: str) -> None:
    """Raise InputError unless these are values by their names."""
    if not isinstance(values, Mapping):
        raise InputError(f"{where}: a table of names and values is needed, received {values!r}")


def describe_parameters(start: object, prefix: str = "") -> Iterator[Description]:
    """Describe every field of a parameters dataclass instance, nested groups with dotted names."""
    for field in dataclasses.fields(start):  # type: ignore[arg-type]
        value, name = getattr(start, field.name), prefix + field.name
        if dataclasses.is_dataclass(value):
            yield from describe_parameters(value, name + ".")
        else:
            meta = field.metadata
            yield Description(
                name, value, meta.get("unit", ""), meta.get("meaning", ""), meta.get("source", ""), allowed_values(meta)
            )


def field_range(cls: type, name: str) -> tuple[float, float]:
    """The allowed range of a number of the dataclass `cls`, infinite where there is no bound."""
    meta = cls.__dataclass_fields__[name].metadata  # type: ignore[attr-defined]
    low = [float(meta[key]) for key in ("minimum", "above") if meta.get(key) is not None]
    high = [float(meta[key]) for key in ("maximum", "below") if meta.get(key) is not None]
    return max(low, default=-math.inf), min(high, default=math.inf)


def allowed_values(meta: Mapping[str, Any]) -> str:
    """The allowed range of a field in words; empty when everything finite is allowed."""
    signs = (("minimum", "≥"), ("above", ">"), ("maximum", "≤"), ("below", "<"))
    bounds = " and ".join(f"{sign} {meta[key]:g}" for key, sign in signs if meta.get(key) is not None)
    return " or ".join([*map(repr, meta.get("choices") or ()), *filter(None, [bounds])])


def nested(assignments: Mapping[str, object]) -> dict[str, Any]:
    """Turn dotted names into nested tables: {'rail.area': 1} becomes {'rail': {'area': 1}}.

    Raises InputError for a name that is both a value and a table.
    """
    tree: dict[str, Any] = {}
    for name, value in assignments.items():
        *groups, leaf = name.split(".")
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
            if not isinstance(branch, dict):
                raise InputError(
                    f"{name}: {group} has been given the value {branch!r}, so nothing can be set in it; leave one out"
                )
        branch[leaf] = value
    return tree


def _settable(shape: object) -> list[dataclasses.Field[Any]]:
    """The fields of a dataclass, or of an instance of one, that can be given."""
    return [field for field in dataclasses.fields(shape) if field.init]  # type: ignore[arg-type]


def _required(field: dataclasses.Field[Any]) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _checked_values(shape: object, values: Mapping[str, object], where: str, faults: list[str]) -> dict[str, Any]:
    """The values for fields of a dataclass or of an instance. Raises InputError with these faults and all that are found."""
    checked = {}
    for name, value in values.items():
        try:
            checked[name] = _amended_field(shape, name, value, where)
        except InputError as error:
            faults.append(str(error))
    if faults:
        raise InputError("; ".join(faults))
    return checked


@cache
def _type_hints(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def _amended_field(shape: object, name: str, value: object, where: str) -> object:
    """The new value of one field, checked."""
    fields = {field.name: field for field in _settable(shape)}
    if name not in fields:
        raise InputError(f"{where}: unknown parameter '{name}'{did_you_mean(name, list(fields))}")
    current, place = getattr(shape, name, None), f"{where}.{name}"
    if not dataclasses.is_dataclass(current):
        cls = shape if isinstance(shape, type) else type(shape)
        return _checked(value, _type_hints(cls)[name], fields[name].metadata, place)
    if not isinstance(value, Mapping):
        raise InputError(f"{place}: a table of parameters is needed, received {value!r}")
    return amend_parameters(cast(Any, current), value, place)


def _checked(value: object, kind: object, meta: Mapping[str, Any], place: str) -> object:
    options = typing.get_args(kind) if isinstance(kind, types.UnionType) else (kind,)
    if value is None and type(None) in options:
        return None
    for option in options:
        if (converted := _converted(value, option)) is not None:
            _check_range(converted, meta, place)
            return converted
    wanted = " or ".join(_in_words(option) for option in options if option is not type(None))
    raise InputError(f"{place}: {wanted} is needed, received {value!r}")


def _converted(value: object, kind: object) -> object:
    """The value as `kind`, or None if it is not of that kind: 1 passes as float, 1.0 as integer, True as neither."""
    if typing.get_origin(kind) is tuple:
        if not isinstance(value, (list, tuple)):
            return None
        items = [_converted(item, typing.get_args(kind)[0]) for item in value]
        return None if None in items else tuple(items)
    if typing.get_origin(kind) is dict or kind is dict:
        return dict(value) if isinstance(value, Mapping) else None
    if kind in (int, float):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return None
        if isinstance(value, int) and abs(value) > sys.float_info.max:
            return None
        if kind is int and value != int(value if math.isfinite(value) else 0):
            return None
        return int(value) if kind is int else float(value)
    return value if isinstance(value, cast(type, kind)) else None


def _check_range(value: object, meta: Mapping[str, Any], place: str) -> None:
    for item in value if isinstance(value, tuple) else (value,):
        number = isinstance(item, float | int) and not isinstance(item, bool)
        if number and not math.isfinite(cast(float, item)):
            other = "".join(f" or {choice!r}" for choice in meta.get("choices") or ())
            raise InputError(f"{place}: a finite number{other} is needed, received {item!r}")
        if (number and not _inside(cast(float, item), meta)) or (
            isinstance(item, str) and meta.get("choices") and item not in meta["choices"]
        ):
            unit = meta.get("unit", "")
            raise InputError(f"{place}: allowed is {allowed_values(meta)}, received {item!r} {unit}".rstrip())


def _inside(number: float, meta: Mapping[str, Any]) -> bool:
    minimum, above, maximum, below = (meta.get(key) for key in ("minimum", "above", "maximum", "below"))
    return (
        (minimum is None or number >= minimum)
        and (above is None or number > above)
        and (maximum is None or number <= maximum)
        and (below is None or number < below)
    )


def _in_words(kind: object) -> str:
    names = {int: "an integer", float: "a number", str: "a string", bool: "true or false"}
    if typing.get_origin(kind) is tuple:
        return f"a list of {_many_in_words(typing.get_args(kind)[0])}"
    return names.get(cast(type, kind), "a table")


def _many_in_words(kind: object) -> str:
    names = {int: "integers", float: "numbers", str: "strings", bool: "true or false"}
    if typing.get_origin(kind) is tuple:
        return f"lists of {_many_in_words(typing.get_args(kind)[0])}"
    return names.get(cast(type, kind), "tables")
