"""The errors that railsearch raises. Their text says what was wrong, where, the value received and the remedy."""

from collections.abc import Iterator
from contextlib import contextmanager


class RailsearchError(Exception):
    """Base of every error that a user can mend; the command line prints it in a line or two and ends with code 2."""


class InputError(RailsearchError, ValueError):
    """A value given by the user is not allowed."""


class PluginError(RailsearchError):
    """A plugin is unknown, broken, misspelt or takes a name that is taken."""


class CapabilityError(RailsearchError):
    """A strategy cannot handle what the problem asks of it."""


class StorageError(RailsearchError):
    """The record of a run cannot be written, or belongs to another run."""


class CampaignError(RailsearchError):
    """Cells of a campaign could not be finished."""


class SurrogateError(RailsearchError):
    """A surrogate cannot be fitted to the points it was given."""


class SimulationError(RailsearchError):
    """A simulation diverged or could not be carried out; the evaluation counts as failed."""


@contextmanager
def located(where: str) -> Iterator[None]:
    """Have an error that a user can mend say where it is: of the same class, `where: ` before its text."""
    try:
        yield
    except RailsearchError as error:
        raise type(error)(f"{where}: {error}") from None
