"""What storing one evaluation takes: straight into the tables, and through Optuna's `add_trial`, side by side.

    python benchmarks/campaign_storing.py [--evaluations 1000] [--storage URL]

The two take turns in blocks, on the same storage and machine; CPU time of this process per evaluation. Late
blocks show whether it grows with the length of the study.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from railsearch.interfaces import Evaluation
from railsearch.space import Space, Variable
from railsearch.storage import Storage, StudyDescription, storage_url
from railsearch.storage import study as study_module

BLOCK = 100


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--evaluations", type=int, default=1000)
    arguments.add_argument("--variables", type=int, default=10)
    arguments.add_argument("--storage", metavar="URL", help="default: an SQLite file")
    asked = arguments.parse_args()
    space = Space(tuple(Variable(f"x{k}", -5.0, 5.0) for k in range(asked.variables)))
    with tempfile.TemporaryDirectory() as folder:
        url = storage_url(asked.storage or f"sqlite:///{Path(folder) / 'study.db'}")
        fast = Storage(url).run(StudyDescription("c/p/fast/1", {}, ("f",), 0, ""), space)
        can_write, study_module.can_write = study_module.can_write, lambda engine: False
        slow = Storage(url).run(StudyDescription("c/p/slow/1", {}, ("f",), 0, ""), space)
        study_module.can_write = can_write
        generator = np.random.default_rng(0)
        print("evaluations  tables [ms]  add_trial [ms]  ratio")
        for first in range(0, asked.evaluations, BLOCK):
            block = [_evaluation(space, first + k, generator) for k in range(BLOCK)]
            times = [_milliseconds(record, block) for record in (fast, slow)]
            print(f"{first + BLOCK:11d}  {times[0]:11.2f}  {times[1]:14.2f}  {times[1] / times[0]:5.1f}")


def _milliseconds(record, block) -> float:
    start = time.process_time()
    for evaluation in block:
        record.append(evaluation)
    return 1e3 * (time.process_time() - start) / len(block)


def _evaluation(space: Space, number: int, generator: np.random.Generator) -> Evaluation:
    design = space.from_unit(generator.random(space.dimension))
    return Evaluation(number, design, generator.random(1), np.empty(0), {"f": 1.0}, "random", 0, "", 0.1, 0.01)


if __name__ == "__main__":
    main()
