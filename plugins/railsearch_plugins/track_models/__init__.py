"""Vehicle-track models."""
