"""What an imported track refuses, each with the field or file, the value and the remedy; and what it reads."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
import scipy.sparse
from imported_tracks import beam_export, changed, written

from railsearch.errors import InputError
from railsearch.interfaces import TrackExport
from railsearch_plugins.single_wheel import Irregularity
from railsearch_plugins.track_models.imported_track import ImportedTrack, ImportedTrackParameters
from railsearch_plugins.track_models.imported_track.checks import UnitWarning
from railsearch_plugins.track_models.imported_track.files import place_of, read_matrix
from railsearch_plugins.track_models.imported_track.parameters import Files, Passage, Rail, Windows

SMALL = beam_export(10.0, 40)


def with_matrix(kind, matrix):
    return replace(SMALL, matrices=dict(SMALL.matrices) | {kind: matrix})


def with_table(name, row, column, value):
    table = getattr(SMALL, name).copy()
    table[row, column] = value
    return replace(SMALL, **{name: table})


M, C, K = (SMALL.matrices[kind] for kind in ("mass", "damping", "stiffness"))
DAMPER = scipy.sparse.coo_array(([-5e3], ([3], [3])), shape=M.shape).tocsr()

FAULTS = {
    "another size": (with_matrix("mass", M[:80, :80]), "as many rows as the stiffness matrix has.* 82 .* received 80"),
    "not square": (with_matrix("damping", C[:, :80]), "a square matrix is needed, received shape"),
    "not symmetric": (with_matrix("stiffness", changed(K, r2_c4=1e7)), "symmetric matrix is needed.* in row 2, column 4"),
    "one triangle": (with_matrix("stiffness", scipy.sparse.tril(K).tocsr()), "only one triangle is there"),
    "not finite": (
        with_matrix("stiffness", changed(K, r5_c5=np.nan)),
        "finite entries are needed, received nan in row 5, column 5",
    ),
    "complex": (with_matrix("stiffness", K * (1.0 + 0.05j)), "a real matrix is needed"),
    "negative mass": (
        with_matrix("mass", changed(M, r6_c6=-1.0)),
        "positive semi-definite.* unknown 6 .* its diagonal is -1",
    ),
    "negative damper": (with_matrix("damping", DAMPER), "damping.* positive semi-definite.* unknown 3 "),
    "spring that pushes": (
        with_matrix("stiffness", K - 3e7 / 54.0 * M),
        "stiffness.* positive semi-definite.* negative energy",
    ),
    "coupling without diagonal": (
        with_matrix("damping", changed(0.0 * C, r3_c4=1.0, r4_c3=1.0)),
        "positive semi-definite.* its diagonal is 0",
    ),
    "rail not sorted": (with_table("rail", 3, 0, 0.1), "rail nodes must ascend, received 0.1 m after 0.5 m in row 4"),
    "rail node twice": (with_table("rail", 3, 0, 0.5), "rail nodes must ascend, received 0.5 m again in row 4"),
    "rail unknown too large": (with_table("rail", 3, 1, 82.0), "0 to 81, or −1 where it is held, received 82 at 0.75 m"),
    "rail unknown twice": (with_table("rail", 3, 2, 6.0), "every unknown belongs to one rail node, received 6 twice"),
    "rail position missing": (with_table("rail", 3, 0, np.nan), "finite positions of rail nodes are needed"),
    "support unknown": (with_table("supports", 1, 1, 400.0), "supports.csv: a unknown|received 400"),
    "support held": (with_table("supports", 1, 1, -1.0), "a support moves, received a held unknown at 4 m"),
    "support damping": (with_table("supports", 1, 2, -3.0), "a damping ≥ 0 N s/m is needed, received -3 at 4 m"),
    "supports not sorted": (with_table("supports", 1, 0, 1.0), "positions of supports must ascend, received 1 m after 2 m"),
    "one support": (replace(SMALL, supports=SMALL.supports[:1]), "two or more supports are needed, received 1"),
    "one rail node": (replace(SMALL, rail=SMALL.rail[:1]), "two or more rail nodes are needed, received 1"),
    "rotations reversed": (
        with_matrix("stiffness", K.multiply(np.outer(s := np.tile([1.0, -1.0], 41), s)).tocsr()),
        "rail.rotation: .* other sense.* use 'minus slope'",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_unsound_matrices_and_tables_are_refused(tmp_path, fault):
    export, words = FAULTS[fault]
    with pytest.raises(InputError, match=words):
        ImportedTrack().check(written(tmp_path / "track", export))


FIELDS = {
    "run beyond the rail": (
        {"passage": Passage(end=12.0)},
        r"must cover the run, from 0 to 10 m, received a run from 0 to 12 m",
    ),
    "run backwards": ({"passage": Passage(start=8.0, end=3.0)}, "received a run from 8 to 3 m"),
    "one step": ({"passage": Passage(time_step=0.5)}, "must take 2 to 1e.06 steps"),
    "force window": ({"windows": Windows(force_to=11.0)}, "force window must lie in the run"),
    "energy window": (
        {"windows": Windows(energy_from=4.5, energy_to=6.5)},
        "two or more supports must be measured, received 1",
    ),
    "short profile": ({"irregularity": Irregularity((0.0, 5.0), (0.0, 0.0))}, "cover the run from 0 to 10 m"),
    "unsorted profile": ({"irregularity": Irregularity((0.0, 5.0, 4.0, 11.0), (0.0,) * 4)}, "positions must ascend"),
    "unknown interpolation": ({"rail": Rail("quintic")}, "'auto' or 'hermite'"),
    "no such file": ({"files": Files(mass="nowhere.mtx")}, "nowhere.mtx: cannot be read"),
    "no such kind": ({"files": Files(mass=__file__)}, "a file .mtx, .mat or .npz is needed, received '.py'"),
}


@pytest.mark.parametrize("fault", FIELDS)
def test_unsound_parameters_are_refused(tmp_path, fault):
    changes, words = FIELDS[fault]
    with pytest.raises(InputError, match=words):
        ImportedTrack().check(replace(written(tmp_path / "track", SMALL), **changes))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0.75,6.5,7", "received 6.5 at 0.75 m"),
        ("0.75,six,7", "rows of as many numbers"),
        ("0.75,6", "rows of as many numbers"),
    ],
)
def test_a_table_with_a_line_that_is_wrong_is_refused(tmp_path, line, words):
    track = written(tmp_path / "track", SMALL)
    table = tmp_path / "track" / "rail.csv"
    table.write_text(table.read_text().replace("0.75,6,7", line))
    with pytest.raises(InputError, match=words):
        ImportedTrack().check(track)


def test_a_table_may_have_a_line_of_words_and_blanks(tmp_path):
    track = written(tmp_path / "track", SMALL)
    table = tmp_path / "track" / "rail.csv"
    rows = table.read_text().splitlines()[1:]
    expected = ImportedTrack().simulate(track).metrics
    table.write_text("x;vertical;rotation\n" + "\n".join(row.replace(",", ";") for row in rows))
    assert ImportedTrack().simulate(track).metrics == expected
    table.write_text("\n".join(row.replace(",", "  ") for row in rows))
    assert ImportedTrack().simulate(track).metrics == expected


def test_hermite_needs_rotations(tmp_path):
    track = replace(written(tmp_path / "track", replace(SMALL, rail=np.column_stack([SMALL.rail[:, :2], np.full(41, -1)]))))
    assert ImportedTrack().simulate(track).metrics["F_rms"] > 0.0
    with pytest.raises(InputError, match="'hermite' needs a column of rotations"):
        ImportedTrack().check(replace(track, rail=Rail("hermite")))


def test_a_track_that_floats_cannot_carry_the_wheel(tmp_path):
    floating = beam_export(10.0, 40)
    bending = floating.matrices["stiffness"] - 27e6 / 54.0 * floating.matrices["mass"]
    track = written(tmp_path / "track", replace(floating, matrices=dict(floating.matrices) | {"stiffness": bending}))
    with pytest.raises(InputError, match="static equilibrium under the wheel"):
        ImportedTrack().simulate(track)


def test_a_factor_that_makes_the_track_unstable_is_refused(tmp_path):
    export = replace(SMALL, parts={"foundation": {"stiffness": K}}, factors={"foundation": 1.0})
    track = written(tmp_path / "track", export)
    for factor, words in ((-2.0, "positive definite"), (float("nan"), "a finite number is needed")):
        with pytest.raises(InputError, match=words):
            ImportedTrack().simulate(replace(track, factors={"foundation": factor}))
    with pytest.raises(InputError, match="unknown part 'base'; there are foundation"):
        replace(track, factors={"base": 1.0})


def test_a_factor_that_takes_the_mass_away_is_refused(tmp_path):
    track = written(tmp_path / "track", replace(SMALL, parts={"rail": {"mass": M}}, factors={"rail": 1.0}))
    with pytest.raises(InputError, match=r"4 M/dt² \+ 2 C/dt \+ K with all parts must be positive definite.* unknown \d+ "):
        ImportedTrack().simulate(replace(track, factors={"rail": -2.0}))


def test_a_part_without_a_file_is_refused():
    with pytest.raises(InputError, match=r"parts.pad: a file of mass, damping or stiffness is needed"):
        ImportedTrackParameters(parts={"pad": {}})


def test_a_sound_track_is_not_warned_of(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ImportedTrack().check(written(tmp_path / "track", SMALL))


@pytest.mark.parametrize(
    ("export", "words"),
    [
        (replace(SMALL, matrices={k: 1e-3 * m for k, m in SMALL.matrices.items()}), "a deflection under the wheel of 1"),
        (
            replace(SMALL, matrices=dict(SMALL.matrices) | {"mass": 1e6 * M}),
            "a frequency of the track under the wheel of 0.",
        ),
        (
            replace(SMALL, rail=SMALL.rail * [1e3, 1.0, 1.0], supports=SMALL.supports * [1e3, 1.0, 1.0]),
            "rail nodes up to 250 m",
        ),
    ],
    ids=["N/mm and t", "mg", "mm"],
)
def test_units_that_are_mixed_are_warned_of_once(tmp_path, export, words):
    model, track = ImportedTrack(), written(tmp_path / "track", export)
    with pytest.warns(UnitWarning, match=words):
        model.check(track)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.check(track)


def matlab(path, **arrays):
    scipy.io.savemat(path, arrays)
    return str(path)


def test_one_matlab_file_with_unknowns_from_1(tmp_path):
    expected = ImportedTrack().simulate(written(tmp_path / "track", SMALL)).metrics
    rail, supports = SMALL.rail + np.array([0.0, 1.0, 1.0]), SMALL.supports + np.array([0.0, 1.0, 0.0])
    file = matlab(tmp_path / "t.mat", M=M.tocsc(), C=C.tocsc(), K=K.toarray(), rail=rail, supports=supports)
    names = {field: f"{file}#{name}" for field, name in (("mass", "M"), ("damping", "C"), ("stiffness", "K"))}
    files = Files(**names, rail=f"{file}#rail", supports=f"{file}#supports", first_unknown=1)
    assert ImportedTrack().simulate(ImportedTrackParameters(files=files)).metrics == pytest.approx(expected, rel=1e-9)
    with pytest.raises(InputError, match=r"received 82 at 10 m; files.first_unknown is 0|0 to 81"):
        ImportedTrack().check(ImportedTrackParameters(files=replace(files, first_unknown=0)))


@pytest.mark.parametrize("kind", ["csr", "csc", "coo"])
def test_matrices_of_scipy_and_dense_ones_of_numpy(tmp_path, kind):
    half = scipy.sparse.triu(K)
    scipy.sparse.save_npz(tmp_path / "one.npz", half.asformat(kind))
    np.savez(tmp_path / "two.npz", K=K.toarray(), M=M.toarray())
    np.testing.assert_array_equal(read_matrix(place_of(str(tmp_path / "one.npz")), "stiffness").toarray(), half.toarray())
    np.testing.assert_array_equal(read_matrix(place_of(str(tmp_path / "two.npz#K")), "stiffness").toarray(), K.toarray())
    with pytest.raises(InputError, match=r"no array 'stiffness'; the file has K, M, name one as two.npz#NAME"):
        read_matrix(place_of(str(tmp_path / "two.npz")), "stiffness")


@pytest.mark.parametrize("name", ["a.mtx", "a.mat", "a.npz"])
def test_what_is_no_such_file_is_refused(tmp_path, name):
    (tmp_path / name).write_text("not a matrix\n")
    with pytest.raises(InputError, match=rf"{name}: cannot be read as"):
        read_matrix(place_of(str(tmp_path / name)), "mass")


def test_a_file_that_changes_is_read_again(tmp_path):
    track = written(tmp_path / "track", SMALL, "mtx")
    before = ImportedTrack().simulate(track).metrics["F_max"]
    scipy.io.mmwrite(tmp_path / "track" / "stiffness.mtx", (0.5 * K).tocoo(), symmetry="symmetric", precision=17)
    assert ImportedTrack().simulate(track).metrics["F_max"] != pytest.approx(before, rel=1e-3)


def test_an_export_is_what_was_exported(tmp_path):
    assert isinstance(SMALL, TrackExport)
    for kind in ("npz", "mtx"):
        files = written(tmp_path / kind, SMALL, kind).files
        for name in ("mass", "damping", "stiffness"):
            read = read_matrix(place_of(getattr(files, name)), name)
            assert abs(read - SMALL.matrices[name]).max() == 0.0
