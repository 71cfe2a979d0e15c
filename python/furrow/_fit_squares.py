"""Least squares of a model with up to three numbers, by scipy, and how well a curve goes through its rows."""
import dataclasses
import math
from typing import Callable

import numpy as np

from furrow import _command
from furrow._fit_table import Table

SINGULAR = 1e-13  # of a scaled pivot
OUTSIDE = 1e150   # a residual where the model has no value, so that no step goes there


@dataclasses.dataclass
class Number:
    """A value and its standard error; nan: it was not fitted."""

    value: float
    error: float = math.nan


@dataclasses.dataclass
class Quality:
    """How well a curve goes through its rows: rms and the largest of measured - fitted, Pa. goodness: 1 - rms / mean, with count - 2 for the count (Wong 1980)."""

    rows: int
    rms: float
    largest: float
    largest_line: int
    goodness: float


def quality(table: Table, model: "np.ndarray", rows: "np.ndarray | None" = None) -> Quality:
    """Of all rows, or of those that `rows` chooses."""
    chosen = np.ones(len(table), bool) if rows is None else rows
    residuals, y = (table.y - model)[chosen], table.y[chosen]
    squares, count = float(np.sum(residuals * residuals)), int(chosen.sum())
    worst = int(np.argmax(np.abs(residuals)))
    goodness = 1 - math.sqrt(squares / (count - 2)) / (y.sum() / count) if count > 2 and y.sum() > 0 else math.nan
    return Quality(count, math.sqrt(squares / count), float(residuals[worst]), int(table.line[chosen][worst]), float(goodness))


# --- least squares ---

Model = Callable[["np.ndarray"], "tuple[np.ndarray, np.ndarray] | None"]


@dataclasses.dataclass
class Solution:
    """x, the sum of squared residuals, and the covariance of x: sum / (count - free numbers) times the inverse of J'J; 0 for numbers that were kept."""

    x: "np.ndarray"
    sum: float
    covariance: "np.ndarray"


def _inverse(jacobian: "np.ndarray") -> "np.ndarray | None":
    """The inverse of J'J. None: the residuals do not tell the numbers apart, to 13 digits."""
    size = np.sqrt(np.sum(jacobian * jacobian, axis=0))
    if not np.all(size > 0) or not np.all(np.isfinite(size)):
        return None
    scaled = jacobian / size
    try:
        factor = np.linalg.cholesky(scaled.T @ scaled)
    except np.linalg.LinAlgError:
        return None
    if np.min(np.diag(factor)) ** 2 <= SINGULAR:
        return None
    back = np.linalg.inv(factor)
    return np.asarray(back.T @ back / np.outer(size, size))


def least_squares(model: Model, start: "np.ndarray", fixed: "tuple[bool, ...]") -> "Solution | None":
    """Fits the numbers that are not fixed. `model`: of x the residuals and their derivatives; None: it has no value there.

    None: the model has no value at the start, or the residuals do not tell the numbers apart. _command.Missing: there is no scipy.
    """
    optimize = _command.need("scipy.optimize", "scipy")
    free = ~np.array(fixed)
    x = np.array(start, float)
    first = model(x)
    if first is None or not np.all(np.isfinite(first[0])):
        return None
    count = len(first[0])

    def at(some: "np.ndarray") -> "tuple[np.ndarray, np.ndarray]":
        whole = x.copy()
        whole[free] = some
        found = model(whole)
        if found is None or not np.all(np.isfinite(found[0])):
            return np.full(count, OUTSIDE), np.zeros((count, int(free.sum())))
        return found[0], found[1][:, free]

    with np.errstate(all="ignore"):
        done = optimize.least_squares(lambda some: at(some)[0], x[free], lambda some: at(some)[1], method="lm", x_scale="jac", ftol=1e-15, xtol=1e-15, gtol=1e-15, max_nfev=5000)
        best, (residuals, jacobian) = done.x, at(done.x)
        for _ in range(12):  # to the last digits, by Gauss's steps: there the sum of squares hardly changes any more
            inverse = _inverse(jacobian)
            if inverse is None:
                break
            closer = best - inverse @ (jacobian.T @ residuals)
            then = at(closer)
            if not np.sum(then[0] ** 2) <= np.sum(residuals ** 2) * (1 + 1e-12) or np.all(np.abs(closer - best) <= 1e-15 * np.abs(best)):
                break
            best, (residuals, jacobian) = closer, then
    inverse = _inverse(jacobian)
    if inverse is None:
        return None
    x[free] = best
    total = float(np.sum(residuals * residuals))
    covariance = np.zeros((len(x), len(x)))
    covariance[np.ix_(free, free)] = inverse * (total / (count - free.sum()) if count > free.sum() else 0)
    return Solution(x, total, covariance)
