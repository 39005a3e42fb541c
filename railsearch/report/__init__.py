"""The figures of a run and the page that gathers them."""

from railsearch.report.figures import run_figures, write_figures
from railsearch.report.page import write_report

__all__ = ["run_figures", "write_figures", "write_report"]
