"""The peer's side of the conversation: `python serve.py MODULE` serves searches by one client module, one after another.

JSON objects, one a line, each answered before the next. We write to standard output, railsearch to standard input:

| who | line | meaning |
|---|---|---|
| client | {"ready": {distribution: version}} | a search may begin |
| railsearch | {"algorithm", "seed", "budget", "lower", "upper", "integer", "points", "values"} | begin; the start is known |
| client | {"evaluate": [x_1, …, x_d]} | a question |
| railsearch | {"value": f} | the answer |
| railsearch | {"stop": true} | instead of an answer: the search is over |
| client | {"ended": reason} | instead of a question: the peer ended by itself, it failed or it died |

A client module imports its peer, the standard library and numpy, and has `DISTRIBUTIONS`, the names whose versions are told,
and `ALGORITHMS`, functions of a `Run` that ask `run.evaluate(x)` for as long as they are answered: nobody counts here.
The peer is imported once; each search is a fork of that process, so that none leaves anything behind for the next. What the
peer imports no sooner than in a search may stand in `PRELOADED`: it is imported once then, too.
"""

import contextlib
import importlib
import importlib.metadata
import json
import os
import sys
from types import ModuleType
from typing import Any, TextIO

import numpy as np

SAME = 1e-9
"""A question as near as this to a point of the start, as a part of each range, is that point after a change of units."""


class Stopped(BaseException):
    """The search is over; like the end of the interpreter it passes through a peer that catches exceptions."""


class Run:
    """One search: the box, the start and `evaluate`; everything in the units of the problem.

    lower, upper (d,), integer (d,): the box and which variables take whole numbers only; points (n, d) and values (n,): the
    start, known before the first question; budget: evaluations in all, those of the start included.
    """

    def __init__(self, begin: dict[str, Any], answers: TextIO, questions: TextIO) -> None:
        self.algorithm: str = begin["algorithm"]
        self.seed: int = begin["seed"]
        self.budget: int = begin["budget"]
        self.lower = np.array(begin["lower"], dtype=float)
        self.upper = np.array(begin["upper"], dtype=float)
        self.integer = np.array(begin["integer"], dtype=bool)
        self.points = np.array(begin["points"], dtype=float)
        self.values = np.array(begin["values"], dtype=float)
        self._answers = answers
        self._questions = questions

    @property
    def dimension(self) -> int:
        """How many variables there are."""
        return self.lower.size

    @property
    def best_point(self) -> np.ndarray:
        """The best point (d,) of the start."""
        return self.points[np.argmin(self.values)]

    def evaluate(self, x: Any) -> float:
        """The value at x (d,); what the start has is known and not asked for."""
        point = np.asarray(x, dtype=float).ravel()
        gaps = np.max(np.abs(self.points - point) / (self.upper - self.lower), axis=1)
        if gaps.min() <= SAME:
            return float(self.values[np.argmin(gaps)])
        tell(self._questions, {"evaluate": point.tolist()})
        return float(heard(self._answers)["value"])


def tell(channel: TextIO, message: dict[str, Any]) -> None:
    """Write one line."""
    channel.write(json.dumps(message) + "\n")
    channel.flush()


def heard(channel: TextIO) -> dict[str, Any]:
    """Read one line. Raises Stopped at the end of the search and of the conversation."""
    line = channel.readline()
    message: dict[str, Any] = json.loads(line) if line else {"stop": True}
    if "stop" in message:
        raise Stopped
    return message


def own_output() -> TextIO:
    """Standard output for the conversation alone: what a peer prints goes to standard error."""
    channel = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return channel


def searched(client: ModuleType, begin: dict[str, Any], questions: TextIO) -> str:
    """Carry out one search; why it ended before it was stopped."""
    try:
        client.ALGORITHMS[begin["algorithm"]](Run(begin, sys.stdin, questions))
    except Exception as error:  # noqa: BLE001 - whatever a peer raises is the reason why it ended
        return f"{type(error).__name__}: {error}"
    return "it stopped by itself"


def forked(client: ModuleType, begin: dict[str, Any], questions: TextIO) -> None:
    """Carry out one search in a fork of this process, and tell if that died."""
    child = os.fork()
    if child == 0:
        with contextlib.suppress(Stopped):
            tell(questions, {"ended": searched(client, begin, questions)})
        os._exit(0)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code:
        tell(questions, {"ended": f"it died (exit code {code})"})


def main(name: str) -> None:
    """Serve searches by the client module of that name."""
    questions = own_output()
    try:
        client = importlib.import_module(name)
        for needed in getattr(client, "PRELOADED", ()):
            importlib.import_module(needed)
        versions = {each: importlib.metadata.version(each) for each in client.DISTRIBUTIONS}
    except Exception as error:  # noqa: BLE001 - whatever an import raises is the reason why there is no search
        tell(questions, {"ended": f"{type(error).__name__}: {error}"})
        return
    with contextlib.suppress(Stopped):
        while True:
            tell(questions, {"ready": versions})
            forked(client, heard(sys.stdin), questions)


if __name__ == "__main__":
    main(sys.argv[1])
