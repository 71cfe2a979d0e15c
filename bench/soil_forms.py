#!/usr/bin/env python3
"""Closed forms of a rigid wheel on soft soil, for benches to hold the command to. Plain Python, SI units.

Each form is integrated twice. `by_angle` goes along the wheel's arc, with formulas in theta. `by_way` goes along the ground, with
vectors, and gets the shear displacement by summing the velocity of the rim over time. Neither uses a function of the other. Run
this file to see how far they are apart:

    python3 bench/soil_forms.py
"""
import bisect
import dataclasses
import math
import operator

NAMED = {  # k_c, k_phi, n, cohesion, friction angle in degrees, K: docs/SOILS.md
    "dry_sand": (990, 1528430, 1.1, 1040, 28, 0.02),
    "sandy_loam_15": (5270, 1515040, 0.7, 1720, 29, 0.02),
    "sandy_loam_22": (2560, 43120, 0.2, 1380, 38, 0.02),
    "clayey_38": (13190, 692150, 0.5, 4140, 13, 0.02),
    "heavy_clay_25": (12700, 1555950, 0.13, 68950, 34, 0.006),
    "heavy_clay_40": (1840, 103270, 0.11, 20690, 6, 0.03),
    "lean_clay_22": (16430, 1724690, 0.2, 68950, 20, 0.006),
    "lete_sand": (102000, 5301000, 0.79, 1300, 31.1, 0.012),
    "upland_loam_51": (74600, 2080000, 1.1, 3300, 33.7, 0.02),
    "snow_us": (4370, 196720, 1.6, 1030, 19.7, 0.03),
    "snow_sweden": (10550, 66080, 1.44, 6000, 20.7, 0.03),
    "lunar": (1400, 820000, 1.0, 170, 35, 0.018),
    "chrono_soft": (0, 200000, 1.1, 0, 30, 0.01),
}
STIFFNESS = 4e7  # Pa/m, K_e of every named soil


@dataclasses.dataclass(frozen=True)
class Soil:
    kc: float
    kphi: float
    n: float
    cohesion: float
    friction: float  # degrees
    janosi: float
    stiffness: float = STIFFNESS

    def yields(self, depth, width):
        """Pa at which soil yields at a sinkage: Bekker's pressure, and never more than K_e z."""
        return min((self.kc / width + self.kphi) * depth ** self.n, self.stiffness * depth) if depth > 0 else 0.0

    def shear(self, normal, j):
        """Pa, signed as j."""
        most = self.cohesion + normal * math.tan(math.radians(self.friction))
        return math.copysign(most * -math.expm1(-abs(j) / self.janosi), j) if normal > 0 else 0.0


def named(name):
    return Soil(*NAMED[name])


@dataclasses.dataclass(frozen=True)
class Wheel:
    radius: float
    width: float


@dataclasses.dataclass(frozen=True)
class Law:
    """stress: `surface`, as Wong and Reece have it: normal and shear lie along the wheel's surface, per area of that surface. `ground`, as
    Project Chrono has it: normal stress is vertical and shear level, per area of ground.
    j: `rim`, the slip of one point of the rim since it entered the soil (Wong and Reece). `ground`, the slip that one point of the ground
    has had (a post's). They differ by the factor 1 / (1 - slip) at the bottom.
    kappa: slip sinkage. The soil is dug by D and bears as if it lay D deeper. From the first contact D grows by |e| (kappa K - D) / K of the growth of j
    beyond that of a wheel that rolls, e being 1 - exp(-|j| / K). A rim never digs itself free: D is at most the wheel's depth there."""
    stress: str = "surface"
    j: str = "rim"
    kappa: float = 0.0


@dataclasses.dataclass(frozen=True)
class Answer:
    sinkage: float  # m
    fz: float       # N, up
    fx: float       # N, forward: drawbar pull
    my: float       # N m: what drives the wheel

    def apart(self, other):
        """The greatest difference, as a share of the force."""
        return max(abs(self.fz - other.fz), abs(self.fx - other.fx), abs(self.my - other.my)) / max(abs(self.fz), 1e-12)


# Places and weights of Gauss's rule on -1 .. 1.
GAUSS = [(-0.9602898564975363, 0.1012285362903763), (-0.7966664774136267, 0.2223810344533745),
         (-0.5255324099163290, 0.3137066458778873), (-0.1834346424956498, 0.3626837833783620)]
GAUSS += [(-x, w) for x, w in reversed(GAUSS)]


# --- along the arc ---

def tanh_sinh(function, low, high, levels=6):
    """Integrates a vector of three over [low, high]; the ends may be singular."""
    if high <= low:
        return (0.0, 0.0, 0.0)
    half, middle, step = (high - low) / 2, (high + low) / 2, 0.5 ** (levels - 1)
    sums = [0.0, 0.0, 0.0]
    for k in range(-int(3.3 / step), int(3.3 / step) + 1):
        t = k * step
        u = math.pi / 2 * math.sinh(t)
        weight = math.pi / 2 * math.cosh(t) / math.cosh(u) ** 2
        value = function(middle + half * math.tanh(u))
        for i in range(3):
            sums[i] += weight * value[i]
    return tuple(s * step * half for s in sums)


def arc_displacement(wheel, law, slip, entry, theta):
    """j at theta, from its formula. Ahead theta is above 0."""
    r = wheel.radius
    if law.stress == "surface" and law.j == "rim":
        return r * ((entry - theta) - (1 - slip) * (math.sin(entry) - math.sin(theta)))
    if law.stress == "surface":
        return r * ((math.sin(entry) - math.sin(theta)) / (1 - slip) -
                    ((entry - theta) + (math.sin(2 * entry) - math.sin(2 * theta)) / 2) / 2)
    if law.j == "rim":
        return r * ((math.sin(entry) - math.sin(theta)) - (1 - slip) * (entry - theta))
    return r * (((entry - theta) + (math.sin(2 * entry) - math.sin(2 * theta)) / 2) / 2 / (1 - slip) - (math.sin(entry) - math.sin(theta)))


def roots(function, low, high, steps=400):
    """Where it changes its sign between low and high."""
    found, before = [], function(low)
    for i in range(1, steps + 1):
        a, b = low + (high - low) * (i - 1) / steps, low + (high - low) * i / steps
        after = function(b)
        if before * after < 0:
            for _ in range(60):
                m = (a + b) / 2
                a, b = (m, b) if function(m) * before > 0 else (a, m)
            found.append((a + b) / 2)
        before = after
    return found


class Dug:
    """The depth that slip has dug, by theta. Where it would dig faster than the rim comes down, the rim stands free: D is the wheel's depth there."""
    PANELS = 100

    def __init__(self, soil, wheel, law, slip, entry):
        self.wheel, self.entry, self.modulus = wheel, entry, soil.janosi
        self.most, self.rate = law.kappa * soil.janosi, abs(slip) if law.j == "rim" else abs(slip) / (1 - slip)
        self.mobilised = lambda theta: 1 - math.exp(-abs(arc_displacement(wheel, law, slip, entry, theta)) / soil.janosi)
        turns = roots(lambda theta: arc_displacement(wheel, law, slip, entry, theta), -entry, entry - 1e-6)
        self.edges = sorted([entry - 2 * entry * k / self.PANELS for k in range(self.PANELS + 1)] + turns + [0.0], reverse=True)
        self.marks = [-edge for edge in self.edges]
        self.ways = [0.0]   # to each edge: the integral of |e| over the way of the ground
        for high, low in zip(self.edges, self.edges[1:]):
            self.ways.append(self.ways[-1] + self.between(high, low))
        self.parts = [(entry, 0.0, False)]   # theta where it begins, D there, whether the rim stands free
        self.find_parts()

    def between(self, high, low):
        nodes = ((high + low + (high - low) * x) / 2 for x, _ in GAUSS)
        return (high - low) / 2 * self.wheel.radius * sum(w * self.mobilised(t) * math.cos(t) for t, (_, w) in zip(nodes, GAUSS))

    def way(self, theta):
        panel = max(bisect.bisect_left(self.marks, -theta) - 1, 0)
        return self.ways[panel] + self.between(self.edges[panel], theta)

    def depth(self, theta):
        return self.wheel.radius * (math.cos(theta) - math.cos(self.entry))

    def lacks(self, theta):
        """How much faster the rim would dig than it comes down, were D its depth."""
        return (self.most - self.depth(theta)) / self.modulus * self.rate * self.mobilised(theta) * math.cos(theta) - math.sin(theta)

    def bound(self, theta, part):
        begins, had, free = part
        if free:
            return self.depth(theta)
        return self.most - (self.most - had) * math.exp(-self.rate * (self.way(theta) - self.way(begins)) / self.modulus)

    def find_parts(self):
        for high, low in zip(self.edges, self.edges[1:]):
            if low < 0:
                break
            part = self.parts[-1]
            ended = (lambda theta: self.lacks(theta) <= 0) if part[2] else (lambda theta: self.bound(theta, part) > self.depth(theta))
            if ended(low):
                for _ in range(60):
                    middle = (low + high) / 2
                    low, high = (middle, high) if ended(middle) else (low, middle)
                self.parts.append((low, self.depth(low), not part[2]))
        if self.parts[-1][2]:
            self.parts.append((0.0, self.depth(0.0), False))

    def __call__(self, theta):
        return self.bound(theta, next(part for part in reversed(self.parts) if theta <= part[0] or part is self.parts[0]))


def by_angle(soil, wheel, sinkage, slip, law=Law()):
    """Forces at a sinkage, by a quadrature over theta."""
    r, b = wheel.radius, wheel.width
    entry = math.acos(1 - sinkage / r)
    dug = Dug(soil, wheel, law, slip, entry) if law.kappa and slip else (lambda theta: 0.0)

    def displacement(theta):
        return arc_displacement(wheel, law, slip, entry, theta)

    def sunk(theta):
        return r * (math.cos(theta) - math.cos(entry)) - dug(theta)

    at_bottom = soil.yields(sinkage - dug(0.0), b)

    def rises(theta):
        """Behind the axle, Pa, below 0 where nothing bears. What was pressed stays where it is: below ground that is dug it is less deep."""
        falls = soil.stiffness * r * (1 - math.cos(theta))
        return (soil.yields(sinkage - dug(theta), b) if falls < at_bottom else at_bottom) - falls

    def stress(theta):
        return soil.yields(sunk(theta), b) if theta >= 0 else max(0.0, rises(theta))

    def shares(theta):
        sigma = stress(theta)
        tau = soil.shear(sigma, displacement(theta))
        c, s = math.cos(theta), math.sin(theta)
        if law.stress == "surface":
            return sigma * c + tau * s, tau * c - sigma * s, r * tau
        return sigma * c, tau * c, (tau * r * c + sigma * r * s) * c

    cuts = {-entry, 0.0, entry}
    if law.kappa and slip:
        cuts.update(begins for begins, _, _ in dug.parts)
    cuts.update(roots(rises, -entry, 0.0))
    cuts.update(roots(displacement, -entry, entry - 1e-6))
    if soil.n < 1:
        capped = ((soil.kc / b + soil.kphi) / soil.stiffness) ** (1 / (1 - soil.n))
        cuts.update(roots(lambda t: sunk(t) - capped, 0.0, entry))
    cuts = sorted(cuts)
    sums = [sum(parts) for parts in zip(*(tanh_sinh(shares, low, high) for low, high in zip(cuts, cuts[1:])))]
    return Answer(sinkage, *(r * b * s for s in sums))


# --- along the ground ---

def by_way(soil, wheel, sinkage, slip, law=Law(), panels=300):
    """The same at a sinkage by another way: small steps along the ground from the front to the rear, with the wheel rolling at 1 m/s.
    Force and moment are vectors at places. A step in which the soil's answer has a kink is halved until the kink is alone."""
    radius, ground = wheel.radius, wheel.radius - sinkage     # the surface is `ground` below the axle
    turns = 1 / (1 - slip) / radius                           # rad/s
    front = math.sqrt(radius ** 2 - ground ** 2)
    total_up = total_ahead = total_moment = slipped = greatest = dug = 0.0
    most = law.kappa * soil.janosi                            # the deepest that slip digs
    slips = abs(turns * radius - 1) / (turns * radius if law.j == "rim" else 1)   # how much j grows beyond rolling, for each metre of the way

    def rates_of(ahead, behind):
        rates = []
        for place, weight in GAUSS:
            x = (ahead + behind) / 2 - place * (ahead - behind) / 2
            down = math.sqrt(radius ** 2 - x * x)
            # The rim's velocity over the ground: the axle's 1 m/s and the turning. Backwards is what shears.
            back, fall = turns * down - 1, turns * x
            speed = (back * down + fall * x) / radius if law.stress == "surface" else back
            # The wheel passes a point of the ground at 1 m/s. A point of the rim moves with the turning.
            rates.append((x, down, speed if law.j == "ground" else speed / (turns * down)))
        return rates

    def dig(had, mobilised_way):
        return most - (most - had) * math.exp(-slips * mobilised_way / soil.janosi)

    def mobilised(here):
        return 1 - math.exp(-abs(here) / soil.janosi)

    def answer(x, down, here, greatest, dug, had):
        """Normal and shear stress, the greatest sinkage, and which branch of the law it is. had: what was dug at the step's beginning, where
        `greatest` is of."""
        p = down - ground - dug
        free = most > 0 and (most - (down - ground)) * slips * mobilised(here) > soil.janosi * x / down   # it would dig faster than it comes down
        if x >= 0:
            p = max(p, 0.0)
            bekker = (soil.kc / wheel.width + soil.kphi) * p ** soil.n < soil.stiffness * p
            normal, branch = soil.yields(p, wheel.width), ("yields", p > 1e-12, bekker, here > 0, free and p < 1e-12)
            return normal, soil.shear(normal, here), p, branch
        greatest = max(greatest - (dug - had), 0.0)           # what was pressed stays where it is
        bears = soil.yields(greatest, wheel.width)
        normal = min(max(soil.stiffness * (p - greatest) + bears, 0.0), bears)
        return normal, soil.shear(normal, here), greatest, ("elastic", normal > 0, here > 0)

    # Steps are short at the front and at the rear.
    edges = [front * math.cos(math.pi * k / panels) for k in range(panels + 1)]
    todo = [(ahead, behind) for ahead, behind in reversed(list(zip(edges, edges[1:])))]
    while todo:
        ahead, behind = todo.pop()
        length, rates = ahead - behind, rates_of(ahead, behind)
        all_of_it = sum(rate * weight / 2 for (_, _, rate), (_, weight) in zip(rates, GAUSS)) * length
        inside = ahead - 1e-9 * length
        speeds = [rate for _, _, rate in rates]
        slip_there = [slipped + partial(speeds, i) * length for i in range(len(rates))]
        mobilised_there = [mobilised(here) if most > 0 else 0.0 for here in slip_there]
        first = answer(inside, math.sqrt(radius ** 2 - inside ** 2), slipped, greatest, dug, dug)
        parts, branches = [], {first[3]}
        for i, (x, down, _) in enumerate(rates):
            normal, tangent, _, branch = answer(x, down, slip_there[i], greatest, dig(dug, partial(mobilised_there, i) * length) if most > 0 else 0.0, dug)
            branches.add(branch)
            parts.append((x, down, normal, tangent))
        digs = dig(dug, sum(m * weight / 2 for m, (_, weight) in zip(mobilised_there, GAUSS)) * length)
        last = answer(behind, math.sqrt(radius ** 2 - behind ** 2), slipped + all_of_it, greatest, digs, dug)
        if len(branches | {last[3]}) > 1 and length > 1e-9 * front:
            middle = (ahead + behind) / 2
            todo += [(middle, behind), (ahead, middle)]
            continue
        for (x, down, normal, tangent), (_, weight) in zip(parts, GAUSS):
            if law.stress == "surface":                       # per area of the rim, which is longer than its shadow
                level, up = (tangent * down - normal * x) / down, (normal * down + tangent * x) / down
            else:
                level, up = tangent, normal
            total_ahead += level * weight / 2 * length
            total_up += up * weight / 2 * length
            total_moment += (level * down + up * x) * weight / 2 * length
        slipped, greatest = slipped + all_of_it, last[2]
        dug = min(digs, math.sqrt(radius ** 2 - behind ** 2) - ground) if behind > 0 else digs
    return Answer(sinkage, total_up * wheel.width, total_ahead * wheel.width, total_moment * wheel.width)


def lagrange_integrals():
    """W[i][k]: half of the integral from -1 to node i of the polynomial that is 1 at node k and 0 at the others."""
    nodes = [x for x, _ in GAUSS]

    def base(k, t):
        return math.prod((t - x) / (nodes[k] - x) for i, x in enumerate(nodes) if i != k)

    return [[sum(w * base(k, -1 + (end + 1) * (x + 1) / 2) for x, w in GAUSS) * (end + 1) / 4 for k in range(len(nodes))] for end in nodes]


PARTIAL = lagrange_integrals()


def partial(values, i):
    """The integral of what has these values at the nodes, from a step's beginning to node i, as a share of the step's length."""
    return sum(map(operator.mul, PARTIAL[i], values))


# --- a load ---

def under_load(soil, wheel, load, slip, law=Law(), forces=by_angle):
    """The least sinkage at which the soil bears the load, and the forces there. None: nothing bears it to the axle."""
    low, high = 0.0, wheel.radius * 0.999
    step = wheel.radius / 64
    while step <= high and forces(soil, wheel, step, slip, law).fz < load:
        low, step = step, step * 1.25
    if step > high:
        return None
    high = step
    for _ in range(60):
        middle = (low + high) / 2
        if forces(soil, wheel, middle, slip, law).fz < load:
            low = middle
        else:
            high = middle
        if high - low < 1e-10:
            break
    return forces(soil, wheel, high, slip, law)


def main():
    wheel, worst = Wheel(0.32, 0.24), 0.0
    print("| soil | load N or sinkage mm | slip | stresses | j | sinkage mm | Fz N | Fx N | My N m | two quadratures apart |")
    print("|" + " --- |" * 10)
    cases = [("dry_sand", wheel, 1000, None, 0.2, Law()), ("dry_sand", wheel, 1000, None, 0.2, Law("ground", "rim")),
             ("dry_sand", wheel, 1000, None, 0.2, Law("ground", "ground")), ("dry_sand", wheel, 1000, None, 0.2, Law("surface", "ground"))]
    cases += [("chrono_soft", Wheel(0.5, 0.4), None, z, s, Law("ground", j)) for z in (0.1, 0.05) for s in (0, 0.2, 0.5) for j in ("rim", "ground")]
    cases += [(name, wheel, 1000, None, s, Law()) for name in ("lunar", "lete_sand", "snow_us", "sandy_loam_15") for s in (0.2, -0.2)]
    cases += [(name, wheel, 1000, None, s, Law(kappa=1.1)) for name in ("dry_sand", "lete_sand") for s in (0.2, 0.6)]
    for name, wheel, load, depth, slip, law in cases:
        soil = named(name)
        got = under_load(soil, wheel, load, slip, law) if load else by_angle(soil, wheel, depth, slip, law)
        apart = got.apart(by_way(soil, wheel, got.sinkage, slip, law))
        worst = max(worst, apart)
        print(f"| {name} | {load or depth * 1e3:g} | {slip:g} | {law.stress} | {law.j}{f', kappa {law.kappa:g}' if law.kappa else ''} | {got.sinkage * 1e3:.3f} | {got.fz:.2f} | "
              f"{got.fx:.2f} | {got.my:.2f} | {apart:.1e} |", flush=True)
    print(f"\nThe two quadratures differ by {worst:.1e} of the load at most; {'met' if worst < 1e-6 else 'MISSED'}: 1e-6.")
    return worst >= 1e-6


if __name__ == "__main__":
    raise SystemExit(main())
