"""The rows of curved motions over cells of time (`motion.relative.cells`) as power series in doubles, errors proved.

A series is in x, from -1 to 1 over the cell, with `KEPT` coefficients.  Of each are known: a bound of the sum of its
coefficients' errors (sums of absolute values are a norm with |f g| <= |f| |g|, cut off or not), and majorants: bounds
of |f^(n)| h^n / n! at all times of the cell, for n up to KEPT, h the half width.  The last of them bounds what the
series leaves out (Lagrange).  Majorants of products and quotients follow from those of their parts (Leibniz).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted

KEPT = 8
_U = 2.0**-53
# What bounds lose to their own rounding.
_UP = 1.0 + 1e-12
# Rows: the poses of both legs, twelve entries and the weight each; then as they are made.
_A, _B, _BACK_OF_B, _POSE, _COFACTOR, _MOMENT, _BACK, _SCRATCH = 0, 13, 26, 38, 50, 59, 68, 80
_FACTOR, _PRODUCT, _ROWS = 84, 96, 108
ROUNDED = -1
"""Said instead of a number of levels where rounding is what errors come from."""
_ROUNDED = 8.0


class LocalPose(NamedTuple):
    """The pose of one body, the time running from 0 to 1.

    turns: it is a product of factors, (3, 4) terms four by four: the entries of each are terms[0] +
        terms[1] cos(x(s)) + terms[2] sin(x(s)) + terms[3] y(s), with the polynomials x, y without constant term whose
        coefficients of s, s^2, s^3 are the factor's rows of `angle` and `ahead`; else polynomials, terms[k] (3, 4) the
        coefficients of s^k, over the polynomial `weight`.
    errors, weight_errors: bounds of the errors of terms and weight.
    """

    turns: bool
    angle: np.ndarray
    ahead: np.ndarray
    terms: np.ndarray
    errors: np.ndarray
    weight: np.ndarray
    weight_errors: np.ndarray


class Series(NamedTuple):
    """Work space: coefficients (rows, KEPT), errors (rows,), majorants (rows, KEPT + 1)."""

    of: np.ndarray
    error: np.ndarray
    most: np.ndarray


@uncounted
def _norm(series, row):
    total = 0.0
    for n in range(KEPT):
        total += abs(series.of[row, n])
    return total


@uncounted
def _clear(series, row):
    series.error[row] = 0.0
    series.most[row, KEPT] = 0.0
    for n in range(KEPT):
        series.of[row, n], series.most[row, n] = 0.0, 0.0


@uncounted
def _copy(series, row, out):
    series.error[out] = series.error[row]
    series.most[out, KEPT] = series.most[row, KEPT]
    for n in range(KEPT):
        series.of[out, n], series.most[out, n] = series.of[row, n], series.most[row, n]


@uncounted
def _add_product(series, i, j, sign, out):
    """out += sign i j; of up to four products and one more row."""
    a, b = _norm(series, i), _norm(series, j)
    for n in range(KEPT):
        total = 0.0
        for k in range(n + 1):
            total += series.of[i, k] * series.of[j, n - k]
        series.of[out, n] += sign * total
    for n in range(KEPT + 1):
        total = 0.0
        for k in range(n + 1):
            total += series.most[i, k] * series.most[j, n - k]
        series.most[out, n] += total * _UP
    # eight products and their sum, and up to four sums after it, of terms no larger than those of all products
    error = a * series.error[j] + series.error[i] * (b + series.error[j]) + 16.0 * _U * a * b
    series.error[out] += error * _UP


@uncounted
def _add_row(series, row, sign, out):
    series.error[out] += series.error[row] + 4.0 * _U * _norm(series, row)
    series.most[out, KEPT] += series.most[row, KEPT]
    for n in range(KEPT):
        series.of[out, n] += sign * series.of[row, n]
        series.most[out, n] += series.most[row, n]


@uncounted
def _invert(series, row, least, out):
    """out = 1 / row; least: a positive bound of what it is at least over the cell.

    With w v = 1 - r for the v computed: 1 / w - v = r / w, and |1 / w| <= |v| / (1 - |r|).
    """
    w = series.of[row]
    v = series.of[out]
    v[0] = 1.0 / w[0]
    for n in range(1, KEPT):
        total = 0.0
        for k in range(1, n + 1):
            total += w[k] * v[n - k]
        v[n] = -total / w[0]
    size = _norm(series, out)
    rest = series.error[row] * size + 12.0 * _U * (1.0 + _norm(series, row) * size)
    series.error[out] = size * rest / (1.0 - rest) * _UP if rest < 0.5 else np.inf
    most = series.most
    most[out, 0] = 1.0 / least * _UP
    for n in range(1, KEPT + 1):
        total = 0.0
        for k in range(1, n + 1):
            total += most[row, k] * most[out, n - k]
        most[out, n] = total / least * _UP


@uncounted
def _least(series, row):
    """What a series of positive values is at least over the cell; not positive where that is not known."""
    total = series.of[row, 0] - series.error[row] - series.most[row, KEPT]
    for n in range(1, KEPT):
        total -= abs(series.of[row, n]) * _UP
    return total * (1.0 - 1e-12) if total > 0.0 else 0.0


# ---------------------------------------------------------------------------------------------------- one leg


@uncounted
def _along(row, middle, half):
    """A polynomial x of `LocalPose` over the cell: coefficients of its powers of the local time, bounds of |x^(n)|
    half^n / n! at all its times for n from 1 on, and the sum of its own coefficients."""
    a, b, c, end = row[0], row[1], row[2], middle + half
    most_a, most_b, most_c = abs(a), abs(b), abs(c)
    return (
        ((c * middle + b) * middle + a) * middle,
        ((3.0 * c * middle + 2.0 * b) * middle + a) * half,
        (3.0 * c * middle + b) * half * half,
        c * half * half * half,
        (most_a + (2.0 * most_b + 3.0 * most_c * end) * end) * half * _UP,
        (most_b + 3.0 * most_c * end) * half * half * _UP,
        most_c * half * half * half * _UP,
        most_a + most_b + most_c,
    )


@uncounted
def _waves(series, row, middle, half):
    """Cosine and sine of the angle x as rows _SCRATCH and _SCRATCH + 1, their majorants in the first.

    Returns the sum of these, and how far the coefficients are off, as a share of it.

    w = exp(i x) has w' = i x' w: with w_n = w^(n) half^n / n!, and x_n as much, n w_n is at every time the sum of
    k i x_k w_{n - k}.  So the coefficients follow from those of x; bounds of |w_n| from those of |x_k|, and |w_0| = 1.
    """
    x0, x1, x2, x3, m1, m2, m3, size = _along(row, middle, half)
    of, most = series.of, series.most
    of[_SCRATCH, 0], of[_SCRATCH + 1, 0] = np.cos(x0), np.sin(x0)
    most[_SCRATCH, 0] = 1.0
    total = 1.0
    for n in range(1, KEPT + 1):
        bound = m1 * most[_SCRATCH, n - 1]
        if n > 1:
            bound += 2.0 * m2 * most[_SCRATCH, n - 2]
        if n > 2:
            bound += 3.0 * m3 * most[_SCRATCH, n - 3]
        most[_SCRATCH, n] = bound / n * _UP
        if n < KEPT:
            cosine, sine = -x1 * of[_SCRATCH + 1, n - 1], x1 * of[_SCRATCH, n - 1]
            if n > 1:
                cosine -= 2.0 * x2 * of[_SCRATCH + 1, n - 2]
                sine += 2.0 * x2 * of[_SCRATCH, n - 2]
            if n > 2:
                cosine -= 3.0 * x3 * of[_SCRATCH + 1, n - 3]
                sine += 3.0 * x3 * of[_SCRATCH, n - 3]
            of[_SCRATCH, n], of[_SCRATCH + 1, n] = cosine / n, sine / n
            total += most[_SCRATCH, n]
    # The coefficients of x are off by one rounding, x0 by six more of their sum, and its cosine by one; x_k by seven
    # roundings of its bound and each step by six more, which up to seven steps hand on.
    return total, (8.0 * size + 112.0) * _U


@uncounted
def _turning(series, first, pose, factor, middle, half):
    """The entries of a factor of a leg that turns, into rows from `first` on."""
    total, blur = _waves(series, pose.angle[factor], middle, half)
    y0, y1, y2, y3, n1, n2, n3, size = _along(pose.ahead[factor], middle, half)
    terms, errors = pose.terms, pose.errors
    k = 4 * factor
    for i in range(3):
        for j in range(4):
            row = first + 4 * i + j
            a, b, d, v = terms[k, i, j], terms[k + 1, i, j], terms[k + 2, i, j], terms[k + 3, i, j]
            for n in range(KEPT):
                series.of[row, n] = b * series.of[_SCRATCH, n] + d * series.of[_SCRATCH + 1, n]
            series.of[row, 0] += a + v * y0
            series.of[row, 1] += v * y1
            series.of[row, 2] += v * y2
            series.of[row, 3] += v * y3
            swing, unsure = abs(b) + abs(d), errors[k + 1, i, j] + errors[k + 2, i, j]
            error = errors[k, i, j] + errors[k + 3, i, j] * size + unsure * total + swing * total * blur
            error += 16.0 * _U * (abs(a) + abs(v) * size + swing * total)
            series.error[row] = error * _UP
            for n in range(KEPT + 1):
                series.most[row, n] = (swing + unsure) * series.most[_SCRATCH, n] * _UP
            ahead = abs(v) + errors[k + 3, i, j]
            series.most[row, 0] += (abs(a) + errors[k, i, j] + ahead * size) * _UP
            series.most[row, 1] += ahead * n1 * _UP
            series.most[row, 2] += ahead * n2 * _UP
            series.most[row, 3] += ahead * n3 * _UP


@uncounted
def _polynomial(series, row, values, errors, choices, work, middle, half):
    """A polynomial as a series; returns what it is at least over the cell, if that is positive.

    values, errors: (n,) strided; choices: the binomial coefficients, as far as its degree; work: (n,).
    """
    count = len(values)
    size, blur, power = 0.0, 0.0, 1.0
    for j in range(count):
        work[j] = values[j]
        size += abs(values[j]) * power
        blur += errors[j] * power
        power *= middle + half
    for i in range(count - 1):  # Taylor's shift by Horner's rule, again and again
        for j in range(count - 2, i - 1, -1):
            work[j] += middle * work[j + 1]
    power, least = 1.0, 0.0
    for k in range(count):
        work[k] *= power
        power *= half
        least += -abs(work[k]) if k else work[k]
    error = (blur + (4.0 * count + 16.0) * _U * size) * _UP
    series.error[row] = error
    for n in range(KEPT + 1):
        total = 0.0
        for j in range(n, count):
            total += choices[j, n] * abs(work[j])
        series.most[row, n] = (total + (choices[count - 1, n] if n < count else 0.0) * error) * _UP
        if n < KEPT:
            series.of[row, n] = work[n] if n < count else 0.0
    return least - error - 1e-12 * size


@uncounted
def _rational(series, first, pose, choices, work, middle, half):
    """The entries of a leg that is rational, into rows from `first` on; False where the weight may vanish."""
    least = _polynomial(series, first + 12, pose.weight, pose.weight_errors, choices, work, middle, half)
    if not least > 0.0:
        return False
    _invert(series, first + 12, least, _SCRATCH)
    for i in range(3):
        for j in range(4):
            row = first + 4 * i + j
            _polynomial(series, _SCRATCH + 1, pose.terms[:, i, j], pose.errors[:, i, j], choices, work, middle, half)
            _clear(series, row)
            _add_product(series, _SCRATCH + 1, _SCRATCH, 1.0, row)
    return True


@uncounted
def _leg(series, first, pose, choices, work, middle, half):
    if pose.turns:
        _turning(series, first, pose, 0, middle, half)
        for factor in range(1, len(pose.angle)):
            _turning(series, _FACTOR, pose, factor, middle, half)
            _composed(series, first, _FACTOR, _PRODUCT)
            for row in range(12):
                _copy(series, _PRODUCT + row, first + row)
        return True
    return _rational(series, first, pose, choices, work, middle, half)


# ---------------------------------------------------------------------------------------------------- both


@uncounted
def _cofactors(series, pose, out):
    for i in range(3):
        p, q = pose + 4 * ((i + 1) % 3), pose + 4 * ((i + 2) % 3)
        for j in range(3):
            row = out + 3 * i + j
            _clear(series, row)
            _add_product(series, p + (j + 1) % 3, q + (j + 2) % 3, 1.0, row)
            _add_product(series, p + (j + 2) % 3, q + (j + 1) % 3, -1.0, row)


@uncounted
def _inverse(series, pose, rigid, cofactors, out):
    """The inverse of a pose, rows four apart; False where it may not exist.  cofactors: used but of rigid ones."""
    if rigid:
        for i in range(3):
            for j in range(3):
                _copy(series, pose + 4 * j + i, out + 4 * i + j)
    else:
        _clear(series, _SCRATCH)
        for j in range(3):
            _add_product(series, pose + j, cofactors + j, 1.0, _SCRATCH)
        if series.of[_SCRATCH, 0] < 0.0:  # of a mirror image
            for n in range(KEPT):
                series.of[_SCRATCH, n] = -series.of[_SCRATCH, n]
            sign = -1.0
        else:
            sign = 1.0
        least = _least(series, _SCRATCH)
        if not least > 0.0:
            return False
        _invert(series, _SCRATCH, least, _SCRATCH + 1)
        for i in range(3):
            for j in range(3):
                row = out + 4 * i + j
                _clear(series, row)
                _add_product(series, cofactors + 3 * j + i, _SCRATCH + 1, sign, row)
    for i in range(3):
        row = out + 4 * i + 3
        _clear(series, row)
        for k in range(3):
            _add_product(series, out + 4 * i + k, pose + 4 * k + 3, -1.0, row)
    return True


@uncounted
def _composed(series, m, n, out):
    """First n, then m."""
    for i in range(3):
        for j in range(4):
            row = out + 4 * i + j
            _clear(series, row)
            for k in range(3):
                _add_product(series, m + 4 * i + k, n + 4 * k + j, 1.0, row)
            if j == 3:
                _add_row(series, m + 4 * i + 3, 1.0, row)


@uncounted
def _moments(series, pose, out):
    """Cross products of the shift with the columns of the linear part."""
    for i in range(3):
        p, q = pose + 4 * ((i + 1) % 3), pose + 4 * ((i + 2) % 3)
        for j in range(3):
            row = out + 3 * i + j
            _clear(series, row)
            _add_product(series, p + 3, q + j, 1.0, row)
            _add_product(series, q + 3, p + j, -1.0, row)


@uncounted
def _cell(series, a, b, b_rests, rigid_b, rigid, choices, work, middle, half):
    """All rows over one cell; False where nothing is known."""
    if not _leg(series, _A, a, choices, work, middle, half):
        return False
    pose = _A
    if not b_rests:
        if not _leg(series, _B, b, choices, work, middle, half):
            return False
        if not rigid_b:
            _cofactors(series, _B, _COFACTOR)
        if not _inverse(series, _B, rigid_b, _COFACTOR, _BACK_OF_B):
            return False
        pose = _POSE
        _composed(series, _BACK_OF_B, _A, pose)
    else:
        for row in range(12):
            _copy(series, _A + row, _POSE + row)
    if rigid:
        for i in range(3):
            for j in range(3):
                _copy(series, _POSE + 4 * i + j, _COFACTOR + 3 * i + j)
    else:
        _cofactors(series, _POSE, _COFACTOR)
    _moments(series, _POSE, _MOMENT)
    return _inverse(series, _POSE, rigid, _COFACTOR, _BACK)


@uncounted
def _write(series, powers, rest, cell):
    """The 42 rows of the cell: linear part, shift, cofactors, moments, inverse, its shift."""
    row = 0
    for start, step, wide in ((_POSE, 4, 3), (_POSE + 3, 4, 1), (_COFACTOR, 3, 3), (_MOMENT, 3, 3), (_BACK, 4, 3),
                              (_BACK + 3, 4, 1)):  # fmt: skip
        for i in range(3):
            for j in range(wide):
                source = start + step * i + j
                for n in range(KEPT):
                    powers[cell, row, n] = series.of[source, n]
                rest[cell, row] = (series.error[source] + series.most[source, KEPT]) * _UP
                row += 1


@uncounted
def _bounds(series, first, wide):
    """(most that is left out, most error, largest value) of the linear part or the shift."""
    left, error, most = 0.0, 0.0, 0.0
    for i in range(3):
        for j in range(wide):
            row = _POSE + 4 * i + first + j
            size = _norm(series, row)
            left = max(left, series.most[row, KEPT])
            error = max(error, series.error[row] + 96.0 * _U * size)
            most = max(most, size)
    return left, error, most


@kernel
def pose_series(a, b, b_rests, rigid_b, rigid, size_a, size_b, wanted, most_levels, powers, rest):
    """Fills powers (cells, 42, KEPT) and rest (cells, 42) level by level; returns how many lie below the first.

    They end where what series leave out moves no point of a body of size_a by more than `wanted` of the sizes of both.
    ROUNDED where rounding does so by several times that.  rest is inf where nothing is known.
    """
    of, most = np.zeros((_ROWS, KEPT)), np.zeros((_ROWS, KEPT + 1))
    series = Series(of, np.zeros(_ROWS), most)
    count = max(len(a.weight), len(b.weight), KEPT + 1)
    choices, work = np.zeros((count, KEPT + 1)), np.zeros(count)
    for j in range(count):
        choices[j, 0] = 1.0
        for k in range(1, min(j, KEPT) + 1):
            choices[j, k] = choices[j - 1, k - 1] + choices[j - 1, k]
    cell = 0
    for level in range(most_levels + 1):
        half = 0.5 / (1 << level)
        worst, reach, known = 0.0, size_b, True
        for i in range(1 << level):
            if _cell(series, a, b, b_rests, rigid_b, rigid, choices, work, half * (2 * i + 1), half):
                _write(series, powers, rest, cell)
                left, error, size = _bounds(series, 0, 3)
                left_shift, error_shift, shift = _bounds(series, 3, 1)
                reach = max(reach, size_b + 3.0 * size_a * size + shift)
                rounding = 3.0 * size_a * error + error_shift
                if not rounding <= _ROUNDED * wanted * (size_b + 3.0 * size_a * size + shift):
                    known = level < most_levels
                    if not known:
                        return ROUNDED
                worst = max(worst, 3.0 * size_a * left + left_shift)
            else:
                rest[cell], known = np.inf, False
            cell += 1
        if known and worst <= wanted * reach:
            return level
    return most_levels
