#!/usr/bin/env python3
"""Soil that presses on every face of a body: the blend of scm and resistive force theory, in doubles, for benches and tests to hold the command to.

    python3 bench/faces_law.py                       # Ding's wheel, blades beside McKyes, the law's own anchors
    python3 bench/faces_law.py --measured FOLDER     # and the measured wheel: FOLDER has wheel_smooth.csv and wheel_grouser.csv

The ground is level, the drive is steady. Lengths are metres, forces newtons, angles radians unless a name says degrees; z is up.

3D-RFT: Agarwal, Goldman and Kamrin, PNAS 120 (2023), doi 10.1073/pnas.2214017120. Their local frame is not needed. With n the outward normal of a
facet and v the direction in which it moves, the generic stress is f1 n + f2 v - f3 up, where f1, f2, f3 are polynomials in -v_z, -n_z and n.v.
Two of the 60 numbers differ among public copies. The one that is used gives alpha_z(0, pi/2, 0) = 0.87574; others give 0.87504 and 1.056.
scm: Bekker, Janosi and Hanamoto, Wong and Reece, with slip digging as src/deform/SOIL.md has it.
Blades: McKyes, Soil Cutting and Tillage (1985): the passive wedge with weight, cohesion, adhesion and surcharge.
Friction of a surface: where none is given, two thirds of the soil's angle (Potyondy, Geotechnique 11 (1961): steel on sand 0.5 to 0.8 of it).

Chosen on the smooth wheel at 0 degrees: LIFT and POWER. Nothing else is fitted to the rig.
"""
import argparse
import csv
import math
import pathlib
from dataclasses import dataclass, replace

import numpy as np

LIFT = 0.55        # the share of the vertical stress that is left on a facet which moves level
POWER = 0.7        # w = q ** POWER
FOLLOW = 2.0       # soil follows a rim that spins by at most this many times the way
LEAST = 0.002      # below this q nothing of the faces is computed; walls are whole from LEAST + FADE
FADE = 0.05
RAMP = 0.1         # of n.v: over it walls begin to press, and soles cease
KAPPA = 1.26       # slip sinkage, Furrow's own fit
NARROW = 3.0       # a body is narrow where it is less wide than three times its depth
WALL = 0.19180     # generic pressure on an upright wall that moves level along its normal
PLATE = 0.87574    # and on a level plate that moves straight down

C = np.array([
    [.00212, -.02320, -.20890, -.43083, -.00259, .48872, -.00415, .07204, -.02750, -.08772,
     .01992, -.45961, .40799, -.10107, -.06576, .05664, -.09269, .01892, .01033, .15120],
    [-.06796, -.10941, .04725, -.06914, -.05835, -.65880, -.11985, -.25739, -.26834, .02692,
     -.00736, .63758, .08997, .21069, .04748, .20406, .18519, .04934, .13527, -.33207],
    [-.02634, -.03436, .45256, .00835, .02553, -1.31290, -.05532, .06790, -.16404, .02287,
     .02927, .95406, -.00131, -.11028, .01487, -.02730, .10911, -.04097, .07881, -.27519]])

UNDER, SIDE, BAR = 0, 1, 2


@dataclass
class Soil:
    weight: float          # N/m3
    phi: float             # degrees
    cohesion: float        # of scm's shear, Pa
    stiffness: float       # K_s of Bekker, N/m^(n+2)
    n: float
    janosi: float
    elastic: float = 4e7
    face_cohesion: float = 0.0    # of walls and blades, Pa; dry sand has none
    delta: float | None = None    # degrees, of the surface
    adhesion: float = 0.0

    @property
    def tan(self):
        return math.tan(math.radians(self.phi))

    @property
    def mu(self):
        return math.tan(math.radians(self.delta if self.delta is not None else 2 / 3 * self.phi))

    @property
    def xi(self):
        m = self.tan
        return self.weight * (894 * m ** 3 - 386 * m ** 2 + 89 * m)


# --- stress of a facet ---

def generic(n, v, mu, lift=LIFT):
    """Generic stress on facets, per xi_n and metre of depth. n: outward unit normals. v: velocities of any length. mu: of each facet or of all."""
    v = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-12)
    x, y, s = -v[:, 2], -n[:, 2], (n * v).sum(1)
    terms = np.stack([np.ones_like(x), x, y, s, x * x, y * y, s * s, x * y, y * s, s * x, x ** 3, y ** 3, s ** 3,
                      x * y * y, y * x * x, y * s * s, s * y * y, s * x * x, x * s * s, x * y * s])
    f1, f2, f3 = C @ terms
    a = f1[:, None] * n + f2[:, None] * v
    a[:, 2] -= f3
    inward = -(a * n).sum(1)
    t = a + inward[:, None] * n
    p = np.maximum(inward, 0)
    along = v - s[:, None] * n                                     # the motion along the facet; soil never pushes it on
    t -= (np.maximum((t * along).sum(1), 0) / np.maximum((along * along).sum(1), 1e-12))[:, None] * along
    t *= np.minimum(mu * p / np.maximum(np.linalg.norm(t, axis=1), 1e-12), 1)[:, None]
    a = t - p[:, None] * n
    a[:, 2] *= lift + (1 - lift) * np.abs(v[:, 2])
    return a


def wedge(rake, phi, delta):
    """McKyes' N of weight, cohesion, surcharge and adhesion, of the wedge whose N of weight is least. Radians; rake: of the face above the level."""
    b = np.linspace(0.01, math.pi / 2 - 0.01, 3000)

    def cot(angle):
        return 1 / np.tan(angle)
    below = np.cos(rake + delta) + np.sin(rake + delta) * cot(b + phi)
    above = cot(rake) + cot(b)
    weight = np.where((below > 1e-6) & (above > 0), above / (2 * np.where(below > 1e-6, below, 1)), np.inf)
    i = int(np.argmin(weight))
    b, below = b[i], below[i]
    return (weight[i], (1 + cot(b) * cot(b + phi)) / below, above[i] / below, (1 - cot(rake) * cot(b + phi)) / below)


class Walls:
    """Pressure of the passive wedge on a face, by its rake: per unit weight and depth, per cohesion, per adhesion. One table for two angles."""
    def __init__(self, phi, delta):
        self.rakes = np.radians(np.linspace(10, 90, 17))
        both = [wedge(r, phi, delta) for r in self.rakes]
        share = np.sin(self.rakes) * math.cos(delta)
        self.weight, self.cohesion, self.adhesion = (np.array([times * one[k] for one in both]) * share for k, times in ((0, 2), (1, 1), (3, 1)))

    def at(self, up):
        """up: the z of a face's normal, 0 upright .. 1."""
        rake = np.arccos(np.clip(up, 0, 1))
        return (np.interp(rake, self.rakes, column) for column in (self.weight, self.cohesion, self.adhesion))


WALLS = {}


def walls(soil):
    key = soil.phi, soil.mu
    if key not in WALLS:
        WALLS[key] = Walls(math.radians(soil.phi), math.atan(soil.mu))
    return WALLS[key]


def stress(soil, n, v, depth, mu, width, deepest, heap=0.0):
    """Pa on facets. depth: below the ground as the body found it. heap: mean height upon the wedge ahead. width: of the body across its way."""
    v = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-12)
    level = n.copy()
    level[:, 2] = np.minimum(n[:, 2], 0)
    long = np.linalg.norm(level, axis=1)
    level /= np.maximum(long, 1e-9)[:, None]
    up, y = np.clip(n[:, 2], 0, 1), np.clip(-n[:, 2], 0, 1)
    a = generic(level, v, mu)
    # A face that leans back: the wall's stress turned about the level line of the face, as strong as its wedge.
    table = walls(soil)
    weight, cohesive, sticky = table.at(up)
    upright = table.weight[-1]
    p, t = -(a * level).sum(1), a[:, 2].copy()
    rise = np.stack([-up * level[:, 0], -up * level[:, 1], np.hypot(n[:, 0], n[:, 1])], 1)        # up along the face
    leaning = -p[:, None] * n + t[:, None] * rise + a - t[:, None] * [0, 0, 1] + p[:, None] * level
    a = np.where((up > 0)[:, None], leaning, a)
    narrow = 1 / (1 + (width / (NARROW * max(deepest, 1e-9))) ** 4)
    under = (depth > 0)
    plain = soil.xi * depth
    of_weight = soil.weight * weight * (depth + heap) / WALL
    of_wall = np.maximum(narrow * plain * weight / upright + (1 - narrow) * of_weight,
                         of_weight + (soil.face_cohesion * cohesive + soil.adhesion * sticky) / WALL)
    of_sole = np.maximum(plain, 5.14 * soil.face_cohesion / PLATE)
    a = a * np.where(under, y * of_sole + (1 - y) * of_wall, 0)[:, None]
    if soil.adhesion > 0:                       # against the motion along the facet; soil that is pushed straight ahead slides up the face
        slid = v - (n * v).sum(1)[:, None] * n
        a += soil.adhesion * under[:, None] * ((1 - np.linalg.norm(slid, axis=1))[:, None] * rise - slid)
    return a


def blend(q):
    """The share of the faces in what a sole bears, and the share of walls that press."""
    return max((q - LEAST) / (1 - LEAST), 0.0) ** POWER, min(max((q - LEAST) / FADE, 0.0), 1.0)


def ramp(kind, n, v, w, walls_press=1.0, recent=None):
    """The share of a facet that presses. recent: its motion by the short memory, at most 1 long; on a steady way it changes nothing."""
    s = (n * v).sum(1) / np.maximum(np.linalg.norm(v, axis=1), 1e-12)
    if recent is not None:
        s = np.minimum(s, (n * recent).sum(1))
    return np.where(kind == UNDER, w * np.clip(1 + s / RAMP, 0, 1), walls_press * np.clip(s / RAMP, 0, 1))


def remembered(memory, step, length):
    """The memory of motion after a straight step: dM = (dx - M |dx|) / length. Of the long one the length is janosi, of the short one a twentieth."""
    way = np.linalg.norm(step)
    return step / way + (memory - step / way) * math.exp(-way / length) if way > 0 else memory


# --- a wheel on level ground ---

def wheel_facets(radius, width, around=180, across=6, rings=8):
    """Centres, outward normals, areas, kinds: axle along y, x ahead."""
    a, y = (grid.ravel() for grid in np.meshgrid((np.arange(around) + .5) * 2 * np.pi / around, ((np.arange(across) + .5) / across - .5) * width))
    out = np.stack([np.sin(a), 0 * a, -np.cos(a)], 1)
    parts = [(out * radius + y[:, None] * [0, 1, 0], out, np.full(len(a), 2 * np.pi * radius * width / len(a)), np.full(len(a), UNDER))]
    a, r = (grid.ravel() for grid in np.meshgrid((np.arange(around) + .5) * 2 * np.pi / around, (np.arange(rings) + .5) / rings * radius))
    for side in (-1, 1):
        parts.append((np.stack([r * np.sin(a), 0 * a + side * width / 2, -r * np.cos(a)], 1), np.tile([0., side, 0.], (len(a), 1)),
                      r * 2 * np.pi / around * radius / rings, np.full(len(a), SIDE)))
    return tuple(np.concatenate(part) for part in zip(*parts))


FACETS = {}


def share(along, aside, rim):
    """q: the share of the way that is slid. along, aside: of the way in the wheel's frame; rim: what it runs."""
    way = math.hypot(along, aside)
    roll = min(rim, max(along, 0.0))
    return min(math.hypot(along - roll, aside) / max(way, rim * along / max(way, 1e-12), 0.1 * rim), 1.0)


def scooped(soil, radius, width, bar, along, aside, rim):
    """How deep bars have taken the soil away, on a steady way. Between bars a wheel carries wedges, on average half as thick as the bars are high. So it takes
    a volume of bar b / 2 for each metre that it spins, and comes upon soil that is still there. The sides of the trench slide in at the friction angle."""
    spins = rim - min(rim, max(along, 0.0))
    volume = bar / 2 * spins / max(abs(along) + abs(aside) * radius / width, 1e-9)
    return 2 * volume / (1 + math.sqrt(1 + 4 * volume / (width * soil.tan)))


def scm_rim(soil, radius, width, sinkage, along, aside, rim, w, kappa, smooth, gone=0.0, panels=160):
    """Today's scm on a rim: force ahead, aside and up. smooth: what the rim below its bars runs. Slip digs by that. gone: how deep bars have scooped. That bears
    nothing, but the soil below it is sheared."""
    entry = math.acos(max(1 - sinkage / radius, -1))
    step = 2 * entry / panels
    theta = entry - (np.arange(panels) + .5) * step
    time = radius * step * min(1 / max(rim, 1e-12), 10 / max(along, 0.1 * math.hypot(along, aside)))   # the rim's time
    forth, across = (rim - along * np.cos(theta)) * time, np.full(panels, -aside * time)
    way = np.hypot(forth, across)
    stays = np.exp(-way / soil.janosi)
    spin, brake = max(smooth - along, 0), max(along - rim, 0)
    digs = math.hypot(spin + (1 - w) ** 2 * brake, (1 - w) * aside) * time                           # what is pushed is not dug
    e, dug, held, deep, most = np.zeros(2), 0.0, np.zeros((panels, 2)), np.zeros(panels), kappa * soil.janosi
    for i in range(panels):
        to = np.array([forth[i], across[i]]) / max(way[i], 1e-15)
        before, e = e, to + (e - to) * stays[i]
        held[i] = (before + e) / 2
        if theta[i] >= 0:
            dug = most - (most - dug) * math.exp(-math.hypot(*held[i]) * digs * math.cos(theta[i]) / soil.janosi)
            dug = min(dug, max(radius * (math.cos(theta[i]) - 1) + sinkage - gone, 0))
        deep[i] = dug

    def yields(z):
        z = np.maximum(z, 0)
        return np.minimum(soil.stiffness * z ** soil.n, soil.elastic * z)
    ahead = theta >= 0
    sigma = np.where(ahead, yields(radius * (np.cos(theta) - 1) + sinkage - gone - deep),
                     np.maximum(yields(np.array(sinkage - gone - dug)) - soil.elastic * radius * (1 - np.cos(theta)), 0))
    tau = np.where(sigma > 0, soil.cohesion + sigma * soil.tan, 0)
    s, c = np.sin(theta), np.cos(theta)
    forces = tau * held[:, 0] * c - sigma * s, tau * held[:, 1], sigma * c + tau * held[:, 0] * s
    return np.array([force.sum() for force in forces]) * radius * width * step


def wheel_force(soil, radius, width, bar, sinkage, way, angle, rim, kappa=KAPPA):
    """Force on a wheel: ahead in its plane, along its axle, up. bar: height of its bars, in the share in which they carry the soil; 0: smooth. way, rim (at
    the radius): m/s; angle: of the way, degrees. Bars make it a drum over their tips, which soil slides along on soil."""
    out = radius + bar
    smooth, rim = rim, rim * out / radius
    key = out, width
    if key not in FACETS:
        FACETS[key] = wheel_facets(out, width)
    place, n, area, kind = FACETS[key]
    c, s = (math.cos(math.radians(angle)), math.sin(math.radians(angle))) if angle != 90 else (0.0, 1.0)
    along, aside = way * c, way * s
    w, press = blend(share(along, aside, rim))
    gone = scooped(soil, out, width, bar, along, aside, rim)
    if sinkage <= gone:
        return np.zeros(3)
    turn = min(rim, FOLLOW * way) / out
    v = np.stack([along + turn * place[:, 2], np.full(len(place), aside), -turn * place[:, 0]], 1)
    lowest = place[:, 2] + out - sinkage
    depth = np.maximum(np.where(place[:, 0] * c + place[:, 1] * s > 0, 0, -sinkage) - lowest - gone, 0)      # behind: the rut's floor
    chord = 2 * math.sqrt(max(2 * out * sinkage - sinkage ** 2, 0)) if sinkage < out else 2 * out
    g = ramp(kind, n, v, w, press)
    on = (depth > 0) & (g > 0)
    mu = np.where((kind == UNDER) & (bar > 0), soil.tan, min(soil.mu, soil.tan))[on]
    f = (stress(soil, n[on], v[on], depth[on], mu, chord * s + width * c, sinkage) * (area * g)[on][:, None]).sum(0)
    if w < 1:
        f = f + (1 - w) * scm_rim(soil, out, width, sinkage, along, aside, rim, w, kappa, smooth, gone)
    return f


def under_load(load, most, force):
    """Sinkage and force where the vertical force is the load."""
    low, high = 1e-4, most
    for _ in range(16):
        middle = (low + high) / 2
        if force(middle)[2] < load:
            low = middle
        else:
            high = middle
    return middle, force(middle)


# --- the measured wheel ---

def trials_of(path):
    with open(path) as file:
        found = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    for trial in found:
        slip = trial["slip"]
        trial["rim"] = max(trial["way_mm_s"] * (1 + slip if slip < 0 else 1 / (1 - slip)), 0.0) * 1e-3
        same = [t["slip"] for t in found if t["rim_mm_s"] == trial["rim_mm_s"] and t["slip_angle_deg"] == trial["slip_angle_deg"]]
        trial["setting"] = sum(same) / len(same)
    return found


RIG = Soil(weight=13030, phi=29, cohesion=1000, stiffness=8e6, n=1.46, janosi=.021)


def rig_cell(trials, bar, soil=RIG, rows=None):
    """RMS of sinkage mm, drawbar N, side force N of trials, each under its own load."""
    apart = []
    for t in trials:
        own = replace(soil, n=1.46 + 0.01 * t["setting"])
        z, f = under_load(t["load_N"], .11, lambda h: wheel_force(own, .058, .05, bar, h, t["way_mm_s"] * 1e-3, t["slip_angle_deg"], t["rim"]))
        apart.append((z * 1e3 - t["sinkage_mm"], f[0] + t["drag_N"], abs(f[1]) - abs(t["lateral_N"])))
        if rows is not None:
            rows.append((t["setting"], t["load_N"], t["sinkage_mm"], z * 1e3, -t["drag_N"], f[0], abs(t["lateral_N"]), abs(f[1])))
    return np.sqrt((np.array(apart) ** 2).mean(0))


def rig(folder, soil=RIG, verbose=False):
    for name, file, bar in (("smooth", "wheel_smooth.csv", 0.0), ("bars", "wheel_grouser.csv", .005)):
        for angle in (0, 30, 90):
            rows = []
            cell = rig_cell([t for t in trials_of(folder / file) if t["slip_angle_deg"] == angle], bar, soil, rows)
            print(f"| {name} | {angle} | " + " | ".join(f"{x:.2f}" for x in cell) + " |", flush=True)
            if verbose:
                for setting in sorted({row[0] for row in rows}):
                    print("     ", np.round(np.mean([row for row in rows if row[0] == setting], 0), 1))


# --- Ding's wheel ---

def ding():
    import published_wheel as published
    soil = Soil(weight=1600 * 9.81, phi=31.9, cohesion=250, stiffness=15600 / published.WIDTH + 2407400, n=1.1, janosi=published.JANOSI[1])
    for name, points, bar in (("smooth", published.SMOOTH, 0.0), ("30 lugs", published.LUGGED, published.LUG_HEIGHT)):
        apart = []
        for slip, (sinkage, drawbar, _) in points.items():
            z, f = under_load(published.LOAD, .14, lambda h: wheel_force(soil, published.RADIUS, published.WIDTH, bar, h, .05, 0, .05 / (1 - slip)))
            apart.append((z * 1e3 - sinkage, f[0] - drawbar))
        print(f"| {name} | " + " | ".join(f"{x:.2f}" for x in np.sqrt((np.array(apart) ** 2).mean(0))) + " |")


# --- a blade ---

def blade_force(soil, width, deep, rake, heap=0.0, strips=40):
    """Force on the face of a blade that goes level along x: ahead, up. rake: degrees above the level."""
    rake = math.radians(rake)
    z = (np.arange(strips) + .5) / strips * deep
    n = np.tile([math.sin(rake), 0, math.cos(rake)], (strips, 1))
    v = np.tile([1., 0, 0], (strips, 1))
    f = (stress(soil, n, v, z, min(soil.mu, soil.tan), width, deep, heap) * ramp(np.full(strips, SIDE), n, v, 1)[:, None]).sum(0)
    return f * deep / strips / math.sin(rake) * width


def mckyes(soil, width, deep, rake, heap=0.0):
    rake, delta = math.radians(rake), math.atan(min(soil.mu, soil.tan))
    weight, cohesion, surcharge, adhesion = wedge(rake, math.radians(soil.phi), delta)
    force = width * deep * (soil.weight * (deep * weight + heap * surcharge) + soil.face_cohesion * cohesion + soil.adhesion * adhesion)
    return force * math.sin(rake + delta) + soil.adhesion * deep * width / math.tan(rake), -force * math.cos(rake + delta)


BLADES = (("dry_sand", Soil(16000, 28, 1040, 1.5e6, 1.1, .02)),
          ("sandy_loam_15", Soil(15000, 29, 1720, 1.5e6, .7, .02, face_cohesion=1720)),
          ("clayey_38", Soil(16000, 13, 4140, 7e5, .5, .02, face_cohesion=4140)),
          ("clayey_38, sticky", Soil(16000, 13, 4140, 7e5, .5, .02, face_cohesion=4140, adhesion=2070)),
          ("upland_loam", Soil(15000, 33.7, 3300, 2e6, 1.1, .02, face_cohesion=3300)))


def blades():
    worst = 0.0
    for name, soil in BLADES:
        for rake in (30, 45, 60, 75, 90):
            cells = []
            for deep in (.02, .05, .1, .2):
                for heap in (0, 1):
                    ratio = -blade_force(soil, 1, deep, rake, heap * deep)[0] / mckyes(soil, 1, deep, rake, heap * deep)[0]
                    worst = max(worst, abs(ratio - 1))
                    cells.append(f"{ratio:.2f}")
            print(f"| {name} | {rake} | " + " | ".join(cells) + " |")
    print(f"worst {worst:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--measured", type=pathlib.Path, help="the folder of wheel_smooth.csv and wheel_grouser.csv")
    parser.add_argument("--rows", action="store_true", help="each setting of the measured wheel")
    options = parser.parse_args()
    down, ahead = np.array([[0, 0, -1.]]), np.array([[1., 0, 0]])
    print(f"anchors: plate straight down {generic(down, down, 1)[0, 2]:.5f}, wall level {-generic(ahead, ahead, 1)[0, 0]:.5f}")
    if options.measured:
        print("| wheel | angle | sinkage RMS, mm | drawbar, N | side, N |\n| --- | --- | --- | --- | --- |")
        rig(options.measured, verbose=options.rows)
    print("| Ding | sinkage RMS, mm | drawbar, N |\n| --- | --- | --- |")
    ding()
    print("Blade of 1 m, drag beside McKyes: 2, 5, 10, 20 cm deep, each without a heap and with one as high as it is deep")
    print("| soil | rake | 2 | | 5 | | 10 | | 20 | |")
    blades()


if __name__ == "__main__":
    main()
