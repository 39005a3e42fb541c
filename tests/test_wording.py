"""How numbers are shown."""

import pytest

from railsearch.wording import readable


@pytest.mark.parametrize(
    ("value", "shown"), [(-0.0, "0"), (0.0, "0"), (-0.04, "-0.04"), (1234567.8, "1.2346e+06"), (12, "12"), (None, "–")]
)
def test_numbers_are_shown_with_five_digits_and_no_sign_at_zero(value: object, shown: str) -> None:
    assert readable(value) == shown
