"""Which inputs move the worst passages over a bridge, and which ranges keep limits out of reach: the whole study.

    python -m examples.ttb_sensitivity --out ttb-sensitivity --workers 2

After any stop the same command goes on from the last finished simulation.
"""

import argparse
import json
from pathlib import Path

from examples.ttb_sensitivity.comparison import CRITERIA, DEFINITIONS, THRESHOLDS, compared_surrogates
from examples.ttb_sensitivity.record import make_record
from examples.ttb_sensitivity.tables import study_tables
from railsearch.commands.options import Asked
from railsearch.commands.sampling import sampled_into
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.report.figures import write_figures
from railsearch.report.sensitivity_figures import sensitivity_figures
from railsearch.report.sensitivity_page import write_sensitivity_report
from railsearch.run_directory import write_whole
from railsearch.samples import ExperimentDesign
from railsearch.sensitivity_study import StudySettings, problem_data, study_document, study_samples
from railsearch.simulation import simulators
from railsearch.site import Site

PROBLEM = "train-track-bridge"


def main():
    """Sample both definitions of the sleeper acceleration, study all criteria, compare the surrogates, write it down."""
    asked = _arguments()
    registry, documents, data = load_plugins(), {}, {}
    for name, sections in DEFINITIONS.items():
        data[name] = _sampled(registry, name, sections, asked)
        settings = StudySettings(CRITERIA[name], THRESHOLDS, asked.points, seed=asked.seed)
        studies = study_samples(registry, data[name], settings, print)
        documents[name] = study_document(data[name], settings, studies, "python -m examples.ttb_sensitivity")
    comparison = compared_surrogates(registry, data["pass-by"], asked.seed, asked.out / "surrogates.json")
    record = make_record(documents, comparison)
    write_whole(asked.out / "study.json", json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False).encode())
    write_whole(asked.out / "tables.md", study_tables(record).encode())
    for name, document in documents.items():
        figures = {criterion["name"]: sensitivity_figures(criterion) for criterion in document["criteria"]}
        drawn = {f"{output}-{kind}": figure for output, kinds in figures.items() for kind, figure in kinds.items()}
        write_figures(asked.out / f"figures-{name}", drawn)
        write_sensitivity_report(asked.out / f"report-{name}.html", document, figures)
    print(f"wrote study.json, tables.md, the reports and figures to {asked.out}")


def _sampled(registry, name, sections, asked):
    """Samples of the problem with one definition, as far as they are not in the folder yet."""
    objectives = ("W_z", "U_r", "A_s", "U_d")
    settings = ProblemSettings(PROBLEM, objectives, sections)
    problem = make_problem(registry, settings)
    file = asked.out / f"{name}.parquet"
    wanted = (ExperimentDesign.LHS, asked.samples, asked.seed)
    simulating = simulators(problem, None, asked.workers)
    sampled_into(file, registry, Asked(problem, settings, Site(PROBLEM)), wanted, simulating)
    return problem_data(problem, file)


def _arguments():
    arguments = argparse.ArgumentParser(prog="python -m examples.ttb_sensitivity", description=__doc__)
    arguments.add_argument("--out", type=Path, default=Path("ttb-sensitivity"), help="folder of the study")
    arguments.add_argument("--samples", type=int, default=3000, help="simulations for each definition")
    arguments.add_argument("--points", type=int, default=100, help="grid values of each input")
    arguments.add_argument("--workers", type=int, default=1, help="processes that simulate")
    arguments.add_argument("--seed", type=int, default=1, help="seed of everything random")
    return arguments.parse_args()


if __name__ == "__main__":
    main()
