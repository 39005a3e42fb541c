"""The cells of the study: a surrogate of one design, its error, and the importances found on it; kept one by one."""

import json
import time

import numpy as np

from railsearch.run_directory import write_whole
from railsearch.sampling import latin_hypercube
from railsearch.sensitivity import FRUGAL, ExactModel, extreme_surfaces
from railsearch.sensitivity.fitting import surrogate_fit

FRESH = 10_000
EXACT_SEED, FRESH_SEED, DESIGN_SEED, SEARCH_SEED = range(4)


class Cells:
    """Results by key in a file, computed where they are not there yet."""

    def __init__(self, file):
        self.file = file
        self.found = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}

    def get(self, key, compute):
        """The result of that key."""
        if key not in self.found:
            print(key, flush=True)
            self.found[key] = compute()
            write_whole(self.file, json.dumps(self.found).encode())
        return self.found[key]


def exact_result(case, factors, seed):
    """Importances and curves from the true model, and how often it was asked."""
    surfaces = extreme_surfaces(
        ExactModel(case.function, factors.space), factors, _generator(seed, EXACT_SEED), FRUGAL, senses=case.senses
    )
    plain = {sense: surfaces.importances(sense, weighted=False) for sense in case.senses}
    return _result(surfaces, case) | {"evaluations": surfaces.effort.asked, "unweighted": plain}


def surrogate_result(registry, case, name, size, design, seed):
    """Importances and curves on a surrogate of a Latin hypercube, its error on fresh points, and times in seconds."""
    points = latin_hypercube(case.inputs, size, _generator(seed, DESIGN_SEED, size, design))
    fit = surrogate_fit(registry, name, {}, case.inputs)
    begin = time.process_time()
    model = fit(points, case.function(points))
    fitted = time.process_time()
    surfaces = extreme_surfaces(model, case.factors(), _generator(seed, SEARCH_SEED, size, design), senses=case.senses)
    times = {"fit_seconds": fitted - begin, "search_seconds": time.process_time() - fitted}
    fresh = case.inputs.from_uniform(_generator(seed, FRESH_SEED).random((FRESH, case.inputs.dimension)))
    true = case.function(fresh)
    error = float(np.mean((model.predict(fresh) - true) ** 2) / np.var(true))
    return _result(surfaces, case) | times | {"generalisation": error, "held": surfaces.effort.check.held}


def _result(surfaces, case):
    return {
        "importances": {sense: surfaces.importances(sense) for sense in case.senses},
        "curves": {
            sense: {name: surfaces.surface(name, sense).values.tolist() for name in surfaces.factors.names}
            for sense in case.senses
        },
    }


def _generator(*seeds):
    return np.random.default_rng(seeds)
