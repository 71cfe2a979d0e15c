"""Writes the controls of quadruped.yaml: a trot. Diagonal legs swing together; feet go back at one speed while they stand."""
import math, sys

THIGH = SHANK = 0.2   # m
STANDS, PERIOD = 0.5, 0.5  # s: before it walks; of a step of all legs
STEP, LIFT = 0.13, 0.09    # m
HEIGHT = 0.4 * math.cos(0.75)  # m: of the hips above the feet, as in the keyframe home
LEGS = (("front_left", 0), ("front_right", 0.5), ("rear_left", 0.5), ("rear_right", 0))


def angles(x, z):
    """The thigh's and the knee's angle with the foot x ahead of the hip and z below it."""
    reach = math.hypot(x, z)
    knee = -2 * math.acos(min(reach / (THIGH + SHANK), 1))
    return math.atan2(-x, z) - knee / 2, knee


def foot(phase, size):
    """Where a foot is. phase: 0 to 0.5 it swings forward, then it stands and goes back. size: 0 to 1."""
    if phase < 0.5:
        turn = 2 * math.pi * phase / 0.5
        return size * STEP * (phase / 0.5 - 0.5 - math.sin(turn) / (2 * math.pi)), HEIGHT - size * LIFT * (1 - math.cos(turn)) / 2
    return size * STEP * (1.5 - phase / 0.5), HEIGHT


def main():
    end, every = float(sys.argv[1]) if len(sys.argv) > 1 else 8, 0.02
    print("t," + ",".join(f"{joint}_{leg}" for leg, _ in LEGS for joint in ("hip", "thigh", "knee")))
    for step in range(round(end / every) + 1):
        t = step * every
        size = min(max((t - STANDS) / PERIOD, 0), 1)
        row = [f"{t:.2f}"]
        for _, shift in LEGS:
            thigh, knee = angles(*foot((t / PERIOD + shift) % 1, size))
            row += ["0", f"{thigh:.4f}", f"{knee:.4f}"]
        print(",".join(row))


main()
