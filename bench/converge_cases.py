"""What bench/converge.py drives: each case yields rows for its tables. A row has the worst and the mean over its lanes."""
import functools
import math

import lanes
import soil_forms
from converge_crests import crests

SOILS = {"dry_sand": 1000.0, "lunar": 1000.0, "lete_sand": 1000.0, "snow_us": 400.0, "sandy_loam_15": 1000.0}  # N
DIRECTIONS = (0.0, 22.5, 45.0)
COARSEST = 0.08
WHEEL, CHRONO_WHEEL = soil_forms.Wheel(0.32, 0.24), soil_forms.Wheel(0.5, 0.4)
CHRONO = ("bekker_kc: 0, bekker_kphi: 200000, bekker_n: 1.1, cohesion: 0, friction_angle: 30, janosi_shear: 0.01, "
          "elastic_stiffness: 4e7, damping: 0")


@functools.cache
def closed(soil, wheel, load, slip, law):
    return soil_forms.under_load(soil_forms.named(soil), wheel, load, slip, law)


@functools.cache
def closed_at(soil, wheel, sinkage, slip, law):
    return soil_forms.by_angle(soil_forms.named(soil), wheel, sinkage, slip, law)


class Bench:
    """The command, a scratch folder, and what the build can be asked."""

    def __init__(self, furrow, folder, extra="", soil_extra="", kappa=0.0, normals=None):
        self.furrow, self.folder, self.extra, self.soil_extra, self.kappa = furrow, folder, extra, soil_extra, kappa
        self.run = None  # run.json of the last drive
        self.has_normals = lanes.accepts(furrow, folder, "normals", "ground")
        self.normals = normals or ("surface" if self.has_normals else "ground")   # of a scene that says nothing of them
        # Chrono's law: no slip sinkage.
        self.chrono = ", normals: ground" * self.has_normals + ", slip_sinkage: 0" * lanes.accepts(furrow, folder, "slip_sinkage", "0")

    def drive(self, case_lanes, spacing, soil, redistribute="", coarsest=COARSEST, degrees=0.0):
        store = lanes.ground(self.furrow, self.folder, coarsest, degrees)
        driven = lanes.drive(self.furrow, store, self.folder, case_lanes, spacing, soil + self.soil_extra, redistribute + self.extra)
        self.run = driven.run
        return driven


def fan(places=((0.0, 0.0), (0.37, 0.29)), directions=DIRECTIONS, **keys):
    """Lanes in all directions, on the lattice and off it."""
    return [lanes.Lane(f"d{direction * 10:.0f}_{k}", direction=direction, shift=shift, **keys)
            for direction in directions for k, shift in enumerate(places)]


def wanted(answer):
    return {"sinkage": answer.sinkage, "drawbar": answer.fx, "torque": answer.my, "fz": answer.fz} if answer else None


def steady(bench, quick):
    """A wheel under its load in steady rolling, slip 0.2, with the default rim and without one."""
    law = soil_forms.Law(kappa=bench.kappa)
    spacings = (0.04, 0.02, 0.01) if quick else (0.08, 0.04, 0.02, 0.01, 0.005)
    for soil in list(SOILS)[:2] if quick else SOILS:
        for rim in ("default", "none"):
            for spacing in spacings:
                way = fan(load=SOILS[soil])
                driven = bench.drive(way, spacing, f"name: {soil}", "" if rim == "default" else ", bulldozing: 0")
                for lane in way:
                    found = lanes.steady(lane, driven, 1.0, 1.6)
                    found.update(lanes.rim(bench.furrow, driven, bench.folder, COARSEST, spacing, lane, 0.4, 1.0))
                    yield {"case": "steady", "soil": soil, "rim_of": rim, "spacing": spacing, "lane": lane.name, "load": lane.load,
                           "ms": driven.run["seconds"] * 1e3, "closed": wanted(closed(soil, WHEEL, lane.load, 0.2, law)), **found}


def vertical(bench, quick):
    """The same without a rim and slip sinkage, against the closed form of vertical normals, with the j of a point of the ground, as Project
    Chrono has it. A build without `normals` has these alone."""
    extra = ", bulldozing: 0" + bench.chrono
    for soil in list(SOILS)[:1 if quick else 2]:
        for spacing in (0.02, 0.01) if quick else (0.08, 0.04, 0.02, 0.01, 0.005):
            way = fan(load=SOILS[soil])
            driven = bench.drive(way, spacing, f"name: {soil}, damping: 0", extra)
            for lane in way:
                answer = closed(soil, WHEEL, lane.load, 0.2, soil_forms.Law("ground", "ground"))
                yield {"case": "vertical", "soil": soil, "rim_of": "none", "spacing": spacing, "lane": lane.name, "load": lane.load,
                       "closed": wanted(answer), **lanes.steady(lane, driven, 1.0, 1.6)}


def fixed(bench, quick):
    """Chrono's soft soil at a fixed sinkage, no rim, no damping: the axle at four places between posts, three slips. Vertical normals without
    slip sinkage, as Chrono has it; those of the surface with it."""
    places = [(p, q) for p, q in ((0, 0), (0.25, 0.4), (0.5, 0.5), (0.75, 0.1))]
    for normals in ("surface", "ground") if bench.has_normals else (bench.normals,):
        extra, kappa = ", bulldozing: 0" + bench.chrono * (normals == "ground"), bench.kappa * (normals == "surface")
        for spacing in (0.02,) if quick else (0.04, 0.02, 0.01):
            for sink in (0.1, 0.05):
                for slip in (0.0, 0.2, 0.5):
                    way = fan(places=places, radius=0.5, width=0.4, load=None, sink=sink, slip=slip)
                    driven = bench.drive(way, spacing, CHRONO, extra)
                    for lane in way:
                        row = {"case": "fixed", "normals": normals, "spacing": spacing, "sink": sink, "slip": slip, "lane": lane.name,
                               **lanes.steady(lane, driven, 1.0, 1.6)}
                        for j in ("rim", "ground"):
                            row[f"closed_{j}"] = wanted(closed_at("chrono_soft", CHRONO_WHEEL, sink, slip, soil_forms.Law(normals, j, kappa)))
                        yield row


HEAVY = [("chrono_soft", 2000.0), ("chrono_soft", 10000.0), ("dry_sand", 10000.0), ("snow_us", 2000.0), ("sandy_loam_15", 5000.0)]


def heavy(bench, quick):
    """Loads that a rim made unstable: r 0.5 m, b 0.4 m."""
    for soil, load in HEAVY[:1] if quick else HEAVY:
        for bulldozing in (0.5,) if quick else (0.5, 1.0):
            for spacing in (0.04, 0.02) if quick else (0.04, 0.02, 0.01):
                way = fan(places=((0.0, 0.0),), radius=0.5, width=0.4, load=load, length=2.4, speed=0.4)
                driven = bench.drive(way, spacing, CHRONO if soil == "chrono_soft" else f"name: {soil}", f", bulldozing: {bulldozing!r}")
                answer = closed(soil, CHRONO_WHEEL, load, 0.2, soil_forms.Law(kappa=bench.kappa))
                for lane in way:
                    yield {"case": "heavy", "soil": soil, "load": load, "bulldozing": bulldozing, "spacing": spacing, "lane": lane.name,
                           "closed": wanted(answer), **lanes.steady(lane, driven, 1.5, 2.4)}


def passes(bench, quick):
    """Ten wheels one behind the other in one rut, 800 N each."""
    count, gap = (4, 1.0) if quick else (10, 1.0)
    for direction in (0.0,) if quick else (0.0, 22.5):
        for spacing in (0.03, 0.015) if quick else (0.015, 0.0075):
            a, way = math.radians(direction), []
            for k in range(count):
                start = tuple(6.0 + (count - k) * gap * share for share in (math.cos(a), math.sin(a)))
                way.append(lanes.Lane(f"pass{k + 1}", load=800.0, direction=direction, start=start, length=gap * (k + 1) + 1.0))
            # All cross the same ground: from the first wheel's start on.
            driven = bench.drive(way, spacing, "name: dry_sand", coarsest=0.12)
            for k, lane in enumerate(way):
                yield {"case": "passes", "direction": direction, "spacing": spacing, "pass": k + 1, "load": 800.0,
                       **lanes.steady(lane, driven, gap * k + 0.4, gap * k + 0.9)}


LOADS = (1.0, 10.0, 100.0, 1000.0, 10000.0, 50000.0)


def loads(bench, quick):
    """fz against the load: twelve soils, 1 N to 50 kN, at posts of 2 cm."""
    names = [name for name in soil_forms.NAMED if name != "chrono_soft"]
    for soil in names[::4] if quick else names:
        way = [lanes.Lane(f"load{load:.0f}", radius=0.5, width=0.4, load=load, direction=22.5, length=1.0) for load in LOADS]
        driven = bench.drive(way, 0.02, f"name: {soil}")
        for lane in way:
            answer = closed(soil, CHRONO_WHEEL, lane.load, 0.2, soil_forms.Law(kappa=bench.kappa))
            row = driven.rows[lane.name][-1]
            yield {"case": "loads", "soil": soil, "load": lane.load, "carried": answer is not None, "closed": wanted(answer),
                   "state": row.get("state", ""), "residual": row.get("residual", ""), **lanes.steady(lane, driven, 0.5, 1.0)}


def slopes(bench, quick):
    """fz against the load on slopes up to 5 degrees below the friction angle: up, across and between."""
    for soil in ("dry_sand",) if quick else ("dry_sand", "lunar", "snow_us", "clayey_38"):
        steepest = soil_forms.named(soil).friction - 5
        for degrees in (steepest,) if quick else sorted({5.0, min(15.0, steepest), steepest}):
            way = [lanes.Lane(f"to{direction:.0f}", load=600.0 if soil != "snow_us" else 300.0, direction=direction, length=1.0)
                   for direction in (0.0, 22.5, 90.0, 180.0)]
            driven = bench.drive(way, 0.02, f"name: {soil}", degrees=degrees)
            for lane in way:
                row = driven.rows[lane.name][-1]
                found = lanes.steady(lane, driven, 0.5, 1.0)
                yield {"case": "slopes", "soil": soil, "degrees": degrees, "lane": lane.name, "load": lane.load, "fz": found["fz"],
                       "drawbar": found["drawbar"], "side": found["side"], "torque": found["torque"], "contact_area": float(row["contact_area"]),
                       "sinkage_told": float(row["sinkage"]), "state": row.get("state", ""), "residual": row.get("residual", "")}


def speeds(bench, quick):
    """Statics must not depend on the speed: posts of 2 cm, no rim."""
    for soil in ("dry_sand",) if quick else ("dry_sand", "snow_us"):
        for speed in (0.01, 10.0) if quick else (0.01, 0.1, 1.0, 2.0, 5.0, 10.0):
            way = fan(places=((0.0, 0.0),), load=SOILS[soil], speed=speed)
            driven = bench.drive(way, 0.02, f"name: {soil}", ", bulldozing: 0")
            answer = closed(soil, WHEEL, SOILS[soil], 0.2, soil_forms.Law(kappa=bench.kappa))
            for lane in way:
                yield {"case": "speeds", "soil": soil, "speed": speed, "lane": lane.name, "load": lane.load, "closed": wanted(answer),
                       **lanes.steady(lane, driven, 1.0, 1.6)}


def bears_over(soil, radius, width, load):
    """m: twice the sinkage of a round body over the slope of its rim where it enters the soil; for small sinkages that is how far ahead of the
    axle it does. The sinkage is Bekker's of a towed wheel; a sphere counts as one as wide as its radius. As in src/scene/scene_posts.c."""
    sinkage = (3 * load / (width * (soil.kc / width + soil.kphi) * (3 - soil.n) * math.sqrt(2 * radius))) ** (2 / (2 * soil.n + 1))
    sinkage = min(sinkage, 0.9 * radius)
    return 2 * sinkage * (radius - sinkage) / math.sqrt(sinkage * (2 * radius - sinkage))


POSTS_SPACINGS = (0.16, 0.08, 0.04, 0.02, 0.01)
BODIES = {"sphere": ("sphere: {radius: 0.2}", 0.2, 300.0), "box": ("box: {size: [0.4, 0.3, 0.3]}", 0.15, 300.0)}


def posts(bench, quick):
    """How far forces are off where few posts lie below a body: with the default rim a wheel and one a third as wide; without heaps a sphere and
    a box that are dragged. These are held to what they tell at 0.5 cm. With heaps a box climbs what it pushes, and is never steady."""
    for soil in list(SOILS)[:1] if quick else SOILS:
        for width, load in ((0.24, SOILS[soil]), (0.08, SOILS[soil] / 3)):
            wheel, law = soil_forms.Wheel(0.32, width), soil_forms.Law(kappa=bench.kappa)
            over = min(width, bears_over(soil_forms.named(soil), 0.32, width, load))
            for spacing in POSTS_SPACINGS:
                way = fan(load=load, width=width)
                driven = bench.drive(way, spacing, f"name: {soil}", coarsest=0.16)
                for lane in way:
                    yield {"case": "posts", "body": "wheel", "soil": soil, "posts": over / spacing, "spacing": spacing, "lane": lane.name, "load": load,
                           "closed": wanted(closed(soil, wheel, load, 0.2, law)), **lanes.steady(lane, driven, 1.0, 1.6)}
    for soil in ("dry_sand",) if quick else ("dry_sand", "lete_sand"):
        for body, (shape, high, load) in BODIES.items():
            over = 0.3 if body == "box" else bears_over(soil_forms.named(soil), high, high, load)
            finest = None
            for spacing in (0.005, *reversed(POSTS_SPACINGS)):
                way = fan(load=load, shape=shape, radius=high)
                driven = bench.drive(way, spacing, f"name: {soil}", ", bulldozing: 0, slip_sinkage: 0", coarsest=0.16)
                found = [lanes.steady(lane, driven, 1.0, 1.6) for lane in way]
                finest = finest or {key: sum(row[key] for row in found) / len(found) for key in ("sinkage", "drawbar", "torque", "fz")}
                for lane, row in zip(way, found) if spacing > 0.005 else ():
                    yield {"case": "posts", "body": body, "soil": soil, "posts": over / spacing, "spacing": spacing, "lane": lane.name, "load": load,
                           "closed": finest, **row}


CASES = {case.__name__: case for case in (steady, vertical, fixed, heavy, passes, loads, slopes, speeds, crests, posts)}
