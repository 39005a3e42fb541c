"""Design problem A, whole: four single objectives and two together, compared.

    python -m examples.level_crossing_study --out level-crossing-study

After any stop the same command goes on from the last finished evaluation.
"""

import argparse
from pathlib import Path

from examples.level_crossing_study.figures import study_figures
from examples.level_crossing_study.record import make_record
from examples.level_crossing_study.tables import study_tables
from examples.studies import Search, carry_out, write_pictures, write_record
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings
from railsearch.run import RunSettings
from railsearch.run_directory import write_whole
from railsearch.site import read_site

PROBLEM = "level-crossing"
MEASURES = ("F_rms", "F_max", "E_rms", "E_max")


def searches(asked, sections):
    """Each measure alone, F_max and E_max through the achievement function, and random designs to compare with."""
    single = RunSettings("dycors", asked.budget, asked.seed)
    return [
        *(Search(name, ProblemSettings(PROBLEM, (name,), sections), single) for name in MEASURES),
        Search(
            "asf",
            ProblemSettings(PROBLEM, ("F_max", "E_max"), sections, "asf"),
            RunSettings("dycors", asked.asf_budget, asked.seed),
        ),
        Search("random", ProblemSettings(PROBLEM, ("F_max",), sections), RunSettings("random", asked.random, asked.seed)),
    ]


def main():
    """Search, then write study.json, tables.md and the figures."""
    arguments = argparse.ArgumentParser(prog="python -m examples.level_crossing_study", description=__doc__)
    arguments.add_argument("--out", type=Path, default=Path("level-crossing-study"), help="folder of the study")
    arguments.add_argument("--budget", type=int, default=200, help="evaluations for each single objective")
    arguments.add_argument("--asf-budget", type=int, default=400, help="evaluations for both objectives")
    arguments.add_argument("--random", type=int, default=100, help="random designs")
    arguments.add_argument("--seed", type=int, default=1, help="seed of all searches")
    arguments.add_argument("--parameters", type=Path, help="site file, by default the Dutch crossing")
    asked = arguments.parse_args()
    registry = load_plugins()
    sections = read_site(asked.parameters, registry, PROBLEM).sections if asked.parameters else {}
    done = [carry_out(registry, search, asked.out) for search in searches(asked, sections)]
    record = make_record(registry, done)
    write_record(asked.out, "study.json", record)
    write_whole(asked.out / "tables.md", study_tables(record).encode("utf-8"))
    write_pictures(asked.out, study_figures(registry, record))
    print(f"wrote study.json, tables.md and the figures to {asked.out}")


if __name__ == "__main__":
    main()
