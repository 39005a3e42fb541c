"""What all clients share: `python LIBRARY_client.py MODEL data.npz answer.npz` fits one model and says how long it took.

| file | field | shape | meaning |
|---|---|---|---|
| data.npz | points, values | (n, d), (n,) | what to fit to |
| | fresh | (m, d) | where to predict |
| | families, means, deviations | (d,) | the inputs: `lognormal` or `gumbel-max`, mean, standard deviation |
| answer.npz | predicted | (m,) | at the fresh points |
| | fit, prediction | (2,) | elapsed and processor seconds |
| | versions, note | JSON text | {distribution: version}; what the library chose |

A model is a function of the data that returns the fitted prediction and a note. It runs in the environment of its library:
this module needs numpy and the standard library only. Imports are not timed.
"""

import importlib.metadata
import json
import sys
import time

import numpy as np


class Data:
    """The fields of data.npz that a model may see."""

    def __init__(self, path):
        with np.load(path) as stored:
            self.points, self.values, self.fresh = stored["points"], stored["values"], stored["fresh"]
            self.families = stored["families"].tolist()
            self.means, self.deviations = stored["means"].tolist(), stored["deviations"].tolist()

    @property
    def inputs(self):
        """Family, mean and standard deviation of every input."""
        return list(zip(self.families, self.means, self.deviations, strict=True))


def serve(models, distributions):
    """Fit the model that the command line names to its data, and write the answer."""
    name, source, target = sys.argv[1:]
    data = Data(source)
    (predict, note), fit = timed(lambda: models[name](data))
    predicted, prediction = timed(lambda: predict(data.fresh))
    versions = {distribution: importlib.metadata.version(distribution) for distribution in distributions}
    answer = {"predicted": np.ravel(predicted), "fit": fit, "prediction": prediction}
    np.savez(target, **answer, versions=json.dumps(versions), note=json.dumps(note))


def timed(work):
    """What a piece of work returns, and its elapsed and processor seconds."""
    elapsed, processor = time.perf_counter(), time.process_time()
    found = work()
    return found, (time.perf_counter() - elapsed, time.process_time() - processor)
