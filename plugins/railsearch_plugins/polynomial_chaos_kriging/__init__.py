"""PC-Kriging: the terms of a sparse polynomial chaos expansion as the trend of a Gaussian process."""
