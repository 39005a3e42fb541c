from dataclasses import dataclass

import pytest

from railsearch.errors import InputError
from railsearch.parameters import describe_parameters, make_parameters, nested, parameter


@dataclass(frozen=True)
class Pad:
    stiffness: float = parameter(1.0, unit="MN/m", meaning="stiffness", source="a table", above=0.0, maximum=9.0)
    rows: int | None = parameter(None, meaning="rows", minimum=0)
    spacings: tuple[float, ...] = parameter((0.6, 0.4), unit="m", meaning="distances", above=0.0)
    load: float | str = parameter(50e3, meaning="load", choices=("from masses",), above=0.0)
    mirrored: bool = parameter(True, meaning="mirrored")


@dataclass(frozen=True)
class Zone:
    pad: Pad = Pad()
    name: str = parameter("A", meaning="name", choices=("A", "B"))


def test_values_replace_defaults_and_keep_their_kind() -> None:
    values = {"pad": {"stiffness": 2, "rows": 3.0, "spacings": [1, 2], "load": "from masses"}, "name": "B"}
    zone = make_parameters(Zone, values, "site")
    assert zone == Zone(Pad(2.0, 3, (1.0, 2.0), "from masses"), "B")
    assert isinstance(zone.pad.stiffness, float)
    assert isinstance(zone.pad.rows, int)
    assert make_parameters(Zone, {"pad": {"rows": None}}, "site") == Zone()


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"pad": {"stiffness": 0}}, ("site.pad.stiffness", "> 0 and ≤ 9", "0.0 MN/m")),
        ({"pad": {"stiffness": 9.5}}, ("site.pad.stiffness", "9.5 MN/m")),
        ({"pad": {"stiffness": float("nan")}}, ("site.pad.stiffness", "finite", "nan")),
        ({"pad": {"stiffness": True}}, ("site.pad.stiffness", "a number", "True")),
        ({"pad": {"stiffness": "soft"}}, ("site.pad.stiffness", "a number", "'soft'")),
        ({"pad": {"rows": 1.5}}, ("site.pad.rows", "an integer", "1.5")),
        ({"pad": {"rows": float("inf")}}, ("site.pad.rows", "an integer", "inf")),
        ({"pad": {"rows": 10**400}}, ("site.pad.rows", "an integer", "1000")),
        ({"pad": {"stiffness": 10**400}}, ("site.pad.stiffness", "a number", "1000")),
        ({"pad": {"spacings": [0.6, -1]}}, ("site.pad.spacings", "> 0", "-1.0 m")),
        ({"pad": {"spacings": 0.6}}, ("site.pad.spacings", "a list", "0.6")),
        ({"pad": {"load": "guess"}}, ("site.pad.load", "'from masses'", "'guess'")),
        ({"pad": {"mirrored": 1}}, ("site.pad.mirrored", "true or false", "1")),
        ({"pad": 3}, ("site.pad", "a table", "3")),
        ({"name": "C"}, ("site.name", "'A' or 'B'", "'C'")),
        ({"pad": {"stifness": 3}}, ("site.pad", "unknown", "'stifness'", "did you mean 'stiffness'")),
    ],
)
def test_what_is_not_allowed_is_named_with_its_value(values: dict[str, object], words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as caught:
        make_parameters(Zone, values, "site")
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_descriptions_carry_unit_source_and_range() -> None:
    described = {row.name: row for row in describe_parameters(Zone())}
    assert list(described) == ["pad.stiffness", "pad.rows", "pad.spacings", "pad.load", "pad.mirrored", "name"]
    row = described["pad.stiffness"]
    assert (row.default, row.unit, row.meaning, row.source, row.allowed) == (
        1.0,
        "MN/m",
        "stiffness",
        "a table",
        "> 0 and ≤ 9",
    )


def test_dotted_names_become_tables() -> None:
    assert nested({"a.b": 1, "a.c.d": 2, "e": 3}) == {"a": {"b": 1, "c": {"d": 2}}, "e": 3}


@pytest.mark.parametrize("names", [("a", "a.b"), ("a.b", "a.b.c.d")])
def test_a_value_that_is_given_as_a_table_too_is_refused(names: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match=rf"{names[1]}: \w has been given the value 1, so nothing can be set in it"):
        nested(dict.fromkeys(names, 1))


def test_all_faults_are_named_at_once() -> None:
    values = {"pad": {"stifness": 3, "rows": -1}, "name": "C", "colour": "red"}
    with pytest.raises(InputError) as caught:
        make_parameters(Zone, values, "site")
    assert all(word in str(caught.value) for word in ("'stifness'", "site.pad.rows", "'C'", "'colour'")), str(caught.value)
