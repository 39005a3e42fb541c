"""The worked example of an imported track: what is recorded is what its command makes, and the README says what is in it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import railsearch
from railsearch.site import read_toml

FOLDER = Path(__file__).parents[2] / "examples" / "imported_track"
RECORD: dict[str, Any] = json.loads((FOLDER / "study.json").read_text(encoding="utf-8"))

pytestmark = pytest.mark.fem


def test_the_readme_has_every_table_and_every_figure() -> None:
    from examples.imported_track.record import study_tables

    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    rows = [line for line in study_tables(RECORD).splitlines() if line.startswith("|")]
    assert len(rows) > 8
    assert set(rows) <= set(text.splitlines())
    for figure in ("mesh", "deflection", "force", "energy", "convergence"):
        assert f"({figure}.png)" in text
        assert (FOLDER / f"{figure}.png").stat().st_size < 300_000


def test_recorded_designs_have_the_recorded_values(tmp_path: Path) -> None:
    from examples.imported_track.__main__ import write_site
    from examples.imported_track.finite_elements import Section, assemble

    write_site(tmp_path, assemble(Section()))
    sections = read_toml(tmp_path / "site.toml")
    worst = sections.pop("worst")
    assert worst == RECORD["achievement"]["worst"]
    problem = railsearch.problem("imported-track", sections={k: v for k, v in sections.items() if k != "problem"})
    assert problem.model is not None
    for entry in (RECORD["reference"], RECORD["best"]):
        design = np.array([entry["design"][name] for name in problem.space.names])
        assert dict(problem.simulate(design).metrics) == pytest.approx(entry["metrics"], rel=1e-6)
    better, start = RECORD["best"]["metrics"], RECORD["reference"]["metrics"]
    assert all(better[name] < 0.85 * start[name] for name in ("F_max", "E_max"))


def test_rigid_motion_of_the_ground_costs_no_energy_and_weighs_what_it_should() -> None:
    import skfem

    from examples.imported_track.finite_elements import Section, _ground, _materials, _mesh

    section = Section(length=6.0, jump=3.0, element=0.3)
    x = np.linspace(0.0, 6.0, 21)
    mesh = _mesh(section, x)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()))
    mass, damping, stiffness = _ground(section, mesh, basis, _materials(section, mesh))
    up = np.zeros(basis.N)
    up[basis.nodal_dofs[1]] = 1.0
    turn = np.zeros(basis.N)
    turn[basis.nodal_dofs[0]], turn[basis.nodal_dofs[1]] = -mesh.p[1], mesh.p[0]
    largest = abs(stiffness).max()
    assert abs(up @ stiffness @ up) < 1e-9 * largest
    assert abs(turn @ stiffness @ turn) < 1e-9 * largest
    depths = {"ballast": (0.3, 6.0), "soft": (3.0, 3.0), "stiff": (3.0, 3.0)}
    weight = sum(getattr(section, name).density * depth * length for name, (depth, length) in depths.items())
    assert up @ mass @ up == pytest.approx(section.width * weight, rel=1e-12)
    shear = sum(
        np.sqrt(getattr(section, name).density * getattr(section, name).lame[1]) * depth
        for name, depth in (("ballast", 0.6), ("soft", 3.0), ("stiff", 3.0))
    )
    assert up @ damping @ up == pytest.approx(section.width * shear, rel=1e-9)


def test_the_command_makes_the_record_and_goes_on_after_a_stop(study: Callable[..., dict[str, Any]], tmp_path: Path) -> None:
    from examples.imported_track.__main__ import main

    words = ("--length", 14.4, "--element", 0.3, "--seed", 2)
    study(main, tmp_path / "study", *words, "--budget", 21)
    assert {path.name for path in (tmp_path / "study").glob("*")} >= {"track", "study.db", "tables.md", "mesh.png"}
    again = study(main, tmp_path / "study", *words, "--budget", 21)
    assert again["best"]["budget"] == 21
    assert again["best"]["failed"] == 0
    assert again["best"]["value"] <= 0.25
    assert len(again["evaluations"]) == 21
