"""Vehicle-track-bridge model: a train on ballast track that crosses a simply supported bridge."""

from railsearch.hookspecs import Register, hookimpl
from railsearch_plugins.track_models.train_track_bridge.model import TrainTrackBridge
from railsearch_plugins.track_models.train_track_bridge.parameters import TrainTrackBridgeParameters

__all__ = ["TrainTrackBridge", "TrainTrackBridgeParameters"]


@hookimpl
def railsearch_track_models(register: Register) -> None:
    """Register the train-track-bridge model."""
    register("train-track-bridge", TrainTrackBridge)
