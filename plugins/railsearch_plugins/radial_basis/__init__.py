"""Radial basis functions: kernels, and which points determine a polynomial tail."""
