"""A campaign of 1000 cells × 200 evaluations of a function that costs nothing: what the machinery takes, and its growth.

    python benchmarks/campaign_scale.py [--repetitions 50] [--workers 2] [--out DIR]

Two problems of five variables, random search under ten labels. Prints milliseconds per evaluation over the campaign, the
size of the record, and the time of the whole report (reading, statistics, figures, page, table) from the storage.
"""

import argparse
import resource
import sqlite3
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STRATEGIES = 10
BUDGET = 200
SAMPLES = 10
RAILSEARCH = [sys.executable, "-m", "railsearch"]


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--repetitions", type=int, default=50)
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--out", type=Path)
    asked = arguments.parse_args()
    folder = asked.out or Path(tempfile.mkdtemp(prefix="campaign-scale-"))
    file = _file(folder, asked.repetitions)
    total = 2 * STRATEGIES * asked.repetitions * BUDGET
    print(f"{total // BUDGET} cells, {total} evaluations, {asked.workers} workers")
    start = time.perf_counter()
    words = [*RAILSEARCH, "campaign", str(file), "--workers", str(asked.workers), "--out", str(folder)]
    running = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _follow(running, folder / "study.db", total)
    running.wait()
    print(f"whole command, report included: {time.perf_counter() - start:.0f} s, code {running.returncode}")
    print(f"record: {(folder / 'study.db').stat().st_size / 1e6:.0f} MB")
    start = time.perf_counter()
    subprocess.run([*RAILSEARCH, "report", str(folder)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    print(f"report from the storage: {time.perf_counter() - start:.1f} s")
    print(f"report.html: {(folder / 'report.html').stat().st_size / 1e6:.1f} MB")
    start = time.perf_counter()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    print(f"the same command again, nothing to do but the report: {time.perf_counter() - start:.1f} s")
    print(f"largest process: {resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3:.0f} MB")


def _file(folder: Path, repetitions: int) -> Path:
    strategies = "\n".join(f'[[strategy]]\nname = "random"\nlabel = "random {k + 1}"' for k in range(STRATEGIES))
    problems = "\n".join(
        f'[[problem]]\nname = "{name}"\nsections = {{ function = {{ dimension = 5 }} }}' for name in ("ackley", "rastrigin")
    )
    head = f'[campaign]\nname = "scale"\nbudget = {BUDGET}\nrepetitions = {repetitions}\nseed = 1\n'
    file = folder / "scale.toml"
    file.write_text(f"{head}{problems}\n{strategies}\n")
    return file


def _follow(running: "subprocess.Popen[bytes]", record: Path, total: int) -> None:
    """Print the milliseconds per evaluation of each tenth of the campaign."""
    done, since = 0, time.perf_counter()
    for tenth in range(1, SAMPLES + 1):
        while (count := _count(record)) < tenth * total // SAMPLES and running.poll() is None:
            time.sleep(1.0)
        now = time.perf_counter()
        print(f"to {count:7d} evaluations: {1e3 * (now - since) / max(1, count - done):.2f} ms each", flush=True)
        done, since = count, now


def _count(record: Path) -> int:
    if not record.exists():
        return 0
    try:
        with sqlite3.connect(record, timeout=10.0) as connection:
            return int(connection.execute("SELECT MAX(trial_id) FROM trials").fetchone()[0] or 0)
    except sqlite3.OperationalError:
        return 0


if __name__ == "__main__":
    main()
