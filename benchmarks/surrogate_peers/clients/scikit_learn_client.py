"""scikit-learn: the Gaussian process of the benchmark kriging.py."""

import sys
from pathlib import Path
from types import SimpleNamespace

from fitting import serve

sys.path.append(str(Path(__file__).resolve().parents[2]))
from kriging import scikit_learn


def gaussian_process(data):
    """Matérn 5/2, a length scale for every input, standardised inputs and values."""
    model = scikit_learn(SimpleNamespace(dimension=data.points.shape[1])).fit(data.points, data.values)
    return model.predict, {}


if __name__ == "__main__":
    serve({"gp": gaussian_process}, ("scikit-learn", "numpy"))
