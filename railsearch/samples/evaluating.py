"""Evaluate the designs of an experiment, those that a record lacks, and record each as it is finished."""

from contextlib import closing

import numpy as np
from threadpoolctl import threadpool_limits

from railsearch.budget import evaluation_of
from railsearch.design_problem import DesignProblem
from railsearch.errors import StorageError
from railsearch.interfaces import Evaluation, Proposal
from railsearch.run import Record, Watch
from railsearch.samples.experiment import Experiment, designs_of
from railsearch.simulation import Simulators


def evaluate_samples(
    problem: DesignProblem, experiment: Experiment, record: Record, watch: Watch, simulating: Simulators
) -> list[Evaluation]:
    """The evaluations of an experiment in the order of its designs; a failed one has its reason.

    record: where evaluations are kept, and from which those of an earlier process are taken; watch: called with every new
    evaluation. Raises StorageError if the record cannot be written, or has a design that is not the experiment's.
    """
    designs = designs_of(problem, experiment)
    evaluations = {evaluation.number: evaluation for evaluation in record.load()}
    for evaluation in evaluations.values():
        if not np.array_equal(evaluation.design, designs[evaluation.number]):
            raise StorageError(
                f"the record differs from this experiment at sample {evaluation.number + 1}: it was made by other versions "
                "of railsearch, of a plugin or of a library, or was changed. Use the versions named in it, or another --out"
            )
    missing = [number for number in range(experiment.number) if number not in evaluations]
    with closing(simulating), threadpool_limits(1):
        if missing:
            simulating.warm_up()
        with closing(simulating.simulate([designs[number] for number in missing])) as finished:
            for place, simulated in finished:
                number = missing[place]
                proposal = Proposal(designs[number], str(experiment.design))
                evaluations[number] = evaluation_of(problem, number, proposal, simulated)
                record.append(evaluations[number])
                watch(evaluations[number])
    return [evaluations[number] for number in range(experiment.number)]
