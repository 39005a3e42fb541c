"""Which inputs move the worst passages over a bridge, and which ranges keep limits out of reach: the whole study.

    python -m examples.ttb_sensitivity --out ttb-sensitivity --workers 2

After any stop the same command goes on from the last finished simulation, study or surrogate.
"""

import argparse
import json
from pathlib import Path

from examples.studies import write_pictures, write_record
from examples.ttb_sensitivity.comparison import COMPARED, DEFINITIONS, STUDIES, THRESHOLDS, compared_surrogates
from examples.ttb_sensitivity.record import make_record
from examples.ttb_sensitivity.tables import study_tables
from railsearch.commands.options import Asked
from railsearch.commands.sampling import sampled_into
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.report.sensitivity_figures import sensitivity_figures
from railsearch.report.sensitivity_page import write_sensitivity_report
from railsearch.run_directory import write_whole
from railsearch.samples import ExperimentDesign
from railsearch.sensitivity_study import StudySettings, StudyWatcher, confirm, problem_data, study_document, study_samples
from railsearch.simulation import simulators
from railsearch.site import Site

PROBLEM = "train-track-bridge"
CRITERIA = ("W_z", "U_r", "A_s", "U_d")
COMMAND = "python -m examples.ttb_sensitivity"
SHOWN = ("importances", "thresholds")
"""The figures of the README."""


def main():
    """Sample both definitions of the sleeper acceleration, study all criteria, compare the surrogates, write it down."""
    asked, registry = _arguments(), load_plugins()
    sampled = {name: _sampled(registry, name, sections, asked) for name, sections in DEFINITIONS.items()}
    documents = {label: _studied(registry, label, *sampled[STUDIES[label].definition], asked) for label in STUDIES}
    data = {name: found for name, (_, found) in sampled.items()}
    comparison = compared_surrogates(registry, data, asked.surrogates, asked.seed, asked.out / "surrogates.json")
    record = make_record(documents, comparison)
    write_record(asked.out, "study.json", record)
    write_whole(asked.out / "tables.md", study_tables(record).encode())
    for label, document in documents.items():
        figures = {criterion["name"]: sensitivity_figures(criterion) for criterion in document["criteria"]}
        named = {f"{label}-{kind}": drawn[kind] for drawn in figures.values() for kind in SHOWN}
        write_pictures(asked.out, named)
        write_sensitivity_report(asked.out / f"{label}.html", document, figures)
    print(f"wrote study.json, tables.md, reports and figures to {asked.out}")


def _sampled(registry, name, sections, asked):
    """The problem with one definition, and its samples, evaluated as far as they are not in the folder yet."""
    settings = ProblemSettings(PROBLEM, CRITERIA, sections)
    problem = make_problem(registry, settings)
    file = asked.out / f"{name}.parquet"
    wanted = (ExperimentDesign.LHS, asked.samples, asked.seed)
    simulating = simulators(problem, None, asked.workers)
    sampled_into(file, registry, Asked(problem, settings, Site(PROBLEM)), wanted, simulating)
    return problem, problem_data(problem, file)


def _studied(registry, label, problem, data, asked):
    """The document of one study, kept in the folder once it is whole."""
    study, file = STUDIES[label], asked.out / f"{label}.json"
    if file.exists():
        return json.loads(file.read_text(encoding="utf-8"))
    thresholds = {study.criterion: THRESHOLDS[study.criterion]}
    settings = StudySettings((study.criterion,), thresholds, asked.points, study.surrogate, study.settings, seed=asked.seed)
    studies = confirm(study_samples(registry, data, settings, StudyWatcher(print)), problem, simulators(problem))
    document = study_document(data, settings, studies, COMMAND)
    write_whole(file, json.dumps(document, ensure_ascii=False, allow_nan=False).encode())
    return document


def _arguments():
    arguments = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    arguments.add_argument("--out", type=Path, default=Path("ttb-sensitivity"), help="folder of the study")
    arguments.add_argument("--samples", type=int, default=3000, help="simulations for each definition")
    arguments.add_argument("--points", type=int, default=100, help="grid values of each input")
    arguments.add_argument("--surrogates", nargs="*", default=COMPARED, help="which of them are compared")
    arguments.add_argument("--workers", type=int, default=1, help="processes that simulate")
    arguments.add_argument("--seed", type=int, default=1, help="seed of everything random")
    return arguments.parse_args()


if __name__ == "__main__":
    main()
