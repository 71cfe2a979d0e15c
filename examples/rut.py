"""Makes a rut, reads it as an array, and plots it.

    furrow synth -o plain.furrow --kind plain --posts 257x257 --spacing 0.25 --relief 2
    python3 rut.py plain.furrow rut.furrow rut.png

The ruts are kept in rut.furrow, an overlay; plain.furrow is only read. Without a third argument a window shows the plot, where
there is a screen. Without matplotlib the figures are printed and nothing is plotted.
"""
# %% A world: soil of the Moon, posts every 31 mm where something drives
import os
import sys

import numpy as np

import furrow

if len(sys.argv) not in (3, 4):
    sys.exit("usage: rut.py STORE OVERLAY [PNG]")
store, overlay, png = sys.argv[1], sys.argv[2], sys.argv[3] if len(sys.argv) == 4 else None
scene = {"spacing": 0.03125, "soil": {"name": "lunar"}, "redistribute": {"model": "scm"}}
world = furrow.World(scene, store=store, overlay=overlay)

# %% A wheel that sinks 3 cm and drives 2 m to the east, at 20 % slip
RADIUS, SPEED, SLIP, SINKAGE, STEP = 0.25, 0.5, 0.2, 0.03, 0.02
x, y = world.info.extent / 2
wheel = world.add(shape={"wheel": {"radius": RADIUS, "width": 0.2, "grousers": 18}})
ground = world.points([(x, y)])["height"][0]
wheel.place(position=(x, y, ground + RADIUS))

path = np.arange(0, 2, SPEED * STEP)
heights = world.points(np.column_stack([x + path, np.full_like(path, y)]))["height"] - SINKAGE + RADIUS
turns = path / (RADIUS * (1 - SLIP))
pulls = []
for way, z, turn in zip(path, heights, turns):
    wheel.set(position=(x + way, y, z), orientation=(np.cos(turn / 2), 0, np.sin(turn / 2), 0),
              linear=(SPEED, 0, 0), angular=(0, SPEED / (RADIUS * (1 - SLIP)), 0))
    world.step(STEP)
    pulls.append(wheel.contact.force[0])

# %% The rut as an array
patch = world.read("offset", x=x - 0.5, y=y - 0.5, width=3, height=1)
print(f"posts: {patch.shape[0]} x {patch.shape[1]}")
print(f"deepest: {-patch.min():.4f} m")
print(f"highest heap: {patch.max():.4f} m")
print(f"drawbar pull, mean of the last half: {np.mean(pulls[len(pulls) // 2:]):.1f} N")
world.close()

# %% A plot
try:
    import matplotlib
except ImportError:
    print("matplotlib is not installed; nothing is plotted")
    sys.exit(0)
headless = not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
if headless or png:
    matplotlib.use("Agg")
import matplotlib.pyplot as plt

figure, (above, below) = plt.subplots(2, 1, figsize=(8, 6), constrained_layout=True)
image = above.imshow(patch * 1000, origin="lower", extent=(-0.5, 2.5, -0.5, 0.5), cmap="RdBu_r",
                     vmin=-1000 * np.abs(patch).max(), vmax=1000 * np.abs(patch).max())
figure.colorbar(image, ax=above, label="mm")
above.set(title="what the wheel left", xlabel="east, m", ylabel="north, m")
below.plot(path, pulls)
below.set(xlabel="way, m", ylabel="drawbar pull, N")
if headless or png:
    figure.savefig(png or "rut.png", dpi=120)
    print(f"plot: {png or 'rut.png'}")
else:
    plt.show()
