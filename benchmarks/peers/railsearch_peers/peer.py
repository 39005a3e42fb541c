"""Strategy `peer`: a public optimiser in a process and an environment of its own.

Evaluation, counting, rounding of the integers and time are railsearch's, as for every strategy: the peer asks for values
and gets them. The time between an answer and its next question is its overhead. A peer that ends before the budget is
spent, by itself, by an error or by silence, is not lost: random designs use the rest, each with the reason in its origin, so
that they can be told from what the peer found.
"""

import weakref
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from railsearch.errors import PluginError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Evaluation, Proposal, SearchContext, parameter
from railsearch.sampling import random_designs
from railsearch.space import FloatArray
from railsearch_peers.conversation import Conversation, PeerEnded, idle, peer_command, started
from railsearch_peers.shared_start import SharedStart

ENDED = "peer ended: "
"""What the origin of a design begins with that the peer did not ask for."""


@dataclass(frozen=True)
class PeerParameters:
    """Which peer, and how long it may take."""

    peer: str = parameter("pysot", meaning="name of the peer's environment and client")
    version: str = parameter("", meaning="version of the peer's first distribution; any other is refused")
    algorithm: str = parameter("dycors", meaning="one of the algorithms of the client")
    patience: float = parameter(600.0, meaning="silence after which the peer counts as hung", unit="s", above=0.0)


class PeerSearch:
    """Hands questions and answers on between a run and a peer's process."""

    def __init__(self, context: SearchContext, parameters: PeerParameters) -> None:
        self._context = context
        self._parameters = parameters
        self._known: dict[bytes, Evaluation] = {}
        self._worst = 0.0
        self._conversation: Conversation | None = None
        self._abandoned: weakref.finalize | None = None
        self._asked: FloatArray | None = None
        self._reason = ""

    def prepare(self) -> None:
        """Have the peer's process ready. Raises PluginError if it is not there or has another version."""
        if self._conversation is not None or self._reason:
            return
        waiting = idle(self._parameters.peer)
        self._conversation = waiting.pop() if waiting else started(peer_command(self._parameters.peer))
        self._abandoned = weakref.finalize(self, self._conversation.end)
        try:
            self._check(self._conversation.receive(self._parameters.patience)["ready"])
        except PeerEnded as ended:
            self._end(ended)

    def ask(self) -> Sequence[Proposal]:
        """What the peer asks for next, origin `peer`; once it has ended, a random design with the reason as its origin."""
        if not self._reason:
            try:
                self._asked = self._question()
                return [Proposal(self._asked, "peer")]
            except PeerEnded as ended:
                self._end(ended)
        return [Proposal(random_designs(self._context.space, 1, self._context.generator)[0], ENDED + self._reason)]

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Keep the values for the peer's next question; where there will be none, let its process wait for another run."""
        space = self._context.space
        for evaluation in evaluations:
            self._known[space.key(evaluation.design)] = evaluation
        values = [float(known.objectives[0]) for known in self._known.values() if not known.failed]
        self._worst = max(values, default=0.0)
        if len(self._known) >= min(self._context.budget, space.size):
            self._release()

    def _question(self) -> FloatArray:
        """Answer the last question, or begin; the design (d,) of the next one."""
        assert self._conversation is not None
        self._conversation.send(self._beginning() if self._asked is None else {"value": self._value(self._asked)})
        asked = self._conversation.receive(self._parameters.patience)["evaluate"]
        x = np.array(asked, dtype=float)
        if x.shape != (self._context.space.dimension,) or not np.all(np.isfinite(x)):
            raise PeerEnded(f"it asked for the value at {asked}")
        return self._context.space.rounded(x)

    def _beginning(self) -> dict[str, object]:
        space = self._context.space
        return {
            "algorithm": self._parameters.algorithm,
            "seed": int(self._context.generator.integers(2**31)),
            "budget": self._context.budget,
            "lower": space.lower.tolist(),
            "upper": space.upper.tolist(),
            "integer": space.integer.tolist(),
            "points": [evaluation.design.tolist() for evaluation in self._known.values()],
            "values": [self._value(evaluation.design) for evaluation in self._known.values()],
        }

    def _value(self, design: FloatArray) -> float:
        """The value of an evaluated design; a failed one is as bad as the worst so far."""
        evaluation = self._known[self._context.space.key(design)]
        return self._worst if evaluation.failed else float(evaluation.objectives[0])

    def _check(self, versions: dict[str, str]) -> None:
        wanted = self._parameters.version
        distribution, version = next(iter(versions.items()))
        if version != wanted:
            raise PluginError(
                f"peer {self._parameters.peer}: {distribution} {wanted or '(no version)'} is asked for, its environment has "
                f'{version}; build the environment again, or give version = "{version}" in a campaign of its own'
            )

    def _release(self) -> None:
        """Stop the search in the peer's process, which waits for another run."""
        conversation, self._conversation = self._conversation, None
        if conversation is None or self._abandoned is None:
            return
        self._abandoned.detach()
        try:
            conversation.send({"stop": True})
            idle(self._parameters.peer).append(conversation)
        except PeerEnded:
            conversation.end()

    def _end(self, ended: PeerEnded) -> None:
        self._reason = str(ended)
        if self._conversation is not None:
            self._conversation.end()
            self._conversation = None


class Peer(SharedStart):
    """A public optimiser behind the shared start."""

    Parameters = PeerParameters

    def __init__(self, context: SearchContext, parameters: PeerParameters) -> None:
        self._peer = PeerSearch(context, parameters)
        super().__init__(context, self._peer)

    def ask(self) -> Sequence[Proposal]:
        """The start, then what the peer asks for; its process is made ready before the first design, in nobody's time."""
        self._peer.prepare()
        return super().ask()


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `peer`."""
    register("peer", Peer)
