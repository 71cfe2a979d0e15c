#!/usr/bin/env python3
"""What accuracy costs: each knob turned alone, and pairs of them. Error against the truth, ms a step, bytes; tables and plots.

    python3 bench/accuracy.py -o bench-out                          # a release build's programs; --quick: fewer settings
    python3 bench/accuracy.py -o bench-out --publish                # and into docs, README.md and bench/ACCURACY.md
    python3 bench/accuracy.py -o bench-out --from accuracy.jsonl    # of lines that are there

Writes accuracy.jsonl, accuracy.md and for each plot NAME.svg, .png and .gnuplot. bench/ACCURACY.md says how to read them.
"""
import argparse
import json
import pathlib
import shutil
import subprocess

import accuracy_plots
import accuracy_study
import pages

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
PROGRAMS = ("bench_accuracy", "bench_picture_error")
# What --publish copies to docs/accuracy-NAME.svg.
PUBLISHED = ("spacing", "offset_format", "pixel_error")
README_MODEL = "scm"  # whose spacings are README's table


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help="a release build (build)")
    parser.add_argument("-o", "--out", type=pathlib.Path, required=True, help="the folder for what is written")
    parser.add_argument("--from", dest="lines", type=pathlib.Path, action="append", help="a file of lines, instead of a run; repeatable")
    parser.add_argument("--quick", action="store_true", help="fewer settings, shorter runs")
    parser.add_argument("--publish", action="store_true", help="copies chosen plots to docs, rewrites the tables of README.md and ACCURACY.md")
    options = parser.parse_args()
    if options.publish and options.quick:
        parser.error("--publish: a whole run is published, not --quick")
    for program in () if options.lines else PROGRAMS:
        if not (options.build / "bench" / program).exists():
            parser.error(f"{options.build / 'bench' / program}: not there; meson setup build --buildtype=release && ninja -C build")
    return options


def measured(options, progress):
    """Lines as the programs print them."""
    count = 0
    for program in PROGRAMS:
        path = (options.build / "bench" / program).resolve()
        child = subprocess.Popen([str(path), *(["quick"] if options.quick else [])], stdout=subprocess.PIPE, text=True)
        try:
            for text in child.stdout:
                line = accuracy_study.parse(text, program)
                if line:
                    count += 1
                    knobs = ", ".join(f"{knob} {accuracy_study.value(knob, said)}" for knob, said in line["knobs"].items())
                    progress.show(count, None, f"{line['study']}: {knobs}")
                    yield line
        except BaseException:
            child.terminate()
            child.wait()
            raise
        if child.wait():
            raise pages.Told(f"{path} ended with {child.returncode}; run it by itself to see why")


def given(paths):
    for path in paths:
        try:
            text = path.read_text()
        except OSError as error:
            raise pages.Told(f"{path}: {error.strerror}; give a file of lines") from None
        for number, one in enumerate(text.splitlines(), 1):
            line = accuracy_study.parse(one, f"{path}:{number}") if one.strip() else None
            if line:
                yield line


def gather(options):
    """All lines; accuracy.jsonl is whole or not there."""
    lines, path, progress = [], options.out / "accuracy.jsonl", pages.Progress("accuracy")
    source = list(given(options.lines)) if options.lines else measured(options, progress)
    try:
        with pages.aside(path) as file:
            for line in source:
                lines.append(line)
                file.write(json.dumps({name: of for name, of in line.items() if of is not None}) + "\n")
                file.flush()
            if not lines:
                raise pages.Told("not one line of bench accuracy; give what bench_accuracy printed")
    except BaseException:
        progress.end()
        if lines:
            print(f"{path}.part: the {len(lines)} lines that there were")
        raise
    progress.end()
    return lines


def gl_of(lines):
    return ", ".join(dict.fromkeys(line["gl"] for line in lines if line.get("gl")))


def report(studies, lines):
    parts = ["Filled points of the plots, ● in the tables: no other setting of the study is both as exact and as quick.\n"]
    for study in studies:
        parts.append(f"### {study.title}\n\nTurned: {study.what}.\n\n" + pages.table(*accuracy_study.rows(study)))
    return "\n".join(parts) + f"\nGL: {gl_of(lines)}.\n"


def readme_table(studies, lines):
    """Spacings of one model, beside those of the others in time."""
    study = next((study for study in studies if study.study == "spacing"), None)
    if study is None:
        raise pages.Told("no study of spacing, which README shows; run without --from, or give its lines too")
    models = list(dict.fromkeys(line["knobs"].get("model") for line in study.lines))
    model = README_MODEL if README_MODEL in models else models[0]
    rows = []
    for line in study.lines:
        if line["knobs"].get("model") == model:
            rows.append([accuracy_study.value("spacing", line["knobs"]["spacing"]),
                         pages.figure(accuracy_study.millimetres(line, "rms")), pages.figure(accuracy_study.millimetres(line, "max")),
                         pages.figure(line["ms_step"]), pages.size(line["bytes"])])
    return pages.table([f"`{model}`, spacing", "error, RMS, mm", "max", "ms a step", "bytes"], rows) + f"\n{gl_of(lines)}.\n"


def write_plots(options, studies):
    accuracy_plots.gnuplot()
    written = []
    for study in studies:
        for name, script in accuracy_plots.plots(study):
            written += accuracy_plots.draw(options.out, name, script)
    return written


def publish(options, studies, lines):
    for name in PUBLISHED:
        source = options.out / f"{name}.svg"
        if not source.exists():
            raise pages.Told(f"{source}: not drawn, since its study is not in the lines; run without --from, or give them too")
    for name in PUBLISHED:
        shutil.copyfile(options.out / f"{name}.svg", ROOT / "docs" / f"accuracy-{name}.svg")
    pages.publish(HERE / "ACCURACY.md", "accuracy", report(studies, lines))
    pages.publish(ROOT / "README.md", "accuracy", readme_table(studies, lines))
    print("docs/accuracy-*.svg, bench/ACCURACY.md, README.md: of this run now")


def run():
    options = parse()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = gather(options)
    studies = accuracy_study.studies(lines)
    text = report(studies, lines)
    with pages.aside(options.out / "accuracy.md") as file:
        file.write(text)
    print(text)
    print(f"{options.out / 'accuracy.jsonl'}, {options.out / 'accuracy.md'}: {len(lines)} settings, {len(studies)} studies")
    written = write_plots(options, studies)
    print("\n".join(f"{path}" for path in written))
    if options.publish:
        publish(options, studies, lines)


if __name__ == "__main__":
    pages.main(run)
