"""Metric stochastic response surface search: the common ground of `dycors` and `lmsrs`."""
