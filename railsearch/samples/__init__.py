"""Samples: designs of experiments evaluated into files, and such files read."""

from railsearch.samples.evaluating import evaluate_samples
from railsearch.samples.experiment import Experiment, ExperimentDesign, MeasureDesign, designs_of, input_distributions
from railsearch.samples.reading import Samples, read_samples
from railsearch.samples.sample_file import SampleFile, experiment_identity, sample_file_document
from railsearch.samples.summary import LEVELS, summary
from railsearch.samples.table import natural_values

__all__ = [
    "LEVELS",
    "Experiment",
    "ExperimentDesign",
    "MeasureDesign",
    "SampleFile",
    "Samples",
    "designs_of",
    "evaluate_samples",
    "experiment_identity",
    "input_distributions",
    "natural_values",
    "read_samples",
    "sample_file_document",
    "summary",
]
