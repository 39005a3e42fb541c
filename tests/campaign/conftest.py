"""Fixtures of the campaign tests."""

import pytest
from campaign_runs import DISTRIBUTION


@pytest.fixture
def sample_plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the sample plugin here and in the processes that are started from here."""
    monkeypatch.syspath_prepend(str(DISTRIBUTION))
    monkeypatch.setenv("PYTHONPATH", str(DISTRIBUTION))
