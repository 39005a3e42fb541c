"""What the study found, as one plain document and as tables in Markdown."""

import numpy as np

from examples.published_sensitivity.cases import PUBLISHED, SURROGATES
from examples.studies import table

FORMAT = "railsearch published sensitivity study 1"
TOP = "maximum"


def make_record(cases, exact, grids, surrogates):
    """True importances, those on every grid, and those on the surrogates with how far they are from the true ones."""
    places = [(name, surrogate, size) for name, case in cases.items() for surrogate in SURROGATES for size in case.sizes]
    chosen = {place: [found for key, found in surrogates.items() if key[:3] == place] for place in places}
    return {
        "format": FORMAT,
        "published": PUBLISHED,
        "exact": exact,
        "grids": [_grid(key, found) for key, found in grids.items()],
        "surrogates": [_spread(place, found, exact[place[0]]) for place, found in chosen.items() if found],
        "camel_values": {name: grid.tolist() for name, grid in zip(*_named_grids(cases["camel"]), strict=True)},
    }


def study_tables(record):
    """The tables of the README."""
    return "\n".join(
        (
            "## Importances of the truss\n",
            _importances(record),
            "## Surrogates\n",
            _surrogates(record),
            "## Grids\n",
            _grids(record),
        )
    )


def _named_grids(case):
    factors = case.factors()
    return factors.names, factors.grids


def _grid(key, found):
    spacing, points = key.split()
    weighted, plain = found["importances"][TOP], found["unweighted"][TOP]
    return {"spacing": spacing, "points": int(points), "importances": weighted, "unweighted": plain}


def _spread(place, found, exact):
    """All designs of one size: importances by input (designs,), errors, times, and the curves of the first design."""
    name, surrogate, size = place
    return {
        "case": name,
        "surrogate": surrogate,
        "samples": size,
        "importances": {
            sense: {factor: [cell["importances"][sense][factor] for cell in found] for factor in true}
            for sense, true in exact["importances"].items()
        },
        "largest_error": [_largest_error(cell, exact) for cell in found],
        "largest_curve_error": [_curve_error(cell, exact) for cell in found],
        **{key: [cell[key] for cell in found] for key in ("generalisation", "fit_seconds", "search_seconds", "held")},
        "curves": found[0]["curves"] if name == "camel" else None,
    }


def _largest_error(cell, exact):
    """Of an importance, over all inputs and both extremes."""
    return max(
        abs(cell["importances"][sense][factor] - share)
        for sense, shares in exact["importances"].items()
        for factor, share in shares.items()
    )


def _curve_error(cell, exact):
    """Of an extreme, over all inputs and grid values, as a fraction of what all curves span."""
    pairs = [
        (np.array(cell["curves"][sense][factor]), np.array(curve))
        for sense, curves in exact["curves"].items()
        for factor, curve in curves.items()
    ]
    span = np.ptp(np.concatenate([true for _, true in pairs]))
    return float(max(np.abs(found - true).max() for found, true in pairs) / span)


def _importances(record):
    first = min(entry["samples"] for entry in record["surrogates"])
    true = record["exact"]["truss"]["importances"][TOP]
    fewest = {
        entry["surrogate"]: entry["importances"][TOP]
        for entry in record["surrogates"]
        if entry["case"] == "truss" and entry["samples"] == first
    }
    rows = [
        [name, f"{record['published'][name]:.4f}", f"{true[name]:.4f}", *(_interval(fewest[key][name]) for key in fewest)]
        for name in sorted(true, key=lambda name: -true[name])
    ]
    return table(["input", "published", "finite elements", *(f"{key}, N = {first}" for key in fewest)], rows)


def _interval(values):
    return f"{np.mean(values):.4f} ± {np.std(values, ddof=1) if len(values) > 1 else 0.0:.4f}"


def _surrogates(record):
    header = ["case", "surrogate", "N", "ε_gen", "error of an importance", "of a curve", "fit [s]", "analysis [s]"]
    rows = [
        [
            entry["case"],
            entry["surrogate"],
            entry["samples"],
            *(_median(entry[key]) for key in ("generalisation", "largest_error", "largest_curve_error")),
            *(f"{np.median(entry[key]):.2f}" for key in ("fit_seconds", "search_seconds")),
        ]
        for entry in record["surrogates"]
    ]
    return table(header, rows)


def _median(values):
    return f"{np.median(values):.1e} ({min(values):.0e} to {max(values):.0e})"


def _grids(record):
    names = ("E1", "A1", "P3", "E2")
    rows = [
        [
            entry["spacing"],
            entry["points"],
            *(f"{entry['importances'][name]:.4f}" for name in names),
            *(f"{entry['unweighted'][name]:.4f}" for name in names[:3]),
        ]
        for entry in record["grids"]
    ]
    return table(["grid", "n", *names, *(f"{name}, unweighted" for name in names[:3])], rows)
