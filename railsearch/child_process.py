"""A process of our own at the other end of a pipe."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any


@dataclass(frozen=True)
class ChildProcess:
    """A running process and our end of the pipe to it."""

    process: BaseProcess
    connection: Connection

    def end(self) -> None:
        """Kill the process and close the pipe."""
        self.process.kill()
        self.process.join()
        self.connection.close()


def start_child(serve: Callable[..., None], arguments: Sequence[Any], daemon: bool) -> ChildProcess:
    """Start `serve(connection, *arguments)` in a process of its own.

    daemon: whether it may have no processes of its own. Raises what pickling raises for arguments that cannot travel.
    """
    multiprocessing.current_process().daemon = False  # a daemonic worker process may otherwise have no children
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=serve, args=(theirs, *arguments), daemon=daemon)
    process.start()
    theirs.close()
    return ChildProcess(process, ours)


def live_with_parent() -> None:
    """Called in a child: leave Ctrl-C to the parent, and end when it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
