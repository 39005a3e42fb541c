"""The studies in examples/ are imported from the repository; they are no part of the distribution."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, Any]]:
    """Run the command of a study in this process; gives what it recorded."""

    def run(main: Callable[[], None], out: Path, *words: object) -> dict[str, Any]:
        monkeypatch.setattr(sys, "argv", ["study", "--out", str(out), *map(str, words)])
        main()
        recorded: dict[str, Any] = json.loads((out / "study.json").read_text(encoding="utf-8"))
        return recorded

    return run
