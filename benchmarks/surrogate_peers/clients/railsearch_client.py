"""railsearch: `pce`, `kriging` and `pck` on random inputs, with the settings of a sensitivity analysis."""

from fitting import serve

from railsearch.distributions import random_vector
from railsearch_plugins.gaussian_process.estimator import KrigingRegressor
from railsearch_plugins.polynomial_chaos.estimator import PolynomialChaosRegressor
from railsearch_plugins.polynomial_chaos_kriging.estimator import PolynomialChaosKrigingRegressor


def random_inputs(data):
    """The vector of the inputs, named by number."""
    marginals = [{"distribution": family, "mean": mean, "std": std} for family, mean, std in data.inputs]
    return random_vector({f"x{k}": marginal for k, marginal in enumerate(marginals)})


def fitted(model, data):
    """The prediction of a fitted regressor, and how many terms it has."""
    model.set_params(inputs=random_inputs(data)).fit(data.points, data.values)
    expansion = getattr(model, "expansion_", None)
    return model.predict, {} if expansion is None else {"terms": len(expansion.coefficients)}


MODELS = {
    "pce": lambda data: fitted(PolynomialChaosRegressor(), data),
    "pce-hermite": lambda data: fitted(PolynomialChaosRegressor(basis="hermite"), data),
    "kriging": lambda data: fitted(KrigingRegressor(), data),
    "kriging-gaussian": lambda data: fitted(KrigingRegressor(correlation="gaussian"), data),
    "pck": lambda data: fitted(PolynomialChaosKrigingRegressor(), data),
}

if __name__ == "__main__":
    serve(MODELS, ("railsearch", "numpy", "scipy"))
