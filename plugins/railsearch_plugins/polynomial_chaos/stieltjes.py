"""Recurrence coefficients of the polynomials that are orthonormal for any distribution: the discretised Stieltjes procedure.

| symbol | meaning | shape | source |
|---|---|---|---|
| ξ | standard normal value with Φ(ξ) = F(x) | | |
| t_i, w_i | nodes and weights with Σ w_i f(t_i) ≈ E[f] | (n,) | |
| ψ_k, a_k, b_k | as in families.py: a_k = E[t ψ_k²], b_{k+1} = ‖(t − a_k) ψ_k − √b_k ψ_{k−1}‖² | | Gautschi 2004, 2.2.3.1 |

Expectations are integrals over ξ with the normal density, in which x(ξ) is smooth whatever the tail of the distribution.
Panels of Gauss and Legendre's rule are halved where x(ξ) is not resolved, as at the kink of a triangular distribution.
"""

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

from railsearch.distributions import Marginal
from railsearch.errors import InputError
from railsearch.space import FloatArray

NODES = 24
"""Nodes of a panel."""

PANELS = np.linspace(-30.0, 30.0, 121)
"""Ends of the first panels; beyond, the probability is below 1e-196."""

OUTER = 25.0
"""Values of ξ further out must not take part in a moment; percentiles that scipy cannot find there are left out."""

HALVINGS = 45
"""A panel is halved so many times at most."""

RESOLVED = 1e-13
"""The last coefficients of x(ξ) on a panel, times the root of its probability, as fractions of the standard deviation."""

NEGLIGIBLE = 1e-13
"""Share of a squared polynomial that may come from the outer values of ξ."""


def nodes_and_weights(marginal: Marginal) -> tuple[FloatArray, FloatArray]:
    """x_i (n,) and w_i (n,) with Σ w_i f(x_i) = E[f(X)] for polynomials f of moderate degree, by growing ξ."""
    unit, weights = leggauss(NODES)
    last = np.linalg.pinv(legvander(unit, NODES - 1))[-3:]
    low, high, done = PANELS[:-1], PANELS[1:], []
    for halving in range(HALVINGS + 1):
        half = 0.5 * (high - low)[:, None]
        xi = 0.5 * (low + high)[:, None] + half * unit
        x = marginal.from_standard_normal(xi)
        x = np.where(np.isfinite(x) | (np.abs(xi) < OUTER), x, marginal.mean)
        w = half * weights * np.exp(-0.5 * xi**2) / np.sqrt(2.0 * np.pi)
        rough = np.abs(x @ last.T).max(axis=1) * np.sqrt(w.sum(axis=1)) > RESOLVED * marginal.std
        kept = ~rough | (halving == HALVINGS)
        done.append(np.stack([xi[kept].ravel(), x[kept].ravel(), w[kept].ravel()]))
        middle = 0.5 * (low + high)[~kept]
        low, high = np.concatenate([low[~kept], middle]), np.concatenate([middle, high[~kept]])
        if not len(low):
            break
    joined = np.concatenate(done, axis=1)
    joined = joined[:, np.argsort(joined[0])]
    return joined[1], joined[2] / joined[2].sum()


def stieltjes(nodes: FloatArray, weights: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """a_0 … a_p (p + 1,) and b_0 … b_{p+1} (p + 2,), b_0 = 0, of the discrete measure at nodes by growing ξ.

    Raises InputError if moments of that degree come from the far tails, where nothing is known.
    Source: Gautschi 2004, Orthogonal Polynomials: Computation and Approximation, section 2.2.3.
    """
    a, b = np.zeros(degree + 1), np.zeros(degree + 2)
    before, current = np.zeros_like(nodes), np.ones_like(nodes)
    for k in range(degree + 1):
        a[k] = np.sum(weights * nodes * current**2)
        following = (nodes - a[k]) * current - np.sqrt(b[k]) * before
        shares = weights * following**2
        b[k + 1] = np.sum(shares)
        _check_tails(shares, weights, k + 1)
        before, current = current, following / np.sqrt(b[k + 1])
    return a, b


def _check_tails(shares: FloatArray, weights: FloatArray, degree: int) -> None:
    """That no more than rounding comes from nodes whose probability is that of the outer values of ξ."""
    outer = weights < np.exp(-0.5 * OUTER**2)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = float(np.sum(shares[outer]) / np.sum(shares))
    if not share < NEGLIGIBLE:
        raise InputError(
            f"basis: the moments of order {2 * degree} of a distribution with such tails come from values that never occur, "
            f"so it has no polynomials of its own of degree {degree}; lower the degree or choose the basis 'hermite'"
        )
