"""Errors that are gathered, so that all of them are told at once."""

from collections.abc import Iterator
from contextlib import contextmanager

from railsearch.errors import InputError, RailsearchError


class Faults:
    """The faults found so far, in words."""

    def __init__(self) -> None:
        self.messages: list[str] = []

    def add(self, message: str) -> None:
        """Note one fault."""
        self.messages.append(message)

    @contextmanager
    def gathered(self, where: str = "") -> Iterator[None]:
        """Note an error that a user can mend instead of raising it; what follows it inside is left out."""
        try:
            yield
        except RailsearchError as error:
            self.add(f"{where}: {error}" if where else str(error))

    def raise_all(self, where: str) -> None:
        """Raise InputError with every fault, if there are any."""
        if len(self.messages) == 1:
            raise InputError(f"{where}: {self.messages[0]}")
        if self.messages:
            raise InputError("\n- ".join((f"{where} has {len(self.messages)} faults:", *self.messages)))
