"""The compiled kernels: banded factorisation and substitution, product, and the steps of a passage.

Symbols are those of `banded` (B, L, U, D) and `moving_contact` (the rest). All of them are in one file because compiled
code is kept between runs and renewed only when the file of the function that was called has changed. Arrays are copied by
loops: numba compiles the check of an assignment to a slice, with its message, for seconds.
"""

import numpy as np
from numba import njit

# Rows whose sub-diagonals are counted together.
BLOCK = 64
# Sub-diagonals of rows that are substituted with the last results held in registers.
NARROW = 4
MIDDLE = 6
WIDE = 9
# Columns of the inverse that are computed together.
LANES = 16
# Rows that are looked at together when a column of the inverse is cut off.
STRETCH = 32


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
def _middle_sweep(l1, l2, l3, l4, l5, l6, y1, y2, y3, y4, y5, y6, y):  # type: ignore[no-untyped-def]
    """As `_narrow_sweep` for MIDDLE diagonals."""
    for i in range(y.size):
        value = y[i] - l6[i] * y6 - l5[i] * y5 - l4[i] * y4 - l3[i] * y3
        value = value - l2[i] * y2 - l1[i] * y1
        y6, y5, y4, y3, y2, y1 = y5, y4, y3, y2, y1, value
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
    elif width <= MIDDLE <= start:
        last = y[start - MIDDLE : start]
        _middle_sweep(
            here[1], here[2], here[3], here[4], here[5], here[6],
            last[5], last[4], last[3], last[2], last[1], last[0], y[start:stop],
        )  # fmt: skip
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
def _wide_product(c, width, x, h, y):  # type: ignore[no-untyped-def]
    """y = s y + d h + B x for the rows of a block; x starts `width` rows before them.

    c: s, d, the main diagonal of B, and what is 1, 2, … `width` to its left and right; BLOCK values of each in turn.
    """
    for lane in range(y.size):
        y[lane] = c[lane] * y[lane] + c[BLOCK + lane] * h[lane] + c[2 * BLOCK + lane] * x[width + lane]
    for k in range(1, width + 1):
        left, right = c[(2 * k + 1) * BLOCK : (2 * k + 2) * BLOCK], c[(2 * k + 2) * BLOCK : (2 * k + 3) * BLOCK]
        before, after = x[width - k : width - k + y.size], x[width + k : width + k + y.size]
        for lane in range(y.size):
            y[lane] += left[lane] * before[lane] + right[lane] * after[lane]


@njit(cache=True, fastmath={"contract"})
def _narrow_product(c, x, h, y):  # type: ignore[no-untyped-def]
    """As `_wide_product` for NARROW diagonals on either side."""
    for lane in range(y.size):
        # Sums of their own, so that one need not wait for the other.
        y[lane] = (
            (c[lane] * y[lane] + c[BLOCK + lane] * h[lane] + c[2 * BLOCK + lane] * x[lane + 4])
            + (c[3 * BLOCK + lane] * x[lane + 3] + c[4 * BLOCK + lane] * x[lane + 5] + c[5 * BLOCK + lane] * x[lane + 2])
            + (c[6 * BLOCK + lane] * x[lane + 6] + c[7 * BLOCK + lane] * x[lane + 1] + c[8 * BLOCK + lane] * x[lane + 7])
            + (c[9 * BLOCK + lane] * x[lane] + c[10 * BLOCK + lane] * x[lane + 8])
        )


@njit(cache=True, fastmath={"contract"})
def _middle_product(c, x, h, y):  # type: ignore[no-untyped-def]
    """As `_wide_product` for MIDDLE diagonals on either side."""
    for lane in range(y.size):
        # Sums of their own, so that one need not wait for the other.
        y[lane] = (
            (c[lane] * y[lane] + c[BLOCK + lane] * h[lane] + c[2 * BLOCK + lane] * x[lane + 6])
            + (c[3 * BLOCK + lane] * x[lane + 5] + c[4 * BLOCK + lane] * x[lane + 7] + c[5 * BLOCK + lane] * x[lane + 4])
            + (c[6 * BLOCK + lane] * x[lane + 8] + c[7 * BLOCK + lane] * x[lane + 3] + c[8 * BLOCK + lane] * x[lane + 9])
            + (c[9 * BLOCK + lane] * x[lane + 2] + c[10 * BLOCK + lane] * x[lane + 10] + c[11 * BLOCK + lane] * x[lane + 1])
            + (c[12 * BLOCK + lane] * x[lane + 11] + c[13 * BLOCK + lane] * x[lane] + c[14 * BLOCK + lane] * x[lane + 12])
        )


@njit(cache=True, fastmath={"contract"})
def next_known(recursion, x, h, y):  # type: ignore[no-untyped-def]
    """y = s y + D h + B x of a `Recursion`; x has as many zeros before and after it as B has diagonals on a side."""
    most = (recursion.blocks.shape[1] // BLOCK - 3) // 2
    for b in range(recursion.widths.size):
        start, width = b * BLOCK, recursion.widths[b]
        stop = min(start + BLOCK, y.size)
        near = x[start + most - width : stop + most + width]
        if width == NARROW:
            _narrow_product(recursion.blocks[b], near, h[start:stop], y[start:stop])
        elif width == MIDDLE:
            _middle_product(recursion.blocks[b], near, h[start:stop], y[start:stop])
        else:
            _wide_product(recursion.blocks[b], width, near, h[start:stop], y[start:stop])
    for p in range(recursion.pairs.shape[0]):
        i, j = recursion.pairs[p, 0], recursion.pairs[p, 1]
        y[i] += recursion.couplings[p, 0] * h[j]
        y[j] += recursion.couplings[p, 1] * h[i]


@njit(cache=True, fastmath={"contract"})
def _forward_panel(lower, widths, unknowns, negligible, x):  # type: ignore[no-untyped-def]
    """Columns D⁻¹ L⁻¹ e_k (n, LANES) of some neighbouring unknowns k down to where they have decayed; one past that row."""
    start, largest = unknowns[0], 0.0
    x[max(0, start - lower.shape[0]) : start] = 0.0
    stop = start
    while stop < x.shape[0]:
        begin, stop, block = stop, min(stop + STRETCH, x.shape[0]), 0.0
        x[begin:stop] = 0.0
        for c in range(unknowns.size):
            if begin <= unknowns[c] < stop:
                x[unknowns[c], c] = 1.0
        for i in range(begin, stop):
            for k in range(1, min(widths[i // BLOCK], i) + 1):
                for lane in range(LANES):
                    x[i, lane] -= lower[k, i] * x[i - k, lane]
        for i in range(begin, stop):
            for lane in range(LANES):
                block = max(block, abs(x[i, lane]))
        largest = max(largest, block)
        if begin > unknowns[-1] and block <= negligible * largest:
            break
    for i in range(start, stop):
        for lane in range(LANES):
            x[i, lane] *= lower[0, i]
    return stop


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def _backward_panel(lower, widths, first, stop, negligible, x):  # type: ignore[no-untyped-def]
    """Columns A⁻¹ e_k of `_forward_panel`'s up to where they have decayed above the `first` unknown; that row."""
    start, largest = stop, 0.0
    while start > 0:
        end, start, block = start, max(start - STRETCH, 0), 0.0
        x[start : min(end, first)] = 0.0
        width = max(widths[start // BLOCK], widths[min(end, stop - 1) // BLOCK])
        for i in range(end - 1, start - 1, -1):
            for k in range(1, min(width, stop - 1 - i) + 1):
                for lane in range(LANES):
                    x[i, lane] -= lower[k, i + k] * x[i + k, lane]
        for i in range(start, end):
            for lane in range(LANES):
                block = max(block, abs(x[i, lane] / lower[0, i]))
        largest = max(largest, block)
        if start < first and block <= negligible * largest:
            break
    return start


@njit(cache=True)
def _copy(source, target):  # type: ignore[no-untyped-def]
    """The source into the first places of the target."""
    for i in range(source.size):
        target[i] = source[i]


@njit(cache=True)
def doubled(values):  # type: ignore[no-untyped-def]
    """The values with as much room again behind them."""
    longer = np.empty(2 * values.size)
    _copy(values, longer)
    return longer


@njit(cache=True)
def inverse_columns(lower, widths, unknowns, negligible):  # type: ignore[no-untyped-def]
    """Columns A⁻¹ e_k of some unknowns k (r,), ascending, cut off where the forces D Lᵀ x of a stretch are `negligible`.

    The measure is a force because light and heavy unknowns alternate: what moves little may resist much.
    `widths` as of `block_widths`. Returns the place of each unknown's column (n,), the first row of each column (r,),
    where it starts in the values (r + 1,), and the values of all columns one after the other.
    """
    place, first = np.zeros(lower.shape[1], dtype=np.int64), np.zeros(unknowns.size, dtype=np.int64)
    offset = np.zeros(unknowns.size + 1, dtype=np.int64)
    values, x = np.empty(512 * unknowns.size), np.zeros((lower.shape[1], LANES))
    for begin in range(0, unknowns.size, LANES):
        panel = unknowns[begin : begin + LANES]
        stop = _forward_panel(lower, widths, panel, negligible, x)
        start = _backward_panel(lower, widths, panel[0], stop, negligible, x)
        rows = stop - start
        while offset[begin] + panel.size * rows > values.size:
            values = doubled(values)
        for c in range(panel.size):
            column = begin + c
            place[panel[c]], first[column], offset[column + 1] = column, start, offset[column] + rows
            for i in range(rows):
                values[offset[column] + i] = x[start + i, c]
    return place, first, offset, values


@njit(cache=True, fastmath={"contract"})
def _add_forces(unknowns, rows, forces, y):  # type: ignore[no-untyped-def]
    """y += ½ Nᵀ F of all wheels."""
    for i in range(forces.size):
        for k in range(4):
            y[unknowns[i, k]] += 0.5 * rows[i, 0, k] * forces[i]


@njit(cache=True, fastmath={"contract"})
def _add_known_forces(unknowns, rows, retained, forces, y):  # type: ignore[no-untyped-def]
    """y += (s − 1) ½ Nᵀ F of all wheels: what forces of a step leave in what is known at its end."""
    for i in range(forces.size):
        for k in range(4):
            j = unknowns[i, k]
            y[j] += 0.5 * (retained[j] - 1.0) * rows[i, 0, k] * forces[i]


@njit(cache=True, fastmath={"contract"})
def _motion(rows, u, v, a, out):  # type: ignore[no-untyped-def]
    """y, ẏ, ÿ of a wheel on the rail from displacement, velocity and acceleration (4,) of its four unknowns."""
    out[:] = 0.0
    for k in range(4):
        out[0] += rows[0, k] * u[k]
        if out.size > 1:
            out[1] += rows[0, k] * v[k] + rows[1, k] * u[k]
            out[2] += rows[0, k] * a[k] + 2.0 * rows[1, k] * v[k] + rows[2, k] * u[k]


@njit(cache=True, fastmath={"contract"})
def _rail_motion(unknowns, rows, irregularity, rate, w, track, motion, work):  # type: ignore[no-untyped-def]
    """y, ẏ, ÿ (w, d) of all wheels at the end of a step whose half increment is w."""
    u, v, a = track
    for i in range(unknowns.shape[0]):
        for k in range(4):
            j = unknowns[i, k]
            work[0, k] = u[j] + 2.0 * w[j]
            work[1, k] = rate * w[j] - v[j]
            work[2, k] = 0.5 * rate * (work[1, k] - v[j]) - a[j]
        _motion(rows[i], work[0], work[1], work[2], motion[i])
        for d in range(motion.shape[1]):
            motion[i, d] += irregularity[i, d]


@njit(cache=True, fastmath={"contract"})
def _contact_columns(unknowns, rows, columns, first, stop, panel):  # type: ignore[no-untyped-def]
    """½ A⁻¹ Nᵀ of every wheel, in rows `first` to `stop` of the track, where it has not decayed."""
    for i in range(unknowns.shape[0]):
        first[i], stop[i] = 0, panel.shape[1]
        for k in range(4):
            c = columns.place[unknowns[i, k]]
            first[i] = max(first[i], columns.first[c])
            stop[i] = min(stop[i], columns.first[c] + columns.offset[c + 1] - columns.offset[c])
        count = stop[i] - first[i]
        near = columns.offset[columns.place[unknowns[i]]] + first[i] - columns.first[columns.place[unknowns[i]]]
        c0, c1 = columns.values[near[0] : near[0] + count], columns.values[near[1] : near[1] + count]
        c2, c3 = columns.values[near[2] : near[2] + count], columns.values[near[3] : near[3] + count]
        n0, n1, n2, n3 = 0.5 * rows[i, 0, 0], 0.5 * rows[i, 0, 1], 0.5 * rows[i, 0, 2], 0.5 * rows[i, 0, 3]
        column = panel[i, :count]
        for m in range(count):
            column[m] = n0 * c0[m] + n1 * c1[m] + n2 * c2[m] + n3 * c3[m]


@njit(cache=True, fastmath={"contract"})
def _receptances(unknowns, rows, first, stop, panel, rate, receptance, work):  # type: ignore[no-untyped-def]
    """y, ẏ, ÿ (d, w, w) of wheel i at the end of a step for a unit force under wheel j there."""
    motion = np.empty(receptance.shape[0])
    for j in range(unknowns.shape[0]):
        for i in range(unknowns.shape[0]):
            motion[:] = 0.0
            near = True
            for k in range(4):
                near = near and first[j] <= unknowns[i, k] < stop[j]
            if near:
                for k in range(4):
                    half = panel[j, unknowns[i, k] - first[j]]
                    work[0, k], work[1, k], work[2, k] = 2.0 * half, rate * half, 0.5 * rate * rate * half
                _motion(rows[i], work[0], work[1], work[2], motion)
            for d in range(motion.size):
                receptance[d, i, j] = motion[d]


@njit(cache=True, fastmath={"contract"})
def _solve(matrix, x):  # type: ignore[no-untyped-def]
    """Gaussian elimination with partial pivoting in place: x becomes the solution of a small dense system."""
    n = x.size
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            x[k], x[pivot] = x[pivot], x[k]
        for i in range(k + 1, n):
            factor = matrix[i, k] / matrix[k, k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                x[i] -= factor * x[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            x[k] -= matrix[k, j] * x[j]
        x[k] /= matrix[k, k]


@njit(cache=True, fastmath={"contract"})
def _force_changes(train, free, motion, receptance, matrix, change):  # type: ignore[no-untyped-def]
    """Solve (1 + Z G) ΔF = F⁰ − Z y − F: what is missing in the forces F that `change` holds on entry, negative."""
    count = change.size
    for i in range(count):
        change[i] += free[i]
        matrix[i, :] = 0.0
        matrix[i, i] = 1.0
        for d in range(receptance.shape[0]):
            for m in range(train.wheel_spans[i, 2], train.wheel_spans[i, 3]):
                impedance = train.impedance[d, i, m]
                if impedance != 0.0:
                    change[i] -= impedance * motion[m, d]
                    for j in range(count):
                        matrix[i, j] += impedance * receptance[d, m, j]
    _solve(matrix, change)


@njit(cache=True, fastmath={"contract"})
def _add_columns(first, stop, panel, changes, w):  # type: ignore[no-untyped-def]
    """w += ½ A⁻¹ Nᵀ ΔF."""
    for i in range(changes.size):
        here, column, change = w[first[i] : stop[i]], panel[i, : stop[i] - first[i]], changes[i]
        for m in range(here.size):
            here[m] += change * column[m]


@njit(cache=True, fastmath={"contract"})
def _add_inputs(train, forces, motion, share, load):  # type: ignore[no-untyped-def]
    """load += share (E_F F + E_0 y + E_1 ẏ)."""
    for i in range(load.size):
        for j in range(train.body_spans[i, 2], train.body_spans[i, 3]):
            load[i] += share * (train.by_force[i, j] * forces[j] + train.by_position[i, j] * motion[j, 0])
            if motion.shape[1] > 1:
                load[i] += share * train.by_velocity[i, j] * motion[j, 1]


@njit(cache=True, fastmath={"contract"})
def _train_without_contact(train, z, zv, forces, motion, rate, load, half, free):  # type: ignore[no-untyped-def]
    """Half the increment of the vehicles with no input at the end of the step, and the forces F⁰ that go with it."""
    for i in range(load.size):
        load[i] = train.load[i]
        for j in range(train.body_spans[i, 0], train.body_spans[i, 1]):
            load[i] += train.scaled_mass[i, j] * zv[j] - train.stiffness[i, j] * z[j]
    _add_inputs(train, forces, motion, 0.5, load)
    for i in range(load.size):
        half[i] = 0.0
        for j in range(train.body_spans[i, 0], train.body_spans[i, 1]):
            half[i] += train.compliance[i, j] * load[j]
    for w in range(free.size):
        free[w] = train.base_force[w]
        for i in range(train.wheel_spans[w, 0], train.wheel_spans[w, 1]):
            free[w] += train.from_displacement[w, i] * (z[i] + 2.0 * half[i])
            free[w] += train.from_velocity[w, i] * (rate * half[i] - zv[i])


@njit(cache=True, fastmath={"contract"})
def _train_with_contact(train, forces, motion, rate, load, half, z, zv, new_z, new_zv):  # type: ignore[no-untyped-def]
    """Add what the inputs at the end of the step do, and advance as the track."""
    load[:] = 0.0
    _add_inputs(train, forces, motion, 0.5, load)
    for i in range(load.size):
        w = half[i]
        for j in range(train.body_spans[i, 0], train.body_spans[i, 1]):
            w += train.compliance[i, j] * load[j]
        new_z[i] = z[i] + 2.0 * w
        new_zv[i] = rate * w - zv[i]


@njit(cache=True, fastmath={"contract"})
def _advance(w, rate, u, v):  # type: ignore[no-untyped-def]
    """u += 2 w and v = 4 w/dt − v, with rate = 4/dt."""
    for i in range(w.size):
        u[i] += 2.0 * w[i]
        v[i] = rate * w[i] - v[i]


@njit(cache=True, fastmath={"contract"})
def _combine(v, proportional, w, x):  # type: ignore[no-untyped-def]
    """x = v + e w."""
    for i in range(w.size):
        x[i] = v[i] + proportional[i] * w[i]


@njit(cache=True, fastmath={"contract"})
def _advance_accelerations(w, rate, v, a):  # type: ignore[no-untyped-def]
    """a = (2/dt) (v_{n+1} − v_n) − a, before `_advance`."""
    for i in range(w.size):
        a[i] = 0.5 * rate * (rate * w[i] - 2.0 * v[i]) - a[i]


@njit(cache=True, fastmath={"contract"})
def _widen(u, a, highest, lowest, fastest):  # type: ignore[no-untyped-def]
    """Envelopes of displacement and acceleration."""
    for i in range(u.size):
        highest[i] = max(highest[i], u[i])
        lowest[i] = min(lowest[i], u[i])
        fastest[i] = max(fastest[i], abs(a[i]))


@njit(cache=True, fastmath={"contract"})
def _add_squares(share, v, supports, integrals):  # type: ignore[no-untyped-def]
    """One term of the trapezoidal rule for ∫ v² dt."""
    for s in range(supports.size):
        integrals[s] += share * v[supports[s]] ** 2


@njit(cache=True, fastmath={"contract"})
def _extrapolated(forces, n, out):  # type: ignore[no-untyped-def]
    """The parabola through the last three forces, at step n; the last force if there are fewer."""
    for i in range(out.size):
        out[i] = forces[n - 1, i]
        if n >= 3:
            out[i] += 2.0 * (forces[n - 1, i] - forces[n - 2, i]) - (forces[n - 2, i] - forces[n - 3, i])


@njit(cache=True, fastmath={"contract"})
def integrate(track, train, contact, observation, start, time_step):  # type: ignore[no-untyped-def]
    """All steps of a passage; returns the fields of `Passage`."""
    steps, wheels, orders, _ = contact.rows.shape
    size, parts, rate = track.lower.shape[1], train.compliance.shape[0], 4.0 / time_step
    force, motions = np.empty((steps, wheels)), np.zeros((steps, wheels, orders))
    z, zv, half, load = np.empty((steps, parts)), np.zeros((steps, parts)), np.empty(parts), np.empty(parts)
    u, v, a, w = start.track.copy(), np.zeros(size), np.zeros(size), np.empty(size)
    recursion, known = track.recursion, start.known.copy()
    most = (recursion.blocks.shape[1] // BLOCK - 3) // 2
    x = np.zeros(size + 2 * most)
    free, change, predicted = np.empty(wheels), np.empty(wheels), np.empty(wheels)
    receptance, matrix, work = np.empty((orders, wheels, wheels)), np.empty((wheels, wheels)), np.empty((3, 4))
    first, stop, panel = np.empty(wheels, np.int64), np.empty(wheels, np.int64), np.empty((wheels, size))
    points = np.empty((steps, observation.points.size))
    integrals = np.zeros(observation.supports.size)
    highest, lowest, fastest = np.full(size, -np.inf), np.full(size, np.inf), np.zeros(size)
    kept_u, kept_v, kept = np.empty((observation.kept.size, size)), np.empty((observation.kept.size, size)), 0
    _copy(start.force, force[0])
    _copy(start.train, z[0])
    _copy(start.wheel, motions[0, :, 0])
    convective, widened = orders > 1, observation.extremes_from < steps
    for n in range(steps):
        unknowns, rows = contact.unknowns[n], contact.rows[n]
        if n > 0:
            before, motion = n - 1, motions[n]
            _extrapolated(force, n, predicted)
            _copy(known, w)
            _add_forces(contact.unknowns[before], contact.rows[before], force[before], w)
            _add_forces(unknowns, rows, predicted, w)
            forward(track.lower, track.lower_runs, w)
            backward(track.upper, track.upper_runs, w)
            _train_without_contact(train, z[before], zv[before], force[before], motions[before], rate, load, half, free)
            _rail_motion(unknowns, rows, contact.irregularity[n], rate, w, (u, v, a), motion, work)
            _contact_columns(unknowns, rows, track.columns, first, stop, panel)
            _receptances(unknowns, rows, first, stop, panel, rate, receptance, work)
            for i in range(wheels):
                change[i] = -predicted[i]
            _force_changes(train, free, motion, receptance, matrix, change)
            for i in range(wheels):
                force[n, i] = predicted[i] + change[i]
                for d in range(orders):
                    for j in range(wheels):
                        motion[i, d] += receptance[d, i, j] * change[j]
            _add_columns(first, stop, panel, change, w)
            _train_with_contact(train, force[n], motion, rate, load, half, z[before], zv[before], z[n], zv[n])
            if convective or widened:
                _advance_accelerations(w, rate, v, a)
            _advance(w, rate, u, v)
            _combine(v, recursion.proportional, w, x[most : most + size])
            next_known(recursion, x, w, known)
            _add_known_forces(contact.unknowns[before], contact.rows[before], recursion.retained, force[before], known)
            _add_known_forces(unknowns, rows, recursion.retained, force[n], known)
            _add_squares(0.5 * time_step if n == steps - 1 else time_step, v, observation.supports, integrals)
        if n >= observation.extremes_from:
            _widen(u, a, highest, lowest, fastest)
        for i in range(points.shape[1]):
            points[n, i] = u[observation.points[i]]
        if kept < observation.kept.size and n == observation.kept[kept]:
            _copy(u, kept_u[kept])
            _copy(v, kept_v[kept])
            kept += 1
    return force, motions, z, zv, integrals, points, highest, lowest, fastest, kept_u[:kept], kept_v[:kept]
