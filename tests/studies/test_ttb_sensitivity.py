"""The sensitivity study of the train-track-bridge system: its record agrees with the publication and with its command."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import railsearch
from railsearch_plugins.track_models.train_track_bridge.parameters import Vehicle

FOLDER = Path(__file__).parents[2] / "examples" / "ttb_sensitivity"
RECORD: dict[str, Any] = json.loads((FOLDER / "study.json").read_text(encoding="utf-8"))
STUDIES: dict[str, dict[str, Any]] = RECORD["studies"]


def share(study: str, *names: str) -> float:
    return sum(STUDIES[study]["importances"][name] for name in names)


def safe(study: str, threshold: float) -> dict[str, list[list[float]]]:
    """Safe ranges by input at a threshold."""
    (found,) = [t for t in STUDIES[study]["thresholds"] if t["value"] == threshold]
    return {factor["name"]: factor["safe"] for factor in found["factors"] if factor["safe"]}


def test_the_readme_has_every_table_and_every_figure() -> None:
    from examples.ttb_sensitivity.tables import study_tables

    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    rows = [line for line in study_tables(RECORD).splitlines() if line.startswith("|")]
    assert len(rows) > 60
    assert set(rows) <= set(text.splitlines())
    for study in STUDIES:
        for kind in ("importances", "thresholds"):
            assert f"({study}-{kind}.png)" in text
            assert (FOLDER / f"{study}-{kind}.png").stat().st_size < 300_000


def test_importances_are_near_the_published_ones() -> None:
    """Shang et al. 2024: 99.5 % of W_z, 65 and 77 % of U_r, 88 % of A_s, 53 % of U_d by the inputs named here."""
    mass = "carbody_mass_factor"
    assert share("W_z", mass, "secondary_stiffness_factor", "irregularity_amplitude") == pytest.approx(0.995, abs=0.005)
    assert share("U_r", mass) == pytest.approx(0.65, abs=0.03)
    assert share("U_r", mass, "bridge_modulus") == pytest.approx(0.77, abs=0.06)
    assert share("A_s-from-the-start", mass, "pad_stiffness") == pytest.approx(0.88, abs=0.03)
    assert share("A_s-from-the-start", "sleeper_mass") == pytest.approx(0.03, abs=0.01)
    assert share("U_d", "bridge_modulus", "bridge_inertia") == pytest.approx(0.53, abs=0.03)
    for study in ("W_z", "U_r", "A_s-from-the-start", "U_d"):
        assert max(STUDIES[study]["importances"], key=STUDIES[study]["importances"].__getitem__) == mass


def test_safe_ranges_are_near_the_published_ones() -> None:
    """A_s below 1.5 g with a carbody below 27 500 kg or pads below 140 MN/m; the deck with E > 31.2 GPa or I > 50 m⁴."""
    carbody = Vehicle().carbody_mass
    ranges = safe("A_s-from-the-start", 14.715)
    assert ranges["carbody_mass_factor"][0][1] * carbody == pytest.approx(27_500.0, rel=0.05)
    assert ranges["pad_stiffness"][0][1] == pytest.approx(140e6, rel=0.02)
    assert set(ranges) == {"carbody_mass_factor", "pad_stiffness"}
    deck = safe("U_d", 1.53e-3)
    assert deck["bridge_modulus"][0][0] == pytest.approx(3.12e10, rel=0.01)
    assert deck["bridge_inertia"][0][0] == pytest.approx(50.0, rel=0.01)
    assert deck["carbody_mass_factor"][0][1] * carbody == pytest.approx(37_000.0, rel=0.03)
    for study, threshold, status in (("W_z", 1.0, "always beyond"), ("U_d", 0.058, "never reached")):
        (found,) = [t for t in STUDIES[study]["thresholds"] if t["value"] == threshold]
        assert found["status"] == status


def test_polynomial_and_process_are_as_good_as_published_or_better() -> None:
    """But for the acceleration of the passage alone, which is another quantity than the published one."""
    from examples.ttb_sensitivity.comparison import PUBLISHED

    for study in ("W_z", "U_r", "A_s-from-the-start"):
        name = study.split("-", maxsplit=1)[0]
        for surrogate in ("pce", "kriging", "pck"):
            found = RECORD["surrogates"][f"{study} {surrogate}"]["generalisation"]
            assert found < PUBLISHED[name][surrogate][1], (study, surrogate)


def test_recorded_extremes_are_those_of_the_model() -> None:
    """The largest values of the record, simulated again."""
    for label, sections in (("U_r", {}), ("A_s-from-the-start", {"track": {"sleeper_range": "all"}})):
        study = STUDIES[label]
        confirmed = study["confirmed"]["maximum"]
        problem = railsearch.problem("train-track-bridge", objectives=[study["name"]], sections=sections)
        design = np.array([confirmed["point"][name] for name in problem.space.names])
        assert -problem.simulate(design).objectives[0] == pytest.approx(confirmed["model"], rel=1e-6)
        assert confirmed["surrogate"] == pytest.approx(confirmed["model"], rel=0.01)


def test_the_command_makes_a_record_and_goes_on(
    study: Callable[..., dict[str, Any]], tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from examples.ttb_sensitivity import __main__ as command

    words = ("--samples", 20, "--points", 3, "--surrogates", "pce")
    # Drawing takes most of the time, and is the same for every study.
    pictures, report, figures = command.write_pictures, command.write_sensitivity_report, command.sensitivity_figures
    undrawn = dict.fromkeys(command.SHOWN)
    monkeypatch.setattr(
        command, "sensitivity_figures", lambda criterion: figures(criterion) if criterion["name"] == "U_d" else undrawn
    )
    monkeypatch.setattr(
        command, "write_pictures", lambda out, drawn: pictures(out, {n: drawn[n] for n in drawn if "U_d" in n})
    )
    monkeypatch.setattr(
        command, "write_sensitivity_report", lambda out, *rest: report(out, *rest) if out.stem == "U_d" else None
    )
    record = study(command.main, tmp_path, *words)
    assert set(record["studies"]) == set(STUDIES)
    assert set(record["surrogates"]) == {f"{label} pce" for label in STUDIES}
    for found in record["studies"].values():
        assert sum(found["importances"].values()) == pytest.approx(1.0)
        assert len(found["factors"]) == 16
    # Under the parked train, set in motion at once, sleepers feel more than any does in the passage.
    starts, passing = (record["studies"][f"A_s-{name}"]["samples"] for name in ("from-the-start", "pass-by"))
    assert starts["minimum"] > passing["minimum"]
    assert starts["maximum"] > 1.5 * passing["maximum"]
    assert (tmp_path / "U_d-thresholds.png").exists()
    assert "Sensitivity of train-track-bridge" in (tmp_path / "U_d.html").read_text(encoding="utf-8")
    capsys.readouterr()
    monkeypatch.setattr(command, "sensitivity_figures", lambda criterion: undrawn)
    for name in ("write_pictures", "write_sensitivity_report"):
        monkeypatch.setattr(command, name, lambda *_: None)
    assert study(command.main, tmp_path, *words) == record
    printed = capsys.readouterr()
    assert printed.err.count("nothing is evaluated") == 2
    assert "surrogate" not in printed.out
