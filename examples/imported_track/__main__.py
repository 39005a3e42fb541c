"""A track assembled with scikit-fem, exported, imported and searched for the pads on either side of a jump of stiffness.

    python -m examples.imported_track --out imported-track-study

It needs scikit-fem: pip install 'railsearch[fem]'. After any stop the same command goes on from the last finished
evaluation.
"""

import argparse
import dataclasses
from pathlib import Path

from examples.imported_track.figures import study_figures
from examples.imported_track.finite_elements import Section, assemble
from examples.imported_track.record import make_record, study_tables
from examples.studies import Search, carry_out, write_pictures, write_record
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings
from railsearch.run import RunSettings
from railsearch.run_directory import write_whole
from railsearch.site import read_site
from railsearch.track_files import SITE, write_track

PROBLEM, OBJECTIVES = "imported-track", ("F_max", "E_max")
# The worst of 30 random designs, 8149 N and 0.0200 N·m, rounded up.
WORST = {"F_max": 9000.0, "E_max": 0.025}
SOFTEST, STIFFEST = 50.0, 1200.0


def write_site(folder, assembled):
    """Export the track with a site file that names the designed pads as variables."""
    write_track(folder, assembled.export, "npz", variables=False)
    lines = []
    for name in assembled.export.parts:
        side, group = name.split("_")
        lines += [f"[design.variables.{name}]", f"lower = {SOFTEST}", f"upper = {STIFFEST}", 'unit = "MN/m"']
        lines += [f'meaning = "pads of group {group} {side} the jump, counted from it"', ""]
    lines += ["[worst]", *(f"{name} = {value}" for name, value in WORST.items()), ""]
    text = (folder / SITE).read_text(encoding="utf-8") + "\n".join(lines)
    write_whole(folder / SITE, text.encode("utf-8"))


def main():
    """Assemble, export, search, then write study.json, tables.md and the figures."""
    arguments = argparse.ArgumentParser(prog="python -m examples.imported_track", description=__doc__)
    arguments.add_argument("--out", type=Path, default=Path("imported-track-study"), help="folder of the study")
    arguments.add_argument("--budget", type=int, default=80, help="evaluations of the search")
    arguments.add_argument("--seed", type=int, default=1, help="seed of the search")
    arguments.add_argument("--length", type=float, default=Section.length, help="length of the section in m")
    arguments.add_argument("--element", type=float, default=Section.element, help="length of an element in m")
    asked = arguments.parse_args()
    jump = round(asked.length / Section.length * Section.jump / Section.spacing) * Section.spacing
    section = dataclasses.replace(Section(), length=asked.length, element=asked.element, jump=jump)
    assembled, track = assemble(section), asked.out / "track"
    if not (track / SITE).exists():
        write_site(track, assembled)
    registry = load_plugins()
    site = read_site(track / SITE, registry, PROBLEM)
    search = Search(
        "pads",
        ProblemSettings(PROBLEM, OBJECTIVES, site.sections, "asf", worst=site.worst),
        RunSettings("dycors", asked.budget, asked.seed),
    )
    done = carry_out(registry, search, asked.out)
    record = make_record(done, assembled)
    write_record(asked.out, "study.json", record)
    write_whole(asked.out / "tables.md", study_tables(record).encode("utf-8"))
    write_pictures(asked.out, study_figures(done.problem, assembled, record))
    print(f"wrote study.json, tables.md and the figures to {asked.out}")


if __name__ == "__main__":
    main()
