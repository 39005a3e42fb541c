"""How a check of the suite fails."""


def require(condition: bool, explanation: str) -> None:
    """Raise an AssertionError with the explanation, also under `python -O`, unless the condition holds."""
    if not condition:
        raise AssertionError(explanation)
