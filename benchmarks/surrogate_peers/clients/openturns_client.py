"""OpenTURNS: sparse polynomial chaos by least-angle regression, and Kriging."""

import numpy as np
import openturns as ot
from fitting import serve

NORM = 0.5
DEGREES = (2, 4, 5, 7, 9)
"""Where hyperbolic sets of this norm grow by more than single powers; 9 brings the interactions of three inputs."""

CANDIDATES_PER_POINT = 2
START, LONGEST = 10.0, 1e3
"""Length scales in standard deviations of an input. The library's own bounds, some 12, are too short for the truss."""

ASKED = 500


def marginal(family, mean, deviation):
    """A distribution by its mean and standard deviation."""
    by_moments = {"lognormal": ot.LogNormalMuSigma, "gumbel-max": ot.GumbelMuSigma}[family]
    return ot.ParametrizedDistribution(by_moments(mean, deviation))


def own_polynomials(family):
    """Orthonormal to the input itself, in its logarithm if lognormal."""
    return ot.StandardDistributionPolynomialFactory(ot.Gumbel()) if family == "gumbel-max" else ot.HermiteFactory()


def hermite_polynomials(family):
    """Whatever the input, which is mapped to the normal distribution then."""
    return ot.HermiteFactory()


def polynomial_chaos(data, polynomials):
    """The expansion of the degree with the least corrected leave-one-out error."""
    families = [polynomials(family) for family in data.families]
    basis = ot.OrthogonalProductPolynomialFactory(families, ot.HyperbolicAnisotropicEnumerateFunction(len(families), NORM))
    enumeration = basis.getEnumerateFunction()
    sizes = {degree: enumeration.getBasisSizeFromTotalDegree(degree) for degree in DEGREES}
    allowed = {k: size for k, size in sizes.items() if size <= CANDIDATES_PER_POINT * len(data.points)}
    results = {degree: expansion(data, ot.FixedStrategy(basis, size)) for degree, size in allowed.items()}
    degree = min(results, key=lambda k: min(results[k].getErrorHistory()))
    return results[degree].getMetaModel(), {"degree": degree, "terms": results[degree].getIndices().getSize()}


def expansion(data, strategy):
    """Terms by least-angle regression, as many as give the least corrected leave-one-out error; least squares."""
    joint = ot.JointDistribution([marginal(*described) for described in data.inputs])
    selection = ot.LeastSquaresMetaModelSelectionFactory(ot.LARS(), ot.CorrectedLeaveOneOut())
    values, projection = ot.Sample(data.values[:, None]), ot.LeastSquaresStrategy(selection)
    algorithm = ot.FunctionalChaosAlgorithm(ot.Sample(data.points), values, joint, strategy, projection)
    algorithm.run()
    return algorithm.getResult()


def kriging(data):
    """Matérn 5/2 by maximum likelihood with a constant trend, on standardised inputs and values."""
    centre, scale = data.points.mean(axis=0), data.points.std(axis=0)
    level, spread = data.values.mean(), data.values.std()
    dimension = data.points.shape[1]
    points = ot.Sample((data.points - centre) / scale)
    values = ot.Sample(((data.values - level) / spread)[:, None])
    trend, covariance = ot.ConstantBasisFactory(dimension).build(), ot.MaternModel([START] * dimension, 2.5)
    fitter = ot.GaussianProcessFitter(points, values, covariance, trend)
    fitter.setOptimizationBounds(ot.Interval([1.0 / START] * dimension, [LONGEST] * dimension))
    solver = ot.NLopt("LN_BOBYQA")
    solver.setMaximumCallsNumber(ASKED)
    fitter.setOptimizationAlgorithm(solver)
    fitter.run()
    regression = ot.GaussianProcessRegression(fitter.getResult())
    regression.run()
    process = regression.getResult().getMetaModel()
    return lambda fresh: level + spread * np.asarray(process((fresh - centre) / scale)), {}


MODELS = {
    "lars": lambda data: polynomial_chaos(data, own_polynomials),
    "lars-hermite": lambda data: polynomial_chaos(data, hermite_polynomials),
    "kriging": kriging,
}

if __name__ == "__main__":
    ot.TBB.Disable()
    serve(MODELS, ("openturns", "numpy"))
