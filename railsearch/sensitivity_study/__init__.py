"""A whole sensitivity analysis: samples, surrogates, extremes, thresholds, and the classical measures beside them."""

from railsearch.sensitivity_study.data import (
    SampledOutput,
    StudyData,
    check_independent,
    own_data,
    problem_data,
    sampled_output,
)
from railsearch.sensitivity_study.on_model import ModelSamples
from railsearch.sensitivity_study.study import (
    FORMAT,
    CriterionStudy,
    StudySettings,
    StudyWatcher,
    check_study,
    confirm,
    study_document,
    study_samples,
)

__all__ = [
    "FORMAT",
    "CriterionStudy",
    "ModelSamples",
    "SampledOutput",
    "StudyData",
    "StudySettings",
    "StudyWatcher",
    "check_independent",
    "check_study",
    "confirm",
    "own_data",
    "problem_data",
    "sampled_output",
    "study_document",
    "study_samples",
]
