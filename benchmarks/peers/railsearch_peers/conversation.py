"""Our side of the conversation with a peer's process; the lines are described in clients/serve.py."""

import functools
import json
import os
import select
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from railsearch.errors import PluginError

PEERS = Path(__file__).resolve().parent.parent
CLIENTS = PEERS / "clients"
ENVIRONMENTS = PEERS / ".environments"
READ_SIZE = 65536
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class PeerEnded(Exception):
    """The peer asks no more; the text says why."""


class Conversation:
    """A running process that serves searches."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self._received = b""

    def send(self, message: Mapping[str, Any]) -> None:
        """Send one line. Raises PeerEnded if there is nobody to receive it."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(message).encode() + b"\n")
            self._process.stdin.flush()
        except OSError:
            raise PeerEnded(self._death()) from None

    def receive(self, patience: float) -> dict[str, Any]:
        """Receive one line. Raises PeerEnded if the peer says so, is silent for `patience` seconds, or has died."""
        until = time.monotonic() + patience
        while b"\n" not in self._received:
            if not select.select([self._output], [], [], max(until - time.monotonic(), 0.0))[0]:
                raise PeerEnded(f"it was silent for {patience:g} s")
            self._received += self._read()
        line, self._received = self._received.split(b"\n", 1)
        message: dict[str, Any] = json.loads(line)
        if "ended" in message:
            raise PeerEnded(message["ended"])
        return message

    def end(self) -> None:
        """Kill the process and its children."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()

    @property
    def _output(self) -> int:
        assert self._process.stdout is not None
        return self._process.stdout.fileno()

    def _read(self) -> bytes:
        received = os.read(self._output, READ_SIZE)
        if not received:
            raise PeerEnded(self._death())
        return received

    def _death(self) -> str:
        return f"it died (exit code {self._process.wait()})"


def peer_command(peer: str) -> list[str]:
    """The command that serves a peer. Raises PluginError if its environment has not been built."""
    python = ENVIRONMENTS / peer / "bin" / "python"
    if not python.exists():
        built = f"python {PEERS.parent}/environments.py peers build {peer}"
        raise PluginError(f"peer {peer}: there is no {python}; build it by `{built}`")
    return [str(python), str(CLIENTS / "serve.py"), f"{peer}_client"]


def started(command: Sequence[str]) -> Conversation:
    """Start a process that serves searches.

    It has a session of its own, so that Ctrl-C reaches railsearch alone, and calculates with one thread.
    """
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **ONE_THREAD, "PYTHONHASHSEED": "0"},
        start_new_session=True,
    )
    return Conversation(process)


@functools.cache
def idle(peer: str) -> list[Conversation]:
    """The processes of a peer that wait for their next search."""
    return []
