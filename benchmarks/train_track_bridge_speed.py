"""Time per simulation of the train-track-bridge model against its plain twin that solves the coupled system anew.

    python benchmarks/train_track_bridge_speed.py [--repeats 5] [--steps 40] [--full]

Both simulate TTB-2D's case c02 (three vehicles, 140 km/h, 2918 unknowns, 4691 steps) on one core, interleaved. The twin
assembles and factorises with scipy.sparse at every step, as TTB-2D does; of its steps `--steps` are timed and scaled to
the run, or with `--full` all of them. The fast model is timed whole: checks, profile, layout, assembly, factorisation,
passage and measures, compiled beforehand.
"""

import argparse
import os
import sys
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "track_models"))

import coupled_twin  # noqa: E402
from bridges import case, file_profile  # noqa: E402
from measuring import both_seconds, spread, yardstick  # noqa: E402

from railsearch_plugins.track_models.train_track_bridge import TrainTrackBridge  # noqa: E402

RUN = 4691


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--repeats", type=int, default=5, help="interleaved repeats")
    arguments.add_argument("--steps", type=int, default=40, help="steps of the twin that are timed and scaled")
    arguments.add_argument("--full", action="store_true", help="time all steps of the twin")
    options = arguments.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

    model, parameters = TrainTrackBridge(), case("c02_irr").parameters
    steps = RUN if options.full else options.steps
    system = coupled_twin.build(parameters, parameters.ballast_mass, parameters.ballast_stiffness)
    model.simulate(parameters)
    fast, twin, noise = [], [], []
    for _ in range(options.repeats):
        noise.append(both_seconds(yardstick)[1])
        fast.append(min(both_seconds(lambda: model.simulate(parameters))[1] for _ in range(3)))
        twin.append(both_seconds(lambda: coupled_twin.march(parameters, system, file_profile, steps))[1] * RUN / steps)
    print(f"{options.repeats} interleaved repeats on one core, processor time; the twin over {steps} of {RUN} steps")
    print(f"fast model, s per simulation (best of 3 in a repeat): {spread(fast)}")
    print(f"coupled twin, s per simulation: {spread(twin)}")
    print(f"ratio: {spread([slow / quick for slow, quick in zip(twin, fast, strict=True)])}")
    print(f"noise of the machine, s for fixed arithmetic: {spread(noise)}")


if __name__ == "__main__":
    main()
