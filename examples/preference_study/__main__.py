"""Design problem B, whole: what the preferences range over, and the design that its stakeholders like best.

    python -m examples.preference_study --out preference-study

After any stop the same command goes on from the last finished evaluation.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from examples.preference_study.figures import study_figures
from examples.preference_study.points import read_points, write_points
from examples.preference_study.ranges import find_extremes, linear_preferences, preference_file
from examples.preference_study.record import make_record
from examples.preference_study.tables import study_tables
from examples.studies import Search, carry_out, write_pictures, write_record
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.run import RunSettings
from railsearch.run_directory import write_whole
from railsearch.site import read_site, read_toml

PROBLEM = "level-crossing-preference"
SCALARISER = "preference-minmax"
PUBLISHED = Path(__file__).with_name("published-ranges.toml")
ORIGIN = "Ranges of the preference study: the extremes of every objective alone, rounded outward; made by the study."


def main():
    """Derive the ranges and search with them and with the published ones, directly and on fixed surrogates."""
    asked = _arguments()
    registry = load_plugins()
    sections = read_site(asked.parameters, registry, PROBLEM).sections if asked.parameters else {}
    site = ProblemSettings(PROBLEM, (), sections)
    problem = make_problem(registry, site)
    extremes = find_extremes(registry, site, RunSettings("dycors", asked.extreme_budget, asked.seed), asked.out)
    units = {quantity.name: quantity.unit for quantity in problem.objectives}
    own = asked.out / "own-ranges.toml"
    write_whole(own, preference_file(linear_preferences(extremes), units, ORIGIN).encode("utf-8"))
    direct = RunSettings("dycors", asked.direct_budget, asked.seed)
    settings = {"design_size": asked.points, "surrogates": ["kriging"]}
    fixed = RunSettings("fixed-surrogate", asked.points + asked.confirmations, asked.seed, settings)
    done = {
        "direct": {
            name: carry_out(registry, Search(f"direct, {name} ranges", _preferring(site, path), direct), asked.out)
            for name, path in (("own", own), ("published", PUBLISHED))
        },
        "fixed": {"own": carry_out(registry, Search("fixed surrogates", _preferring(site, own), fixed), asked.out)},
    }
    points = done["fixed"]["own"].evaluations[: asked.points]
    write_points(asked.out / "points.csv", problem, points)
    record = make_record(problem, extremes, done, points)
    write_record(asked.out, "study.json", record)
    write_whole(asked.out / "tables.md", study_tables(record).encode("utf-8"))
    write_pictures(asked.out, study_figures(done["direct"]["own"].problem, record, read_points(asked.out / "points.csv")))
    print(f"wrote own-ranges.toml, points.csv, study.json, tables.md and the figures to {asked.out}")


def _preferring(site, path):
    """The problem of a site with the preferences of a file."""
    return replace(site, scalariser=SCALARISER, scalariser_settings=read_toml(path))


def _arguments():
    arguments = argparse.ArgumentParser(prog="python -m examples.preference_study", description=__doc__)
    arguments.add_argument("--out", type=Path, default=Path("preference-study"), help="folder of the study")
    arguments.add_argument("--extreme-budget", type=int, default=100, help="evaluations for each end of a range")
    arguments.add_argument("--direct-budget", type=int, default=300, help="evaluations of a direct search")
    arguments.add_argument("--points", type=int, default=2000, help="designs to fit the surrogates to")
    arguments.add_argument("--confirmations", type=int, default=20, help="evaluations to confirm what surrogates predict")
    arguments.add_argument("--seed", type=int, default=1, help="seed of all searches")
    arguments.add_argument("--parameters", type=Path, help="site file, by default the crossing of the publication")
    return arguments.parse_args()


if __name__ == "__main__":
    main()
