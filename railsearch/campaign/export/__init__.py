"""The record of a campaign for other programs: a tidy table as Parquet or CSV, and IOHprofiler's format."""

from railsearch.campaign.export.iohprofiler import write_iohprofiler
from railsearch.campaign.export.table import results_table, write_csv, write_parquet

__all__ = ["results_table", "write_csv", "write_iohprofiler", "write_parquet"]
