"""Time to read a campaign from its storage, against Optuna's own reading of the same studies.

    python benchmarks/campaign_reading.py [--cells 1000] [--evaluations 200] [--optuna 10] [--repeats 5] [--storage URL]

A synthetic campaign of rastrigin (10 variables) is written into an SQLite file, or into an empty database at `--storage`.
Both readings are interleaved: `read_campaign` of all cells, and `study.get_trials` of some of them. The operating system
has the file in its cache.
"""

import argparse
import logging
import resource
import tempfile

import optuna
from measuring import both_seconds, seconds, spread, yardstick
from synthetic_campaign import synthetic_campaign, write_campaign

from railsearch.campaign.reading import read_campaign
from railsearch.plugin_manager import load_plugins


def by_optuna(storage: optuna.storages.BaseStorage, names: list[str]) -> None:
    for name in names:
        optuna.load_study(study_name=name, storage=storage).get_trials(deepcopy=False)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--cells", type=int, default=1000)
    arguments.add_argument("--evaluations", type=int, default=200)
    arguments.add_argument("--optuna", type=int, default=10, help="cells that Optuna reads in a repeat")
    arguments.add_argument("--repeats", type=int, default=5, help="interleaved repeats")
    arguments.add_argument("--storage", help="URL of an empty database; default: an SQLite file")
    asked = arguments.parse_args()
    optuna.logging.set_verbosity(logging.WARNING)
    with tempfile.TemporaryDirectory() as folder:
        url = asked.storage or f"sqlite:///{folder}/study.db"
        measure(url, asked)


def measure(url: str, asked: argparse.Namespace) -> None:
    campaign = synthetic_campaign(["rastrigin"], asked.cells, asked.evaluations)
    print(f"writing took {seconds(lambda: write_campaign(url, campaign)):.1f} s")
    registry = load_plugins()
    names = [cell.study_name(campaign.name) for cell in campaign.cells()]
    few = names[:: max(1, len(names) // asked.optuna)][: asked.optuna]
    total, part = (len(cells) * campaign.budget for cells in (names, few))
    ours, theirs, noise = [], [], []
    for _ in range(asked.repeats):
        noise.append(seconds(yardstick))
        ours.append(both_seconds(lambda: read_campaign(registry, url, campaign)))
        fresh = optuna.storages.get_storage(url)
        theirs.append(both_seconds(lambda storage=fresh: by_optuna(storage, few)))
    print(f"{asked.repeats} interleaved repeats; {len(names)} cells of {campaign.budget} evaluations, {len(few)} by Optuna")
    for index, kind in enumerate(("elapsed", "processor")):
        fast, slow = [times[index] / total for times in ours], [times[index] / part for times in theirs]
        print(f"{kind} time: read_campaign, µs per evaluation: {spread([1e6 * value for value in fast])}")
        print(f"{kind} time: read_campaign, s for all {total}: {spread([total * value for value in fast])}")
        print(f"{kind} time: get_trials, µs per trial: {spread([1e6 * value for value in slow])}")
        print(f"{kind} time: ratio: {spread([s / f for s, f in zip(slow, fast, strict=True)])}")
    print(f"noise of the machine, s for fixed arithmetic: {spread(noise)}")
    print(f"memory at the peak, MB: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f}")


if __name__ == "__main__":
    main()
