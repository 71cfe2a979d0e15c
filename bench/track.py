#!/usr/bin/env python3
"""The same step after 40 km of track as after 40 m, in the same memory: one wheel under scm, with rim and forces, straight
over a strip. usage: track.py FURROW [--km 40] [--spacing 0.0625] [--runs 1]; JSON lines and a table."""
import argparse, json, os, subprocess, tempfile

import record

SCENE = """scene: 1
time_step: %(step)r
end_time: %(end)r
spacing: %(spacing)r
soil: {name: dry_sand}
redistribute: {model: scm, bulldozing: 0.5}
objects:
  - {name: wheel, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, slip: 0.2,
     path: {points: [[20, 64], [%(to)r, 64]], speed: 2}}
output: {forces: 1}
cache: {slots: 64, loaders: 2, prefetch: 1.5}
"""


def drive(furrow, store, folder, metres, spacing):
    scene = os.path.join(folder, 'track.yaml')
    with open(scene, 'w') as file:
        file.write(SCENE % dict(step=spacing / 2, end=metres / 2, spacing=spacing, to=20.0 + metres))
    subprocess.run([furrow, 'reset', store], check=True, stdout=subprocess.DEVNULL)
    out = os.path.join(folder, 'out')
    subprocess.run([furrow, 'drive', scene, '--store', store, '-o', out], check=True, stdout=subprocess.DEVNULL)
    run = json.load(open(os.path.join(out, 'run.json')))
    info = json.loads(subprocess.run([furrow, 'info', store, '--json'], check=True, capture_output=True, text=True).stdout)
    return {'bench': 'track', 'metres': metres, 'posts_m': spacing, 'step_ms': run['step_ms']['p50'], 'mean_ms': run['seconds'] * 1e3 / run['steps'],
            'p99_ms': run['step_ms']['p99'], 'rss': run['memory']['rss_peak'], 'gpu_bytes': run['memory']['gpu_bytes'],
            'stalls': run['cache']['stalls'], 'soil_bytes': info['bytes']['offset'] + info['bytes']['soil'], 'gl': run['gl']['renderer']}


def keep(kept, rows):
    for metres in sorted({row['metres'] for row in rows}):
        of = [row for row in rows if row['metres'] == metres]
        for key, name, unit, scale in (('step_ms', 'p50', 'ms', 1), ('mean_ms', 'mean', 'ms', 1), ('p99_ms', 'p99', 'ms', 1), ('rss', 'rss_peak', 'MB', 1e-6),
                                       ('soil_bytes', 'soil', 'MB', 1e-6)):
            kept.add('m%g.%s' % (metres, name), [row[key] * scale for row in of], unit)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('furrow')
    parser.add_argument('--km', type=float, default=40)
    parser.add_argument('--spacing', type=float, default=0.0625)
    parser.add_argument('--runs', type=int, default=1)
    record.add_option(parser)
    args = parser.parse_args()
    kept = record.Record('track', args.furrow)
    with tempfile.TemporaryDirectory() as folder:
        store = os.path.join(folder, 'strip.furrow')
        posts = int(args.km * 1000) + 60
        subprocess.run([args.furrow, 'synth', '-o', store, '--posts', '%dx129' % posts, '--spacing', '1', '--kind', 'plain',
                        '--relief', '1'], check=True, stdout=subprocess.DEVNULL)
        rows = []
        for _ in range(args.runs):
            for metres in (40.0, 400.0, args.km * 1000):
                rows.append(drive(args.furrow, store, folder, metres, args.spacing))
                print(json.dumps(rows[-1]), flush=True)
    kept.renderer = rows[-1]['gl']
    keep(kept, rows)
    kept.write(args.figures)
    print('%10s %9s %9s %9s %9s %12s' % ('track m', 'p50 ms', 'mean ms', 'p99 ms', 'RSS MB', 'soil MB'))
    for row in rows:
        print('%10g %9.3f %9.3f %9.3f %9.0f %12.2f' % (row['metres'], row['step_ms'], row['mean_ms'], row['p99_ms'],
                                                      row['rss'] / 1e6, row['soil_bytes'] / 1e6))


if __name__ == '__main__':
    main()
