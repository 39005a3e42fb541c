"""The note of a study as Optuna's dashboard keeps it: in parts, among the study's system attributes.

The dashboard's own `save_note` cannot be had without the dashboard, which takes longer to import than all else that a run
needs before it begins.
"""

from collections.abc import Mapping
from typing import Any

VERSION = "dashboard:note_ver"
PART = "dashboard:note_str:"
PART_LENGTH = 2045


def note_attributes(note: str, stored: Mapping[str, Any]) -> dict[str, Any]:
    """The system attributes that make `note` the note of a study with the system attributes `stored`."""
    earlier = {key: "" for key in stored if key.startswith(PART)}
    begins = range(0, len(note), PART_LENGTH)
    parts = {f"{PART}{number}": note[begin : begin + PART_LENGTH] for number, begin in enumerate(begins)}
    return {VERSION: stored.get(VERSION, 0) + 1, **earlier, **parts}
