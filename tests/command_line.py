"""What a command line answers."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Answer:
    """What a command printed, and its exit code."""

    code: int
    out: str
    err: str


def refused(answer: Answer, *words: str) -> None:
    """Check that a command told a user these words about an input it did not take, and nothing else."""
    assert answer.code == 2, answer
    assert all(word in answer.err for word in words), answer.err
    assert "Traceback" not in answer.err
    assert answer.out == ""
