"""The compiled kernels: banded factorisation and substitution, product, and the steps of a passage.

Symbols are those of `banded` (B, L, U, D) and `moving_contact` (the rest). All of them are in one file because compiled
code is kept between runs and renewed only when the file of the function that was called has changed.
"""

import numpy as np
from numba import njit

# Rows that are looked at together when a contact column is followed to its end.
BLOCK = 64
# Sub-diagonals of rows that are substituted with the last results held in registers.
NARROW = 4
WIDE = 9
# Entries of q this much smaller than its largest cannot change a sum in double precision.
NEGLIGIBLE = 1e-20


@njit(cache=True, fastmath={"contract"})
def factorise(band):  # type: ignore[no-untyped-def]
    """LDLᵀ of a symmetric positive definite banded matrix; the reciprocal of D in row 0 of the result.

    A pivot that is not positive makes the result NaN from there on.
    """
    width, size = band.shape[0] - 1, band.shape[1]
    lower = np.zeros_like(band)
    pivots = np.zeros(size)
    for i in range(size):
        first = max(0, i - width)
        pivot = band[0, i]
        for j in range(first, i):
            value = band[i - j, i]
            for m in range(max(first, j - width), j):
                value -= lower[i - m, i] * pivots[m] * lower[j - m, j]
            lower[i - j, i] = value / pivots[j]
            pivot -= lower[i - j, i] * value
        pivots[i] = pivot if pivot > 0.0 else np.nan
        lower[0, i] = 1.0 / pivots[i]
    return lower


@njit(cache=True, fastmath={"contract"})
def _narrow_sweep(l1, l2, l3, l4, y1, y2, y3, y4, y):  # type: ignore[no-untyped-def]
    """y[i] −= Σ l_k[i] y[i − k] for NARROW diagonals; y1…y4 are the results before the first row."""
    for i in range(y.size):
        value = y[i] - l4[i] * y4 - l3[i] * y3 - l2[i] * y2 - l1[i] * y1
        y4, y3, y2, y1 = y3, y2, y1, value
        y[i] = value


@njit(cache=True, fastmath={"contract"})
def _wide_sweep(l1, l2, l3, l4, l5, l6, l7, l8, l9, y1, y2, y3, y4, y5, y6, y7, y8, y9, y):  # type: ignore[no-untyped-def]
    """As `_narrow_sweep` for WIDE diagonals."""
    for i in range(y.size):
        value = y[i] - l9[i] * y9 - l8[i] * y8 - l7[i] * y7 - l6[i] * y6 - l5[i] * y5
        value = value - l4[i] * y4 - l3[i] * y3 - l2[i] * y2 - l1[i] * y1
        y9, y8, y7, y6, y5, y4, y3, y2, y1 = y8, y7, y6, y5, y4, y3, y2, y1, value
        y[i] = value


@njit(cache=True, fastmath={"contract"})
def forward_block(lower, width, start, stop, y):  # type: ignore[no-untyped-def]
    """L y = b for rows start…stop; y holds b on entry and the rows before `start` are done."""
    here = lower[:, start:stop]
    if width <= NARROW <= start:
        last = y[start - NARROW : start]
        _narrow_sweep(here[1], here[2], here[3], here[4], last[3], last[2], last[1], last[0], y[start:stop])
    elif width <= WIDE <= start:
        last = y[start - WIDE : start]
        _wide_sweep(
            here[1], here[2], here[3], here[4], here[5], here[6], here[7], here[8], here[9],
            last[8], last[7], last[6], last[5], last[4], last[3], last[2], last[1], last[0], y[start:stop],
        )  # fmt: skip
    else:
        for i in range(start, stop):
            for k in range(min(width, i), 0, -1):
                y[i] -= lower[k, i] * y[i - k]


@njit(cache=True, fastmath={"contract"})
def forward(lower, runs, y):  # type: ignore[no-untyped-def]
    """L y = b in place, over the `runs` of its rows."""
    for r in range(runs.shape[0]):
        forward_block(lower, runs[r, 2], runs[r, 0], runs[r, 1], y)


@njit(cache=True, fastmath={"contract"})
def backward(upper, runs, x):  # type: ignore[no-untyped-def]
    """Lᵀ x = D⁻¹ y in place, over the `runs` of U: seen from the far end it is a forward substitution."""
    for i in range(x.size):
        x[i] *= upper[0, i]
    forward(upper, runs, x[::-1])


@njit(cache=True, fastmath={"contract"})
def add_products(first, second, starts, stops, x, z, y):  # type: ignore[no-untyped-def]
    """y += A x + B z for two symmetric banded matrices that share the `diagonal_ranges` of their sum."""
    for k in range(first.shape[0]):
        start, stop = starts[k], stops[k]
        a, b = first[k, start:stop], second[k, start:stop]
        x_here, z_here, y_here = x[start:stop], z[start:stop], y[start:stop]
        x_near, z_near, y_near = x[start - k : stop - k], z[start - k : stop - k], y[start - k : stop - k]
        for i in range(stop - start):
            y_here[i] += a[i] * x_near[i] + b[i] * z_near[i]
        if k > 0:
            for i in range(stop - start):
                y_near[i] += a[i] * x_here[i] + b[i] * z_here[i]


@njit(cache=True, fastmath={"contract"})
def _contact_column(lower, widths, unknowns, row, q):  # type: ignore[no-untyped-def]
    """q = L⁻¹ Nᵀ from the first block that the contact touches to where it has decayed; returns that range."""
    first, last = q.size, 0
    for k in range(unknowns.size):
        if unknowns[k] >= 0:
            first, last = min(first, unknowns[k]), max(last, unknowns[k])
    start = first // BLOCK * BLOCK
    stop, largest = start, 0.0
    q[max(0, start - lower.shape[0]) : start] = 0.0
    while stop < q.size:
        begin, stop = stop, min(stop + BLOCK, q.size)
        q[begin:stop] = 0.0
        for k in range(unknowns.size):
            if begin <= unknowns[k] < stop:
                q[unknowns[k]] = row[k]
        forward_block(lower, widths[begin // BLOCK], begin, stop, q)
        size = np.max(np.abs(q[begin:stop]))
        largest = max(largest, size)
        if begin > last and size <= NEGLIGIBLE * largest:
            break
    return start, stop


@njit(cache=True, fastmath={"contract"})
def _seen(unknowns, row, u):  # type: ignore[no-untyped-def]
    """N u: rail displacement under the wheel."""
    total = 0.0
    for k in range(unknowns.size):
        if unknowns[k] >= 0:
            total += row[k] * u[unknowns[k]]
    return total


@njit(cache=True, fastmath={"contract"})
def _known_load(track, u, v, unknowns, row, force, y):  # type: ignore[no-untyped-def]
    """y = (2/dt) M v_n − K u_n + f_n/2."""
    y[:] = 0.0
    add_products(track.scaled_mass, track.minus_stiffness, track.starts, track.stops, v, u, y)
    for k in range(unknowns.size):
        if unknowns[k] >= 0:
            y[unknowns[k]] += 0.5 * force * row[k]


@njit(cache=True, fastmath={"contract"})
def _vehicle_without_force(vehicle, z, zv, force, half):  # type: ignore[no-untyped-def]
    """half = A_v⁻¹ ((2/dt) M_v ż_n − K_v z_n + e_w (P − F_n/2)): half the increment with F_{n+1} = 0."""
    parts = half.size
    half[:] = 0.0
    for i in range(parts):
        load = vehicle.static_load - 0.5 * force if i == parts - 1 else 0.0
        for j in range(parts):
            load += vehicle.scaled_mass[i, j] * zv[j] - vehicle.stiffness[i, j] * z[j]
        for j in range(parts):
            half[j] += vehicle.compliance[j, i] * load


@njit(cache=True, fastmath={"contract"})
def _vehicle_with_force(vehicle, force, rate, half, z, zv, new_z, new_zv):  # type: ignore[no-untyped-def]
    """Add −A_v⁻¹ e_w F_{n+1}/2 to half the increment, and advance as the track."""
    for j in range(half.size):
        w = half[j] - 0.5 * force * vehicle.compliance[j, -1]
        new_z[j] = z[j] + 2.0 * w
        new_zv[j] = rate * w - zv[j]


@njit(cache=True, fastmath={"contract"})
def _advance(w, rate, u, v):  # type: ignore[no-untyped-def]
    """u += 2 w and v = 4 w/dt − v, with rate = 4/dt."""
    for i in range(w.size):
        u[i] += 2.0 * w[i]
        v[i] = rate * w[i] - v[i]


@njit(cache=True, fastmath={"contract"})
def _add_squares(share, v, supports, integrals):  # type: ignore[no-untyped-def]
    """One term of the trapezoidal rule for ∫ v² dt."""
    for s in range(supports.size):
        integrals[s] += share * v[supports[s]] ** 2


@njit(cache=True, fastmath={"contract"})
def _contact_force(lower, q, y, start, stop, gap, wheel_compliance, stiffness):  # type: ignore[no-untyped-def]
    """F_{n+1} from the contact column; `gap` = z⁰_w − N u_n − r is what would be compressed without any force."""
    approach, yielding = 0.0, 0.0
    for i in range(start, stop):
        weighted = q[i] * lower[0, i]
        approach += weighted * y[i]
        yielding += weighted * q[i]
    return stiffness * (gap - 2.0 * approach) / (1.0 + stiffness * (wheel_compliance + yielding))


@njit(cache=True, fastmath={"contract"})
def integrate(track, vehicle, contact, supports, time_step, states):  # type: ignore[no-untyped-def]
    """All steps of a passage; returns the fields of `Passage`."""
    steps, size, parts = contact.irregularity.size, track.lower.shape[1], vehicle.compliance.shape[0]
    unknowns, rows, rate = contact.unknowns, contact.rows, 4.0 / time_step
    force, rail = np.empty(steps), np.zeros(steps)
    z, zv, half = np.empty((steps, parts)), np.zeros((steps, parts)), np.empty(parts)
    u, v, y, q = np.zeros(size), np.zeros(size), np.empty(size), np.zeros(size)
    integrals = np.zeros(supports.size)
    all_u, all_v = np.zeros((steps if states else 0, size)), np.zeros((steps if states else 0, size))
    force[0] = vehicle.static_load
    z[0] = vehicle.static_load / vehicle.contact_stiffness + contact.irregularity[0]
    for n in range(1, steps):
        _known_load(track, u, v, unknowns[n - 1], rows[n - 1], force[n - 1], y)
        forward(track.lower, track.lower_runs, y)
        start, stop = _contact_column(track.lower, track.block_widths, unknowns[n], rows[n], q)
        _vehicle_without_force(vehicle, z[n - 1], zv[n - 1], force[n - 1], half)
        gap = z[n - 1, -1] + 2.0 * half[-1] - _seen(unknowns[n], rows[n], u) - contact.irregularity[n]
        force[n] = _contact_force(track.lower, q, y, start, stop, gap, vehicle.compliance[-1, -1], vehicle.contact_stiffness)
        _vehicle_with_force(vehicle, force[n], rate, half, z[n - 1], zv[n - 1], z[n], zv[n])
        for i in range(start, stop):
            y[i] += 0.5 * force[n] * q[i]
        backward(track.upper, track.upper_runs, y)
        _advance(y, rate, u, v)
        rail[n] = _seen(unknowns[n], rows[n], u)
        _add_squares(0.5 * time_step if n == steps - 1 else time_step, v, supports, integrals)
        if states:
            all_u[n], all_v[n] = u, v
    return force, rail, z[:, -1].copy(), z, zv, integrals, all_u, all_v
