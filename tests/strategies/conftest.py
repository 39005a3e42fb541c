"""One core, as in a run: threads cost small matrices more than they save."""

import pytest
from threadpoolctl import threadpool_limits


@pytest.fixture(autouse=True, scope="session")
def one_core():
    with threadpool_limits(1):
        yield
