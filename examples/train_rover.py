#!/usr/bin/env python3
"""Trains a small policy to drive a rover out of a sand pit, by the cross-entropy method, on the CPU. Minutes on two quiet cores.

    python3 examples/train_rover.py                  # curve.csv, curve.png (with matplotlib), policy.npy
    python3 examples/train_rover.py --show policy.npy    # drives with it: policy.png, the rover at the end

In each round 12 policies drive at once, each in a world of its own. The best three say around which numbers the next round draws. All of a round have the
same goal and the same heaps, and each round has others. Needs gymnasium (pip install 'furrow[gym]').
"""
import argparse
import csv

import numpy as np
import gymnasium

import furrow.gym  # registers the environments

FEATURES = 3  # of the observation, see features()
STEPS = {"time_step": 0.004, "frame_skip": 20}  # 80 ms an action


def features(observations):
    """What the policy sees, n x FEATURES: cosine and sine of the goal's direction, and 1."""
    return np.stack([observations[:, 1], observations[:, 2], np.ones(len(observations))], axis=1)


def actions(policies, observations):
    """policies: n x 2 x FEATURES, or one of them for all. Returns n x 2: speed and curvature."""
    return np.tanh(np.einsum("...aj,...j->...a", policies, features(observations))).astype(np.float32)


def returns(envs, policies, seed, longest):
    """Drives an episode with each policy. Returns the sums of their rewards, and which reached the goal."""
    observations, _ = envs.reset(seed=[seed] * envs.num_envs)
    total, driving, reached = np.zeros(envs.num_envs), np.ones(envs.num_envs, bool), np.zeros(envs.num_envs, bool)
    for _ in range(longest):
        observations, rewards, ended, _, infos = envs.step(actions(policies, observations))
        total += np.where(driving, rewards, 0)
        reached |= driving & infos.get("reached", np.zeros(envs.num_envs, bool))
        driving &= ~ended
        if not driving.any():
            break
    return total, reached


def train(options):
    envs = gymnasium.make_vec("furrow/SandPit-v0", num_envs=options.policies, max_episode_steps=None, **STEPS)
    random = np.random.default_rng(options.seed)
    mean, spread = np.zeros((2, FEATURES)), np.full((2, FEATURES), 1.0)
    rows = []
    for number in range(options.rounds):
        policies = mean + spread * random.standard_normal((options.policies, 2, FEATURES))
        policies[0] = mean
        total, reached = returns(envs, policies, 1000 + number, options.actions)
        best = np.argsort(-total)[:options.policies // 4]
        mean, spread = policies[best].mean(axis=0), policies[best].std(axis=0) + 0.3 * 0.9 ** number
        rows.append((number, total.mean(), total.max(), total[0], int(reached.sum())))
        print("round %d: mean %.2f, best %.2f, of the mean policy %.2f, %d reached the goal" % rows[-1], flush=True)
        np.save(options.policy, mean)
        with open("curve.csv", "w", newline="", encoding="ascii") as file:
            csv.writer(file).writerows([("round", "mean", "best", "of_the_mean_policy", "reached"), *rows])
    envs.close()
    plot(np.array(rows), options.policies)


def plot(rows, count):
    try:
        import matplotlib
    except ImportError:
        print("curve.png is not drawn: the Python package matplotlib is not installed")
        return
    matplotlib.use("agg")
    from matplotlib.figure import Figure
    figure = Figure(figsize=(6, 3.6), layout="constrained")
    axes = figure.subplots()
    axes.plot(rows[:, 0], rows[:, 2], label="best of a round", color="#2a7")
    axes.plot(rows[:, 0], rows[:, 1], label=f"mean of its {count} policies", color="#27a")
    axes.set(xlabel="round", ylabel="sum of rewards", title="A rover learns to leave a sand pit")
    axes.legend(loc="lower right")
    figure.savefig("curve.png", dpi=110)


def show(options):
    env = gymnasium.make("furrow/SandPit-v0", render_mode="rgb_array", **STEPS)
    policy = np.load(options.show)
    observation, info = env.reset(seed=options.seed)
    ended = truncated = False
    count = 0
    while not (ended or truncated):
        observation, _, ended, truncated, info = env.step(actions(policy, observation[None])[0])
        count += 1
    print(f"{count} actions; {'at the goal' if info['reached'] else 'not at the goal'}, {info['distance']:.2f} m away")
    from matplotlib import image
    image.imsave("policy.png", env.render())
    env.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--policies", type=int, default=12)
    parser.add_argument("--actions", type=int, default=80, help="of an episode in training; 80 ms each")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--policy", default="policy.npy", help="file for the policy")
    parser.add_argument("--show", metavar="POLICY", help="drive with a policy that was trained")
    options = parser.parse_args()
    if options.show:
        show(options)
    else:
        train(options)


if __name__ == "__main__":
    main()
