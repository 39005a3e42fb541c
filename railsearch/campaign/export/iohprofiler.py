"""The record of a campaign in IOHprofiler's data format, which IOHanalyzer and iohinspector read.

One algorithm is a strategy, one function a problem, one run a repetition (its number is the run's instance):

    STRATEGY/IOHprofiler_fK_PROBLEM.json              what was run: function, algorithm, best value of every run
    STRATEGY/data_fK_PROBLEM/IOHprofiler_fK_DIMd.dat  every evaluation of every run: evaluations raw_y [F2 F3 …]

Source: de Nobel et al. 2024 (IOHexperimenter), whose files of version 0.3.17 are of this layout.
"""

import json
import re
import tempfile
import zlib
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from railsearch.campaign.cells import Cell
from railsearch.campaign.export.recorded import Recorded, recorded_cells
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.run_directory import write_whole, writing
from railsearch.space import FloatArray

VERSION = "0.3.17"
NOTE_FILE = "README.md"
NOTE_TITLE = "# A railsearch campaign in IOHprofiler's format"
NOTE = """{title}

Campaign {campaign}. One algorithm is a strategy, one function a problem, one run a repetition; the number of the repetition
is the run's instance.

`raw_y` is the objective as it is minimised: a maximised quantity is negated. It is `inf` where the evaluation failed or the
design broke a constraint. Of several objectives `raw_y` is the first; `F2`, `F3`, … are the others, and the best point of a
run in the JSON files is the best in the first objective. A run without a feasible design has no best value (null).

{functions}
"""


def write_iohprofiler(results: CampaignResults, folder: Path) -> None:
    """Write all evaluations of a campaign in IOHprofiler's format, the whole folder or nothing.

    An earlier export in the folder is replaced. Raises InputError if the folder holds anything else or there is no
    evaluation yet, StorageError if it cannot be written.
    """
    rows = recorded_cells(results)
    if not rows:
        raise InputError(f"export: campaign {results.campaign.name} has no evaluation yet, run it first")
    _check_free(folder)
    with writing(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as temporary:
            _write_all(results, rows, Path(temporary) / "new")
            if folder.exists():
                folder.rename(Path(temporary) / "old")
            (Path(temporary) / "new").rename(folder)


def _check_free(folder: Path) -> None:
    """Raise InputError unless the folder is new, empty, or an earlier export."""
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return
    note = folder / NOTE_FILE
    if not note.is_file() or not note.read_text(encoding="utf-8", errors="replace").startswith(NOTE_TITLE):
        raise InputError(f"{folder}: a new or empty folder is needed, or an earlier export; this one holds something else")


def _write_all(results: CampaignResults, rows: Recorded, folder: Path) -> None:
    folder.mkdir()
    for _, runs in groupby(rows, key=lambda row: (row[0].problem, row[0].strategy)):
        _write_runs(results, list(runs), folder)
    functions = [
        f"- f{number}, {asked.label}: {', '.join(map(_objective, results.problems[asked.label].objectives))}"
        for number, asked in enumerate(results.campaign.problems, 1)
    ]
    note = NOTE.format(title=NOTE_TITLE, campaign=results.campaign.name, functions="\n".join(functions))
    write_whole(folder / NOTE_FILE, note.encode("utf-8"))


def _objective(quantity: Quantity) -> str:
    unit = f" [{quantity.unit}]" if quantity.unit else ""
    return f"{quantity.name}{unit}{', maximised' if quantity.maximised else ''}"


def _write_runs(results: CampaignResults, runs: Recorded, folder: Path) -> None:
    """The two files of one strategy on one problem."""
    cell, _ = runs[0]
    problem = results.problems[cell.problem]
    number = [asked.label for asked in results.campaign.problems].index(cell.problem) + 1
    name = f"f{number}_{_file_name(cell.problem)}"
    data = f"data_{name}/IOHprofiler_f{number}_DIM{problem.space.dimension}.dat"
    place = folder / _file_name(cell.strategy)
    (place / data).parent.mkdir(parents=True)
    write_whole(place / data, "".join(_run_text(record) for _, record in runs).encode("ascii"))
    document = _about(results, cell, number) | {
        "attributes": _columns(problem.n_obj),
        "scenarios": [{"dimension": problem.space.dimension, "path": data, "runs": [_run(*run) for run in runs]}],
    }
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(place / f"IOHprofiler_{name}.json", text.encode("utf-8"))


def _file_name(label: str) -> str:
    """The label, or a plain name made from it that no other label has."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", label).lstrip(".")
    return plain if plain == label else f"{plain}-{zlib.crc32(label.encode('utf-8')):08x}"


def _about(results: CampaignResults, cell: Cell, number: int) -> dict[str, Any]:
    """What was run; experiment attributes are text in this format."""
    campaign = results.campaign
    strategy = next(strategy for strategy in campaign.strategies if strategy.label == cell.strategy)
    return {
        "version": VERSION,
        "suite": campaign.name,
        "function_id": number,
        "function_name": cell.problem,
        "maximization": False,
        "algorithm": {"name": strategy.label, "info": f"{strategy.name} {json.dumps(dict(strategy.settings), default=str)}"},
        "experiment_attributes": [{"budget": str(campaign.budget)}, {"campaign_seed": str(campaign.seed)}],
    }


def _columns(objectives: int) -> list[str]:
    return ["evaluations", "raw_y", *(f"F{number}" for number in range(2, objectives + 1))]


def _run(cell: Cell, record: CellRecord) -> dict[str, Any]:
    """A run and its best point, by the first objective."""
    values = _minimised(record)[:, 0]
    row = int(values.argmin())
    found = bool(np.isfinite(values[row]))
    best = {"evals": row + 1, "y": float(values[row]), "x": record.designs[row].tolist()}
    return {
        "instance": cell.repetition,
        "evals": len(values),
        "best": best if found else {"evals": 0, "y": None, "x": []},
    }


def _minimised(record: CellRecord) -> FloatArray:
    """Objectives (n, m), infinite where an evaluation failed or broke a constraint."""
    return np.where(record.feasible[:, None], record.objectives, np.inf)


def _run_text(record: CellRecord) -> str:
    """The rows of a run under their header; numbers in as many digits as it takes to read the same ones."""
    values = _minimised(record)
    lines = [f"{number} {' '.join(map(repr, row))}" for number, row in enumerate(values.tolist(), 1)]
    return "\n".join([" ".join(_columns(values.shape[1])), *lines, ""])
