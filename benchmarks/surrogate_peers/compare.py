"""railsearch's surrogates of random inputs beside those of public libraries, on the same samples of the truss with 23 bars.

python benchmarks/surrogate_peers/compare.py [--sizes 100 400 1000] [--seeds 5] [--participants pce openturns-lars …]

Every fit is a process of its own, in the environment of its library and with one thread; what it is handed and answers is
described in clients/fitting.py. Finished fits are kept in `cells.json`, and the same command goes on. Where a first
fit takes more than a minute of processor time there are fewer seeds.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from statistics import median

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
from truss_errors import FRESH, generalisation_error, spread_of_errors, truss_points  # noqa: E402 - found by the path

from railsearch_problems.truss import DISTRIBUTIONS, closed_form  # noqa: E402 - beside the line above

RESULTS = HERE.parent / "results" / HERE.name
OURS = ("railsearch", "scikit_learn")
"""Clients that run in the environment of this script."""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
SLOW = 60.0
"""Processor seconds of a fit from which on there are fewer seeds."""


@dataclass(frozen=True)
class Participant:
    """A model of a client, and in words what was chosen."""

    client: str
    model: str
    choice: str


PARTICIPANTS = {
    "pce": Participant(
        "railsearch", "pce", "all defaults: polynomials of the inputs' own, search over norm and degree, growth"
    ),
    "pce-hermite": Participant("railsearch", "pce-hermite", "the same with loads mapped to Hermite polynomials"),
    "kriging": Participant("railsearch", "kriging", "all defaults: Matérn 5/2, maximum likelihood, inputs' own coordinates"),
    "kriging-gaussian": Participant("railsearch", "kriging-gaussian", "the same with a Gaussian correlation"),
    "pck": Participant("railsearch", "pck", "all defaults: the terms of `pce`, Gaussian correlation, restricted likelihood"),
    "openturns-lars": Participant(
        "openturns",
        "lars",
        "least-angle regression with corrected leave-one-out error, hyperbolic sets (q = 0.5), the best degree of 2, 4, 5, "
        "7, 9 with at most two candidates per point; loads on polynomials orthonormal to Gumbel's distribution",
    ),
    "openturns-lars-hermite": Participant("openturns", "lars-hermite", "the same with Hermite polynomials throughout"),
    "chaospy-lars-hermite": Participant(
        "chaospy",
        "lars-hermite",
        "scikit-learn's LassoLarsCV on hyperbolic sets (q = 0.5) of Hermite polynomials, the degree as above, by "
        "cross-validation",
    ),
    "openturns-kriging": Participant(
        "openturns",
        "kriging",
        "Matérn 5/2, constant trend, maximum likelihood by BOBYQA with length scales up to 1000 standard deviations "
        "(the default optimiser and bounds are 30 times less accurate); inputs and values standardised by us",
    ),
    "smt-kriging": Participant(
        "smt",
        "kriging",
        "KRG with its defaults (Gaussian correlation) but one start of the search in place of 10, "
        "which took six times as long for the same error (N = 400: 167 s of processor time, 3.1e-6; one start 27 s, 2.6e-6)",
    ),
    "smt-kriging-matern": Participant("smt", "kriging-matern", "the same with Matérn 5/2"),
    "scikit-learn-gp": Participant("scikit_learn", "gp", "Matérn 5/2, a length scale for every input, standardised"),
}


def main():
    """Run what is missing, and write the tables after every fit."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--sizes", nargs="+", type=int, default=(100, 400, 1000))
    arguments.add_argument("--seeds", type=int, default=5)
    arguments.add_argument("--slow-seeds", type=int, default=2, help="seeds where a fit takes more than a minute")
    arguments.add_argument("--participants", nargs="+", default=tuple(PARTICIPANTS), choices=tuple(PARTICIPANTS))
    arguments.add_argument("--patience", type=float, default=3600.0, help="seconds until a fit is given up")
    arguments.add_argument("--out", type=Path, default=RESULTS)
    asked = arguments.parse_args()
    record = Record(asked.out)
    for size in asked.sizes:
        for seed in range(asked.seeds):
            for name in asked.participants:
                if not record.has(name, size, seed) and seed < record.seeds(name, size, asked.seeds, asked.slow_seeds):
                    record.keep(name, size, seed, cell(PARTICIPANTS[name], size, seed, asked.patience))
    record.keep_tables()


class Record:
    """The finished fits by participant, size and seed, in a file."""

    def __init__(self, folder):
        self._folder = folder
        self._file = folder / "cells.json"
        self._cells = json.loads(self._file.read_text(encoding="utf-8")) if self._file.exists() else {}

    def has(self, name, size, seed):
        """Whether a fit is finished."""
        return key(name, size, seed) in self._cells

    def seeds(self, name, size, usual, slow):
        """How many seeds there are to be: fewer where the first fit was slow or failed."""
        first = self._cells.get(key(name, size, 0), {"fit": [0.0, 0.0]})
        return slow if "failed" in first or first["fit"][1] > SLOW else usual

    def keep(self, name, size, seed, found):
        """Add a fit, and replace the files by whole new ones."""
        self._cells[key(name, size, seed)] = found
        self._replace("cells.json", json.dumps(self._cells, indent=1, sort_keys=True, ensure_ascii=False) + "\n")
        self.keep_tables()
        print(key(name, size, seed), found.get("failed") or f"{found['error']:.2e}", flush=True)

    def keep_tables(self):
        """Write the tables of what there is."""
        self._replace("tables.md", tables(self._cells))

    def _replace(self, name, text):
        self._folder.mkdir(parents=True, exist_ok=True)
        draft = self._folder / f"{name}.draft"
        draft.write_text(text, encoding="utf-8")
        draft.replace(self._folder / name)


def key(name, size, seed):
    """What a fit is found by in the record."""
    return f"{name} {size} {seed}"


def cell(participant, size, seed, patience):
    """Error and times of a fit, or why there is none."""
    points, fresh = truss_points(size, seed)
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "data.npz", Path(folder) / "answer.npz"
        np.savez(source, points=points, values=closed_form(points), fresh=fresh, **described_inputs())
        reason = refusal([*command(participant), str(source), str(target)], patience)
        if reason:
            return {"failed": reason}
        with np.load(target) as answer:
            return {
                "error": generalisation_error(answer["predicted"], closed_form(fresh)),
                "fit": answer["fit"].tolist(),
                "prediction": answer["prediction"].tolist(),
                "versions": json.loads(str(answer["versions"])),
                "note": json.loads(str(answer["note"])),
            }


def described_inputs():
    """The distributions of the inputs as clients are told them."""
    tables = list(DISTRIBUTIONS.values())
    fields = {"families": "distribution", "means": "mean", "deviations": "std"}
    return {field: np.array([table[entry] for table in tables]) for field, entry in fields.items()}


def command(participant):
    """The program that fits a participant's model."""
    python = HERE / ".environments" / participant.client / "bin" / "python"
    if participant.client in OURS:
        python = Path(sys.executable)
    elif not python.exists():
        sys.exit(
            f"there is no {python}; build it by `python benchmarks/environments.py {HERE.name} build {participant.client}`"
        )
    return [str(python), str(HERE / "clients" / f"{participant.client}_client.py"), participant.model]


def refusal(called, patience):
    """Why a client had no answer: the last line of what it said; nothing if it had one."""
    try:
        done = subprocess.run(called, env={**os.environ, **ONE_THREAD}, capture_output=True, text=True, timeout=patience)
    except subprocess.TimeoutExpired:
        return f"no answer within {patience:g} s"
    said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
    return said[-1] if done.returncode else ""


def tables(cells):
    """All sizes in Markdown, what everybody is, and with which versions."""
    sizes = sorted({int(name.split()[1]) for name in cells})
    parts = [
        "# Surrogates beside those of other libraries",
        f"Truss of 23 bars, Latin hypercubes of N points, {FRESH} fresh points; one thread, {os.cpu_count()} cores with "
        f"other work beside; {datetime.now(UTC):%Y-%m-%d}. Times are medians; of a prediction, processor time.",
        *(f"## N = {size}\n\n{table_of(size, cells)}" for size in sizes),
        "## What was chosen",
        "\n".join(f"- `{name}`: {participant.choice}." for name, participant in PARTICIPANTS.items()),
        f"Versions: {versions(cells)}.",
    ]
    return "\n\n".join(parts) + "\n"


def table_of(size, cells):
    """A line for every participant, the least error first."""
    head = ["participant", "seeds", "ε_gen: median (range)", "fit [s]", "fit, processor [s]", "one prediction [µs]", "terms"]
    found = [(name, [cells[key_] for key_ in cells if key_.rsplit(" ", 1)[0] == f"{name} {size}"]) for name in PARTICIPANTS]
    rows = sorted((row for name, runs in found if runs for row in [row_of(name, runs)]), key=lambda row: row[0])
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *(row for _, row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def row_of(name, runs):
    """The median error, to sort by, and the line of a participant."""
    whole = [run for run in runs if "failed" not in run]
    if not whole:
        return np.inf, [name, f"0 of {len(runs)}", runs[0]["failed"], *["-"] * 4]
    errors = [run["error"] for run in whole]
    elapsed, processor = (f"{median(run['fit'][k] for run in whole):.3g}" for k in (0, 1))
    prediction = f"{median(run['prediction'][1] for run in whole) / FRESH * 1e6:.3g}"
    counts = [run["note"]["terms"] for run in whole if "terms" in run["note"]]
    seeds = str(len(whole)) if len(whole) == len(runs) else f"{len(whole)} of {len(runs)}"
    return median(errors), [name, seeds, spread_of_errors(errors), elapsed, processor, prediction, terms_of(counts)]


def terms_of(counts):
    """The median number of terms of an expansion, if it is one."""
    return f"{median(counts):.0f}" if counts else "-"


def versions(cells):
    """All distributions with the versions that answered."""
    found = {f"{name} {version}" for run in cells.values() for name, version in run.get("versions", {}).items()}
    return ", ".join(sorted([*found, f"Python {platform.python_version()}"]))


if __name__ == "__main__":
    main()
