"""Time per simulation of the level-crossing model against its scipy.sparse twin that refactorises at every step.

    python benchmarks/level_crossing_speed.py [--repeats 7] [--steps 400] [--full]

Both simulate the reference crossing (134 m, 3445 steps) on one core, interleaved. The twin's matrices are assembled
once, outside the timing; per step only the contact changes, and SuperLU gets the fastest of its orderings. Of its steps
`--steps` are timed and scaled to the run, or with `--full` all of them. The fast model is timed whole: checks, layout,
assembly, factorisation, passage and measures, compiled beforehand.
"""

import argparse
import os
import sys
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "track_models"))

import refactorising_twin  # noqa: E402
from measuring import seconds, spread, yardstick  # noqa: E402

from railsearch_plugins.track_models.level_crossing import LevelCrossing, LevelCrossingParameters  # noqa: E402

RUN = 3445


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--repeats", type=int, default=7, help="interleaved repeats")
    arguments.add_argument("--steps", type=int, default=400, help="steps of the twin that are timed and scaled")
    arguments.add_argument("--full", action="store_true", help="time all steps of the twin")
    options = arguments.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

    model, parameters = LevelCrossing(), LevelCrossingParameters()
    steps = RUN if options.full else options.steps
    system = refactorising_twin.couple(parameters)
    model.simulate(parameters)
    fast, twin, noise = [], [], []
    for _ in range(options.repeats):
        noise.append(seconds(yardstick))
        fast.append(min(seconds(lambda: model.simulate(parameters)) for _ in range(3)))
        twin.append(seconds(lambda: refactorising_twin.march(parameters, system, steps)) * RUN / steps)
    print(f"{options.repeats} interleaved repeats on one core; the twin timed over {steps} of {RUN} steps")
    print(f"fast model, s per simulation (best of 3 in a repeat): {spread(fast)}")
    print(f"refactorising twin, s per simulation: {spread(twin)}")
    print(f"ratio: {spread([slow / quick for slow, quick in zip(twin, fast, strict=True)])}")
    print(f"noise of the machine, s for fixed arithmetic: {spread(noise)}")


if __name__ == "__main__":
    main()
