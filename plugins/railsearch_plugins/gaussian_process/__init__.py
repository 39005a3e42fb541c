"""Gaussian process regression with a trend (universal Kriging): the common ground of the surrogates built on it."""
