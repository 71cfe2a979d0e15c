#!/usr/bin/env python3
"""Closed motions of a foot in soil that presses on every face (faces_law.py): whether the soil gives energy.

    python3 bench/faces_energy.py [COUNT]      # 24 random motions of 1 to 60 mm take a minute

A body remembers its motion as Janosi's shear is mobilised, over the length K, and once more over K / 20. With both the soil gives nothing.
Without the short one a facet that backs off is still pressed for some millimetres, and some motions gain.
"""
import math
import sys

import numpy as np

import faces_law as law


def foot(side=.1, high=.15, across=5):
    """A box's facets: its sole is UNDER, all else SIDE."""
    cells = (np.arange(across) + .5) / across - .5
    a, b = (grid.ravel() for grid in np.meshgrid(cells, cells))
    parts, size = [], np.array([side, side, high])
    for axis in range(3):
        others = [k for k in range(3) if k != axis]
        for sign in (-1, 1):
            place, n = np.zeros((len(a), 3)), np.zeros((len(a), 3))
            place[:, axis], n[:, axis] = sign * size[axis] / 2, sign
            place[:, others[0]], place[:, others[1]] = a * size[others[0]], b * size[others[1]]
            kind = law.UNDER if axis == 2 and sign < 0 else law.SIDE
            parts.append((place, n, np.full(len(a), size[others[0]] * size[others[1]] / len(a)), np.full(len(a), kind)))
    return tuple(np.concatenate(part) for part in zip(*parts))


def closed_motions(soil, count, short=True):
    """How many of random closed motions of a foot give energy in their third round, and the greatest mean force that soil gives, N."""
    place, n, area, kind = foot()
    rng, gains, greatest = np.random.default_rng(1), 0, 0.0

    def force(long, recent, height):
        size = np.linalg.norm(long)
        w, press = law.blend(math.hypot(long[0], long[1]) / max(size, 1e-12))
        full = min(size, 1.0)
        v, depth = np.tile(long, (len(n), 1)), -(place[:, 2] + height)
        g = law.ramp(kind, n, v, full * w, full * press, np.tile(recent, (len(n), 1)) if short else None)
        on = (depth > 0) & (g > 0)
        if not on.any():
            return np.zeros(3)
        return (law.stress(soil, n[on], v[on], depth[on], min(soil.mu, soil.tan), .1, .075 - height) * (area * g)[on][:, None]).sum(0)
    for k in range(count):
        t, reach = np.linspace(0, 2 * np.pi, 60, endpoint=False), 10 ** rng.uniform(-3, -1.2)
        waves = np.stack([np.cos(t), np.sin(t), np.cos(2 * t), np.sin(2 * t)], 1)
        path = waves @ (rng.normal(size=(3, 4)) * [1, 1, .5, .3]).T
        path[:, 1:2 + (k % 3 == 0)] *= (k % 3 == 2)                 # to and fro along x, in a plane, in space
        path *= reach / np.abs(path).max()
        path[:, 2] += .02
        long = recent = np.zeros(3)
        for _ in range(3):
            work = way = 0.0
            for a, b in zip(path, np.roll(path, -1, 0)):
                parts = max(int(np.linalg.norm(b - a) / (soil.janosi / 60)), 1)
                for i in range(parts):
                    step, height = (b - a) / parts, a[2] + (b[2] - a[2]) * i / parts
                    before = force(long, recent, height)
                    long, recent = law.remembered(long, step, soil.janosi), law.remembered(recent, step, soil.janosi / 20)
                    work += (before + force(long, recent, height + step[2])) @ step / 2
                    way += np.linalg.norm(step)
        gains += work > 1e-9
        greatest = max(greatest, work / way)
    return gains, greatest


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 24
    for short in (False, True):
        gains, force = closed_motions(law.BLADES[0][1], count, short)
        print(f"{'With' if short else 'Without'} the short memory {gains} of {count} motions give energy, a mean force of at most "
              f"{max(force, 0):.3f} N.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
