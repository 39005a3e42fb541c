"""Sparse polynomial chaos: expansions in polynomials that are orthonormal for the distribution of the inputs."""
