"""Surrogates of expensive functions."""
