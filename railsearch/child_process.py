"""A process of our own at the other end of a pipe."""

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

import numpy as np


@dataclass(frozen=True)
class ChildProcess:
    """A running process and our end of the pipe to it."""

    process: BaseProcess
    connection: Connection

    def receive(self) -> Any:
        """The next answer of an `AnsweringEnd`; what was warned of meanwhile there is shown here.

        Raises EOFError, OSError when the process is gone.
        """
        answer, warned = self.connection.recv()
        for text in warned:
            warnings.showwarning(UserWarning(text), UserWarning, self.process.name, 0)
        return answer

    def end(self) -> None:
        """Kill the process and close the pipe."""
        self.process.kill()
        self.process.join()
        self.connection.close()


class AnsweringEnd:
    """The child's end of the pipe. From now on warnings go with the answers in place of to standard error.

    Ctrl-C is left to the parent, and the child ends when its parent does. NumPy's own generator, from which a model might
    draw, is seeded anew: of one server all processes would draw the same.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._warned: list[str] = []
        warnings.showwarning = lambda message, *details, **more: self._warned.append(str(message))
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        np.random.seed()  # noqa: NPY002 - it is the one that is meant
        threading.Thread(target=_end_with_parent, daemon=True).start()

    def receive(self) -> Any:
        """What the parent sends. Raises EOFError when it has closed the pipe."""
        return self._connection.recv()

    def answer(self, answer: Any) -> None:
        """Send an answer."""
        warned, self._warned = self._warned, []
        self._connection.send((answer, warned))


def start_child(serve: Callable[..., None], arguments: Sequence[Any], daemon: bool) -> ChildProcess:
    """Start `serve(connection, *arguments)` in a process of its own.

    daemon: whether it may have no processes of its own. The module of the first `serve` is what all processes have loaded.
    Raises what pickling raises for arguments that cannot travel.
    """
    multiprocessing.current_process().daemon = False  # a daemonic worker process may otherwise have no children
    # Where libraries bear it, a server loads once what a process needs, and forks it in no time.
    context = multiprocessing.get_context("forkserver") if sys.platform == "linux" else multiprocessing.get_context("spawn")
    multiprocessing.set_forkserver_preload([serve.__module__])
    ours, theirs = context.Pipe()
    process = context.Process(target=serve, args=(theirs, *arguments), daemon=daemon)
    process.start()
    theirs.close()
    return ChildProcess(process, ours)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
