"""The published cases of the sensitivity near extremes: true models, surrogates of many designs, finer and finer grids.

    python -m examples.published_sensitivity --out published-sensitivity

After any stop the same command goes on from the last surrogate.
"""

import argparse
from pathlib import Path

from examples.published_sensitivity.cases import SURROGATES, published_cases
from examples.published_sensitivity.cells import Cells, exact_result, surrogate_result
from examples.published_sensitivity.figures import study_figures
from examples.published_sensitivity.record import make_record, study_tables
from examples.studies import write_pictures, write_record
from railsearch.plugin_manager import load_plugins
from railsearch.run_directory import write_whole

GRIDS = (10, 20, 30, 50, 75, 100, 150, 200)
SPACINGS = ("logarithmic", "equal")


def main():
    """Compute what is missing, then write study.json, tables.md and the figures."""
    asked, cases, registry = _arguments(), published_cases(), load_plugins()
    asked.out.mkdir(parents=True, exist_ok=True)
    cells = Cells(asked.out / f"cells-{asked.seed}.json")
    exact = {
        name: cells.get(f"{name} exact", lambda case=case: exact_result(case, case.factors(), asked.seed))
        for name, case in cases.items()
    }
    truss = cases["truss"]
    grids = {
        f"{spacing} {points}": cells.get(
            f"truss {spacing} {points}",
            lambda spacing=spacing, points=points: exact_result(truss, truss.factors(points, spacing), asked.seed),
        )
        for spacing in SPACINGS
        for points in asked.grids
    }
    surrogates = {
        (name, surrogate, size, design): cells.get(
            f"{name} {surrogate} {size} {design}",
            lambda *place, chosen=(case, surrogate, size, design): surrogate_result(registry, *chosen, asked.seed),
        )
        for name, case in cases.items()
        for size in case.sizes[: asked.sizes]
        for surrogate in SURROGATES
        for design in range(1, asked.designs + 1)
    }
    record = make_record(cases, exact, grids, surrogates)
    write_record(asked.out, "study.json", record)
    write_whole(asked.out / "tables.md", study_tables(record).encode())
    write_pictures(asked.out, study_figures(record))
    print(f"wrote study.json, tables.md and the figures to {asked.out}")


def _arguments():
    arguments = argparse.ArgumentParser(prog="python -m examples.published_sensitivity", description=__doc__)
    arguments.add_argument("--out", type=Path, default=Path("published-sensitivity"), help="folder of the study")
    arguments.add_argument("--designs", type=int, default=20, help="experimental designs of every size")
    arguments.add_argument("--sizes", type=int, default=4, help="how many of the sizes 100, 400, 700, 1000")
    arguments.add_argument("--grids", type=int, nargs="+", default=GRIDS, help="grid values of each input")
    arguments.add_argument("--seed", type=int, default=1, help="seed of everything random")
    return arguments.parse_args()


if __name__ == "__main__":
    main()
