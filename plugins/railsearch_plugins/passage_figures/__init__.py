"""What the pictures of all track models share: the look of a passage, frames of comparisons, choosing among pictures."""
