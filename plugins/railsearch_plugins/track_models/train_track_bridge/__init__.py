"""Vehicle-track-bridge model: a train on ballast track that crosses a simply supported bridge."""
