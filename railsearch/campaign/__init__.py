"""Campaigns: problems × strategies × repetitions on one budget, what they cost, and what they say."""
