"""How far Kriging and PC-Kriging are off on the truss with Gumbel (maxima) loads, and how long they take.

python benchmarks/kriging.py [--sizes 100 400 1000] [--seeds 10] [--models kriging pck …]

Latin hypercubes of every size and seed, 10 000 fresh random points each, as in polynomial_chaos.py. Times are those of the
thread's processor. `scikit-learn` is its Gaussian process with a Matérn 5/2 kernel by variable, on standardised inputs.
"""

import argparse
import warnings
from functools import partial

import numpy as np
from measuring import spread, yardstick
from sklearn.compose import TransformedTargetRegressor
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from threadpoolctl import threadpool_limits
from truss_errors import measured, seconds, spread_of_errors, truss_inputs

from railsearch_plugins.gaussian_process.estimator import KrigingRegressor
from railsearch_plugins.polynomial_chaos_kriging.estimator import PolynomialChaosKrigingRegressor


def scikit_learn(inputs):
    """Its Gaussian process, and standardised values, because its kernels have a variance about one."""
    kernel = ConstantKernel(1.0, (1e-3, 1e9)) * Matern(np.full(inputs.dimension, 5.0), (1e-2, 1e5), nu=2.5)
    process = make_pipeline(StandardScaler(), GaussianProcessRegressor(kernel, random_state=0))
    return TransformedTargetRegressor(process, transformer=StandardScaler())


LEAVE_ONE_OUT = {"estimation": "leave-one-out"}
kriging = partial(KrigingRegressor, correlation="gaussian")
matern = partial(KrigingRegressor, correlation="matern-5/2")
pck = PolynomialChaosKrigingRegressor
MODELS = {
    "kriging": kriging,
    "kriging-loo": partial(kriging, **LEAVE_ONE_OUT),
    "kriging-matern": matern,
    "kriging-matern-loo": partial(matern, **LEAVE_ONE_OUT),
    "kriging-mapped": partial(kriging, basis="hermite"),
    "pck": pck,
    "pck-optimal": partial(pck, variant="optimal"),
    "pck-hyperbolic": partial(pck, growth=False),
    "pck-hyperbolic-optimal": partial(pck, growth=False, variant="optimal"),
    "pck-hyperbolic-ml": partial(pck, growth=False, estimation="maximum-likelihood"),
    "pck-hyperbolic-mapped": partial(pck, growth=False, basis="hermite"),
    "scikit-learn": scikit_learn,
}
HEADER = "   N  model                   ε_gen: median (range)                    ε_LOO     terms  seconds of a fit"


def main():
    """Print a line per size and model."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--sizes", nargs="+", type=int, default=(100, 400, 1000))
    arguments.add_argument("--seeds", type=int, default=10)
    arguments.add_argument("--models", nargs="+", default=tuple(MODELS), choices=tuple(MODELS))
    asked = arguments.parse_args()
    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        print(HEADER, flush=True)
        for size in asked.sizes:
            for name in asked.models:
                print(line(size, name, asked.seeds), flush=True)
        print(f"noise of the machine, s for fixed arithmetic: {spread([seconds(yardstick) for _ in range(5)])}")


def line(size, name, seeds):
    """Error, leave-one-out error, number of terms of the trend and time of one size and model."""
    rows = []
    for seed in range(seeds):
        inputs = truss_inputs()
        model = MODELS[name](inputs) if name == "scikit-learn" else MODELS[name](inputs=inputs)
        error, fit = measured(model, size, seed)
        rows.append((error, getattr(model, "loo_error", np.nan), len(getattr(model, "terms_", [0])), fit))
    errors, *others = np.array(rows).T
    loo, terms, fit = np.median(others, axis=1)
    return f"{size:4}  {name:22}  {spread_of_errors(errors):40} {loo:.2e}  {terms:5.0f}  {fit:.2f}"


if __name__ == "__main__":
    main()
