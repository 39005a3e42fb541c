"""scipy: differential evolution, its first population the start, its generations without end."""

from scipy.optimize import differential_evolution
from serve import Run

DISTRIBUTIONS = ("scipy", "numpy")
ENDLESS = 1_000_000


def evolution(run: Run) -> None:
    """best1bin with scipy's defaults; no final polish, no tolerance that would end it."""
    differential_evolution(
        run.evaluate,
        bounds=list(zip(run.lower, run.upper, strict=True)),
        init=run.points,
        integrality=run.integer,
        maxiter=ENDLESS,
        tol=0.0,
        polish=False,
        rng=run.seed,
    )


ALGORITHMS = {"differential-evolution": evolution}
