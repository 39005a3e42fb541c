"""chaospy: sparse polynomial chaos, the regression by scikit-learn's least-angle Lasso, as its documentation shows."""

import chaospy
import numpy as np
from fitting import serve
from scipy.stats import norm
from sklearn.linear_model import LassoLarsCV

NORM = 0.5
DEGREES = (2, 4, 5, 7, 9)
"""Where hyperbolic sets of this norm grow by more than single powers; 9 brings the interactions of three inputs."""

CANDIDATES_PER_POINT = 2
STEPS = 2000


def polynomial_chaos(data):
    """The expansion of the degree with the least cross-validated error."""
    joint = chaospy.J(*[chaospy.Normal() for _ in data.families])
    points = standard_normal(data, data.points)
    found = {degree: trial(joint, degree, points, data.values) for degree in DEGREES}
    errors = {degree: error for degree, (_, error) in found.items()}
    degree = min(errors, key=errors.get)
    expansion = found[degree][0]
    return lambda fresh: expansion(*standard_normal(data, fresh)), {"degree": degree, "terms": len(expansion.exponents)}


def trial(joint, degree, points, values):
    """The expansion of a degree and its cross-validated error; infinite if there are too many candidates."""
    candidates = chaospy.generate_expansion(degree, joint, cross_truncation=NORM, normed=True)
    if len(candidates) > CANDIDATES_PER_POINT * len(values):
        return None, np.inf
    regression = LassoLarsCV(fit_intercept=False, max_iter=STEPS)
    expansion = chaospy.fit_regression(candidates, points, values, model=regression)
    return expansion, regression.mse_path_.mean(axis=1).min()


def standard_normal(data, points):
    """ξ = Φ⁻¹(F(x)) (d, n)."""
    columns = zip(data.families, data.means, data.deviations, points.T, strict=True)
    return np.array([{"lognormal": of_lognormal, "gumbel-max": of_gumbel}[family](*rest) for family, *rest in columns])


def of_lognormal(mean, deviation, x):
    """The logarithm, standardised."""
    variance = np.log1p((deviation / mean) ** 2)
    return (np.log(x / mean) + variance / 2.0) / np.sqrt(variance)


def of_gumbel(mean, deviation, x):
    """Φ⁻¹ of exp(−exp(−z)); from the upper tail where that is the smaller one."""
    scale = np.sqrt(6.0) / np.pi * deviation
    hazard = np.exp(-(x - mean) / scale - np.euler_gamma)
    return np.where(hazard < 1.0, norm.isf(-np.expm1(-hazard)), norm.ppf(np.exp(-hazard)))


if __name__ == "__main__":
    serve({"lars-hermite": polynomial_chaos}, ("chaospy", "scikit-learn", "numpy", "scipy"))
