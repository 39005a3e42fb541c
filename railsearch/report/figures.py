"""Which figures a run has, and their files: the same run writes the same bytes."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation
from railsearch.result import reference_evaluation, stated_preferences, values_of
from railsearch.run import best
from railsearch.run_directory import write_whole, writing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_PER_INCH = 150


def run_figures(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> dict[str, Figure]:
    """The search history and, where a best design was found, the problem's own pictures of reference and best design."""
    from railsearch.report.history import history_figure

    reference = reference_evaluation(problem, evaluations)
    found = best(evaluations, None if reference is None else reference.objectives)
    designs = {"reference": reference, "best": found}
    shown = {label: evaluation.design for label, evaluation in designs.items() if evaluation is not None}
    pictures = problem.figures(shown) if found is not None else {}
    figures = {"history": history_figure(problem, evaluations), **pictures}
    if preferences := stated_preferences(problem):
        from railsearch.report.preferences import preference_figure

        values = {label: values_of(problem, evaluation) for label, evaluation in designs.items() if evaluation is not None}
        figures["preferences"] = preference_figure(preferences, values)
    return figures


def write_figures(folder: Path, figures: Mapping[str, Figure]) -> None:
    """Write every figure as PNG and SVG, and remove those of an earlier report that are none any more.

    Raises StorageError if the folder cannot be written.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for path in (*folder.glob("*.svg"), *folder.glob("*.png")):
            if path.stem not in figures:
                path.unlink()
        for name, figure in figures.items():
            for kind in ("svg", "png"):
                write_whole(folder / f"{name}.{kind}", drawn(figure, kind, name))


def drawn(figure: Figure, kind: str, name: str) -> bytes:
    """A figure as the bytes of an SVG (identifiers made from its name) or PNG file, without a date."""
    import matplotlib

    buffer = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": name, "svg.fonttype": "path"}):
        figure.savefig(buffer, format=kind, dpi=DOTS_PER_INCH, metadata={"Date": None} if kind == "svg" else None)
    return buffer.getvalue()
