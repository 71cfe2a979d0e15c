"""The models of furrow.fit: what each test's rows say of a soil. SI units: m, Pa, radians."""
import dataclasses
import math
from typing import Any

import numpy as np

from furrow._fit_squares import Model, Number, Quality, Solution, least_squares, quality
from furrow._fit_table import Table
from furrow.results import ResultsError

METHODS = ("plain", "wong")
N_MOST, K_MOST = 3.0, 10.0  # n, and Janosi's K in m, of a scene
LEVEL_PLATE = 0.87574       # pressure / (xi_n x depth) of a level plate that moves straight down: PNAS 120 (2023), SI
STARTS = 24

# --- plates: p = (kc / b + kphi) z^n ---
# plain: the least squares of p. wong: the least squares of p (ln p - ln of the model), logarithms weighted by the square of pressure (J. Y. Wong, Data processing
# methodology in the characterization of the mechanical properties of terrain, Journal of Terramechanics 17, 1980).
# Inside, sinkage is in units of z0 and width in units of b0, a mean of each: p = (A b0 / b + B) (z / z0)^n. So A, B and n depend little on each other.

@dataclasses.dataclass
class Curve:
    """One plate alone, by Wong's formulas."""

    k: float
    n: float
    quality: Quality


@dataclasses.dataclass
class Plates:
    """By method: kc, N/m^(n+1), kphi, N/m^(n+2), n. one_width: kc is 0, and kphi is k of that width. no_kphi: it would be below 0, so it is 0."""

    one_width: bool
    no_kphi: bool
    kc: "dict[str, Number]"
    kphi: "dict[str, Number]"
    n: "dict[str, Number]"
    quality: "dict[str, Quality]"
    curves: "list[Curve]"

    def pressure(self, method: str, b: Any, z: Any) -> Any:
        """Pa, at a width and a sinkage."""
        return (self.kc[method].value / b + self.kphi[method].value) * np.power(z, self.n[method].value)


def _line(table: Table, z0: float, group: int) -> "tuple[float, ...]":
    """Weighted sums over the rows of a plate: of ln p = ln k + n ln z, weighted by p^2."""
    rows = table.of(group) & (table.y > 0)
    w, x, y = table.y[rows] ** 2, np.log(table.x[rows] / z0), np.log(table.y[rows])
    return float(w.sum()), float((w * x).sum()), float((w * y).sum()), float((w * x * x).sum()), float((w * x * y).sum())


def _curve(table: Table, z0: float, group: int) -> Curve:
    w, x, y, xx, xy = _line(table, z0, group)
    n = float(np.float64(w * xy - x * y) / np.float64(w * xx - x * x))
    k = math.exp((y - n * x) / w)
    return Curve(k * z0 ** -n, n, quality(table, k * (table.x / z0) ** n, table.of(group)))


def _begin_plates(table: Table, z0: float, b0: float) -> "np.ndarray":
    """Where the fits begin: one n for all plates, k of each, and the straight line through k over b0 / b."""
    lines = [_line(table, z0, group) for group in range(len(table.groups))]
    n = np.float64(sum(xy - x * y / w for w, x, y, xx, xy in lines)) / np.float64(sum(xx - x * x / w for w, x, y, xx, xy in lines))
    k = np.array([np.exp((y - n * x) / w) for w, x, y, xx, xy in lines])
    b = b0 / np.array(table.groups)
    a = (len(k) * np.sum(b * k) - b.sum() * k.sum()) / (len(k) * np.sum(b * b) - b.sum() ** 2) if len(k) > 1 else 0.0
    return np.array([a, (k.sum() - a * b.sum()) / len(k), n])


def _plates_model(table: Table, method: str, z0: float, b0: float) -> Model:
    z, b, p = table.x / z0, b0 / table.group, table.y
    log_z, log_p = np.log(z), np.log(np.where(p > 0, p, 1))

    def at(x: "np.ndarray") -> "tuple[np.ndarray, np.ndarray] | None":
        k, power = x[0] * b + x[1], np.power(z, x[2])
        if not np.all(k > 0) or not np.all(power > 0) or not np.all(np.isfinite(power)):
            return None
        if method == "plain":
            return k * power - p, np.stack([b * power, power, k * power * log_z], axis=1)
        return p * (np.log(k * power) - log_p), np.stack([p * b / k, p / k, p * log_z], axis=1)  # a pressure of 0 has no weight

    return at


def _check_plates(table: Table) -> None:
    least = 4 if len(table.groups) > 1 else 3
    if len(table) < least:
        raise ResultsError(f"{table.path}: has {len(table)} rows with a sinkage above 0, and {least} are needed; give more")
    for group, width in enumerate(table.groups):
        x = table.x[table.of(group)]
        if not x.max() > x.min() * (1 + 1e-9):
            raise ResultsError(f"{table.path}: the plate of {width:g} m has rows of one sinkage only; measure it at several")
        if not table.y[table.of(group)].max() > 0:
            raise ResultsError(f"{table.path}: the plate of {width:g} m has no pressure above 0; check the column")


def fit_plates(table: Table) -> Plates:
    """ResultsError: too few rows, or they do not tell the numbers apart."""
    _check_plates(table)
    w = table.y ** 2
    z0, b0 = float(np.exp(np.sum(w * np.log(table.x)) / w.sum())), 1 / float(np.mean(1 / np.array(table.groups)))
    cannot_tell = ResultsError(f"{table.path}: its rows do not tell kc, kphi and n apart; measure each plate at several sinkages, and plates of clearly different widths")
    with np.errstate(all="ignore"):
        try:
            curves, start = [_curve(table, z0, group) for group in range(len(table.groups))], _begin_plates(table, z0, b0)
        except (OverflowError, ZeroDivisionError):
            raise cannot_tell from None
    plates = Plates(len(table.groups) == 1, False, {}, {}, {}, {}, curves)
    if not np.all(np.isfinite(start)):
        raise cannot_tell
    for method in METHODS:
        model, fixed = _plates_model(table, method, z0, b0), (plates.one_width, False, False)
        found = least_squares(model, start, fixed)
        if found is not None and found.x[1] < 0:  # no scene takes that
            plates.no_kphi, fixed = True, (plates.one_width, True, False)
            found = least_squares(model, np.array([found.x[0] + found.x[1], 0, found.x[2]]), fixed)
        if found is None:
            raise cannot_tell
        (a, b, n), unit, log_z0 = found.x, z0 ** -float(found.x[2]), math.log(z0)
        by = np.array([[b0 * unit, 0, -a * b0 * unit * log_z0], [0, unit, -b * unit * log_z0], [0, 0, 1]])  # how kc, kphi and n change with A, B and n
        errors = np.sqrt(np.maximum(np.diag(by @ found.covariance @ by.T), 0))
        for numbers, value, error, kept in zip((plates.kc, plates.kphi, plates.n), (a * b0 * unit, b * unit, n), errors, fixed):
            numbers[method] = Number(float(value), math.nan if kept else float(error))
        if not 0 < n <= N_MOST:
            raise ResultsError(f"{table.path}: n would be {n:.3g}, and a soil's is above 0 and at most {N_MOST:g}; check the units of its columns, and leave out "
                               "rows where the plate did not yet touch")
        plates.quality[method] = quality(table, plates.pressure(method, table.group, table.x))
    return plates


# --- shear: tau = (c + sigma tan phi) (1 - exp(-j / K)) ---
# For a given K the model is linear in c and tan phi. So the search begins at the best of some K, each with its c and tan phi.

@dataclasses.dataclass
class Shear:
    """Cohesion, Pa, friction angle, radians, Janosi's K, m. one_stress: one of the first two is taken for 0. no_cohesion, no_friction: below 0, so it is 0."""

    one_stress: bool
    no_cohesion: bool
    no_friction: bool
    cohesion: Number
    friction: Number
    shear: Number
    quality: Quality

    def stress(self, sigma: Any, j: Any) -> Any:
        """Pa, under a normal stress at a displacement."""
        return (self.cohesion.value + sigma * math.tan(self.friction.value)) * -np.expm1(-j / self.shear.value)


def _solve_shear(table: Table, unit: float, fixed: "tuple[bool, bool]") -> "Solution | None":
    def at(x: "np.ndarray") -> "tuple[np.ndarray, np.ndarray] | None":
        if not x[2] > 0:
            return None
        decay, share, most = np.exp(-table.x / x[2]), -np.expm1(-table.x / x[2]), x[0] * unit + table.group * x[1]
        return most * share - table.y, np.stack([unit * share, table.group * share, -most * decay * table.x / x[2] ** 2], axis=1)

    low, high, best, least = float(table.x.min()), float(table.x.max()), None, math.inf
    free = ~np.array(fixed)
    for k in low / 3 * np.power(9 * high / low, np.linspace(0, 1, STARTS)):
        x = np.array([0.0, 0.0, k])
        columns = (at(x) or (table.y, np.zeros((len(table), 3))))[1][:, :2][:, free]
        size = np.maximum(np.sqrt(np.sum(columns ** 2, axis=0)), 1e-300)
        x[:2][free] = np.linalg.lstsq(columns / size, table.y, rcond=None)[0] / size
        found = at(x)
        total = float(np.sum(found[0] ** 2)) if found is not None else math.inf
        if total < least:
            least, best = total, x
    return least_squares(at, best, (*fixed, False)) if best is not None else None


def fit_shear(table: Table) -> Shear:
    """ResultsError: too few rows, or they do not tell the numbers apart."""
    needed = 4 if len(table.groups) > 1 else 3
    if len(table) < needed:
        raise ResultsError(f"{table.path}: has {len(table)} rows with a displacement above 0, and {needed} are needed; give more")
    if not table.x.max() > table.x.min() * (1 + 1e-9):
        raise ResultsError(f"{table.path}: all rows have one displacement; give the stress at several")
    if not table.y.max() > 0:
        raise ResultsError(f"{table.path}: has no shear stress above 0; check the column")
    unit, one = max(1.0, *table.groups), len(table.groups) == 1  # Pa: of c, so that its size is that of tan phi
    none = one and not table.groups[0] > 0
    fixed, no_cohesion, no_friction = (one and not none, none), False, False
    with np.errstate(all="ignore"):
        found = _solve_shear(table, unit, fixed)
        if found is not None and not fixed[0] and found.x[0] < 0:
            no_cohesion, fixed = True, (True, fixed[1])
            found = _solve_shear(table, unit, fixed)
        elif found is not None and not fixed[1] and found.x[1] < 0:
            no_friction, fixed = True, (fixed[0], True)
            found = _solve_shear(table, unit, fixed)
    if found is None or found.x[2] > K_MOST:
        raise ResultsError(f"{table.path}: its rows do not tell cohesion, friction and K apart: the shear stress has to level off within the measured displacement; "
                           "measure to a larger one, and under clearly different normal stresses")
    (c, t, k), errors = (float(value) for value in found.x), np.sqrt(np.maximum(np.diag(found.covariance), 0))
    shear = Shear(one, no_cohesion, no_friction, Number(c * unit, math.nan if fixed[0] else float(errors[0]) * unit),
                  Number(math.atan(t), math.nan if fixed[1] else float(errors[1]) / (1 + t * t)), Number(k, float(errors[2])), Quality(0, 0, 0, 0, 0))
    shear.quality = quality(table, shear.stress(table.group, table.x))
    return shear


# --- penetration: p = 0.87574 xi_n z ---

@dataclasses.dataclass
class Penetration:
    """strength: xi_n, N/m3, the least squares of pressure through the origin. slope, offset: the same with an offset, N/m3 and Pa, a check of the model.
    alone: xi_n of each area; the error is nan where it has one row."""

    strength: Number
    slope: Number
    offset: Number
    quality: Quality
    alone: "list[Number]"


def _through_origin(x: "np.ndarray", y: "np.ndarray") -> Number:
    xx, xy = float(np.sum(x * x)), float(np.sum(x * y))
    left = max(float(np.sum(y * y)) - xy / xx * xy, 0)
    return Number(xy / xx, math.sqrt(left / (len(x) - 1) / xx) if len(x) > 1 else math.nan)


def fit_penetration(table: Table) -> Penetration:
    """The table has pressures. ResultsError: fewer than 3 rows, or of one depth, or without a pressure."""
    if len(table) < 3:
        raise ResultsError(f"{table.path}: has {len(table)} rows with a depth above 0, and 3 are needed; give more")
    if not table.x.max() > table.x.min() * (1 + 1e-9):
        raise ResultsError(f"{table.path}: all rows have one depth; measure at several")
    x, y, count = LEVEL_PLATE * table.x, table.y, len(table)
    strength = _through_origin(x, y)
    if not strength.value > 0:
        raise ResultsError(f"{table.path}: has no pressure above 0; check the column")
    spread, along = float(np.sum((x - x.mean()) ** 2)), float(np.sum((x - x.mean()) * (y - y.mean())))
    slope = along / spread
    left = max(float(np.sum((y - y.mean() - slope * (x - x.mean())) ** 2)), 0) / (count - 2)
    return Penetration(strength, Number(slope, math.sqrt(left / spread)),
                       Number(float(y.mean() - slope * x.mean()), math.sqrt(left * float(np.sum(x * x)) / count / spread)), quality(table, strength.value * x),
                       [_through_origin(x[table.of(group)], y[table.of(group)]) for group in range(len(table.groups))])
