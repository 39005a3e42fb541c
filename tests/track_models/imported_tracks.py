"""Tracks that the tests of the imported track write: a beam on a continuous foundation, and changes of what was written."""

import numpy as np
import scipy.sparse

from railsearch.interfaces import TrackExport
from railsearch.parameters import amend_parameters
from railsearch.site import track_section
from railsearch.track_files import write_track
from railsearch_plugins.track_models.imported_track import ImportedTrackParameters

EI, FOUNDATION, MASS, DAMPING = 4.9e6, 27e6, 54.0, 2e4


def beam_matrices(length, count, foundation=FOUNDATION, damping=0.0):
    """M, C, K of a beam with all ends free on a Winkler layer, by element matrices as textbooks print them."""
    l = length / count  # noqa: E741
    l2 = l**2
    bending = [
        [12, 6 * l, -12, 6 * l],
        [6 * l, 4 * l2, -6 * l, 2 * l2],
        [-12, -6 * l, 12, -6 * l],
        [6 * l, 2 * l2, -6 * l, 4 * l2],
    ]
    gram = [
        [156, 22 * l, 54, -13 * l],
        [22 * l, 4 * l2, 13 * l, -3 * l2],
        [54, 13 * l, 156, -22 * l],
        [-13 * l, -3 * l2, -22 * l, 4 * l2],
    ]
    bending, gram = EI / l**3 * np.array(bending), l / 420 * np.array(gram)
    element = {"mass": MASS * gram, "damping": damping * gram, "stiffness": bending + foundation * gram}
    size = 2 * (count + 1)
    matrices = {}
    for kind, own in element.items():
        total = scipy.sparse.lil_array((size, size))
        for e in range(count):
            total[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += own
        matrices[kind] = total.tocsr()
    return matrices


def beam_export(length=40.0, count=160, damping=DAMPING, settings=None, **parts):
    """A beam on a Winkler layer with supports on every eighth node."""
    nodes = np.linspace(0.0, length, count + 1)
    rail = np.column_stack([nodes, 2 * np.arange(count + 1), 2 * np.arange(count + 1) + 1])
    places = np.arange(8, count, 8)
    supports = np.column_stack([nodes[places], 2 * places, np.full(places.size, 1e3)])
    return TrackExport(beam_matrices(length, count, damping=damping), rail, supports, settings or {}, **parts)


def written(folder, export, kind="npz"):
    """The parameters of an export that was written to a new folder."""
    write_track(folder, export, kind)
    return read(folder / "site.toml")


def read(site):
    """The track parameters of a site file."""
    return amend_parameters(ImportedTrackParameters(), track_section(site), str(site))


def changed(matrix, **entries):
    """A matrix with some entries changed, `r3_c4=value`."""
    made = matrix.tolil(copy=True)
    for place, value in entries.items():
        row, column = (int(part[1:]) for part in place.split("_"))
        made[row, column] = value
    return made.tocsr()
