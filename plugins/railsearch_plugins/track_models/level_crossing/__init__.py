"""Vehicle-track model of a level crossing: one rail on ballast track and embedded in slabs, one wheel."""

from railsearch.hookspecs import Register, hookimpl
from railsearch_plugins.track_models.level_crossing.model import LevelCrossing
from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters

__all__ = ["LevelCrossing", "LevelCrossingParameters"]


@hookimpl
def railsearch_track_models(register: Register) -> None:
    """Register the level crossing."""
    register("level-crossing", LevelCrossing)
