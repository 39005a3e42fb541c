"""A track whose matrices come from any finite element program, crossed by one wheel."""

from railsearch.hookspecs import Register, hookimpl
from railsearch_plugins.track_models.imported_track.model import ImportedTrack
from railsearch_plugins.track_models.imported_track.parameters import ImportedTrackParameters

__all__ = ["ImportedTrack", "ImportedTrackParameters"]


@hookimpl
def railsearch_track_models(register: Register) -> None:
    """Register the imported track."""
    register("imported-track", ImportedTrack)
