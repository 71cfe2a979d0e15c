#!/usr/bin/env python3
"""What accuracy costs: each knob turned alone, and pairs of them. Error against the truth, time, bytes; force against time; tables and plots.

    python3 bench/accuracy.py -o bench-out                          # a release build's programs; --quick: fewer settings, two runs, minutes
    python3 bench/accuracy.py -o bench-out --publish                # and into README, docs (BENCHMARKS.md) and bench/ACCURACY.md
    python3 bench/accuracy.py -o bench-out --knobs                  # what the command measures alone: forces, bodies, vehicles, the cache
    python3 bench/accuracy.py -o bench-out --from accuracy.jsonl    # of lines that are there
    python3 bench/accuracy.py -o bench-out --sheet                  # the study of the elastic sheet alone, a part of ACCURACY.md of its own; to publish it:
    python3 bench/accuracy.py --build build -o build/bench-out --sheet --publish --figures bench/figures/accuracy_sheet.json

Writes accuracy.jsonl, accuracy.md and for each plot NAME.svg, .png and .gnuplot. bench/ACCURACY.md says how to read them.
"""
import argparse
import itertools
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading

import accuracy_knobs
import accuracy_plots
import accuracy_study
import pages
import record

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
PROGRAMS = ("bench_accuracy", "bench_picture_error")
# What --publish copies to docs/accuracy-NAME.svg, and how a page names it. The first is README's, the second BENCHMARKS.md's.
PUBLISHED = {
    "force": "Error of drawbar against time a metre, of a wheel, a wheel with bars and a blade, by spacing, with the Pareto fronts and the spread of five runs",
    "spacing": "Error against the time of a step, by model and spacing, with the Pareto fronts and the default",
    "force_soft": "Error of drawbar against time a metre, beside Project Chrono's SCM at another time, each against its own truth",
    "pairs_spacing_iterations": "Error against the time of a step, by spacing and iterations of sliding",
    "offset_format-bytes": "Error against bytes, by the format of the offset",
    "import_error-bytes": "Error against the store's bytes, by the import's error",
    "pixel_error": "How like the finest picture, against the time of a frame, by pixel error",
}


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help="a release build (build)")
    parser.add_argument("-o", "--out", type=pathlib.Path, required=True, help="the folder for what is written")
    parser.add_argument("--from", dest="lines", type=pathlib.Path, action="append", help="a file of lines, instead of a run; repeatable")
    parser.add_argument("--quick", action="store_true", help="fewer settings, shorter runs")
    parser.add_argument("--sheet", action="store_true", help="the study of the elastic sheet alone")
    parser.add_argument("--knobs", action="store_true", help="the studies of forces, bodies, vehicles and the cache alone")
    parser.add_argument("--publish", action="store_true", help="copies chosen plots to docs, rewrites README's plot and the tables of BENCHMARKS.md and ACCURACY.md")
    record.add_option(parser)
    options = parser.parse_args()
    if options.figures and (options.lines or not options.publish):
        parser.error("--figures: has the parts of the pages, of this run; give --publish with it, and no --from")
    if options.publish and options.quick:
        parser.error("--publish: a whole run is published, not --quick")
    if options.knobs and (options.sheet or options.publish):
        parser.error("--knobs: has a part of the studies alone; leave --sheet and --publish away")
    for program in () if options.lines else (*map("bench/".__add__, programs_of(options)), *["tools/furrow"] * (not options.sheet)):
        if not (options.build / program).exists():
            parser.error(f"{options.build / program}: not there; meson setup build --buildtype=release && ninja -C build tools/furrow " + " ".join(map("bench/".__add__, PROGRAMS)))
    return options


def programs_of(options):
    return () if options.knobs else PROGRAMS[:1] if options.sheet else PROGRAMS


def listen(child, progress):
    """A program says on stderr what it is about to do, "STUDY {KNOBS}"; anything else is for the person."""
    count = 0
    for text in child.stderr:
        if re.fullmatch(r"\w+ \{.*\}\n", text):
            count += 1
            progress.show(count, None, text.strip())
        elif not text.startswith("furrow: note: "):  # on the bench's own scenes
            progress.end()
            sys.stderr.write(text)


def measured(options, progress):
    """Lines as the programs print them."""
    quick = ["--quick"] * options.quick
    arguments = {"bench_accuracy": ["sheet"] * options.sheet + ["--truth", str(options.out / "accuracy.truth"), *quick], "bench_picture_error": quick}
    for program in programs_of(options):
        path = (options.build / "bench" / program).resolve()
        child = subprocess.Popen([str(path), *arguments[program]], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        listener = threading.Thread(target=listen, args=(child, progress))
        listener.start()
        try:
            for text in child.stdout:
                line = accuracy_study.parse(text, program)
                if line:
                    yield line
            child.wait()
        finally:
            child.terminate()  # nothing, of one that has ended
            child.wait()
            listener.join()
        if child.returncode:
            raise pages.Told(f"{path} ended with {child.returncode}, see above; with {options.out / 'accuracy.jsonl.part'} --from shows "
                             "what there is")


def by_the_command(options, progress):
    """Lines of accuracy_knobs.py."""
    count = 0

    def tell(study, knobs):
        nonlocal count
        count += 1
        progress.show(count, None, f"{study} {json.dumps(knobs)}")
    if options.sheet:
        return
    with tempfile.TemporaryDirectory() as folder:
        runs = 2 if options.quick else accuracy_study.RUNS
        for made in accuracy_knobs.measured((options.build / "tools" / "furrow").resolve(), folder, runs, options.quick, tell):
            yield accuracy_study.parse(json.dumps(made), "accuracy_knobs")


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


def lines_of(options):
    return "accuracy_sheet.jsonl" if options.sheet else "accuracy.jsonl"


def gather(options):
    """All lines; accuracy.jsonl is whole or not there."""
    lines, path, progress = [], options.out / lines_of(options), pages.Progress("accuracy")
    source = list(given(options.lines)) if options.lines else itertools.chain(measured(options, progress), by_the_command(options, progress))
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


def truths_of(study):
    found = study.truths()
    if all(text.startswith("of ") for text in found):
        return ""
    return "Truth: " + "; ".join(found) + "." + " None is compared with a point of another truth." * (len(found) > 1)


def report(studies, lines):
    parts = ["Filled points of the plots, ● in the tables: no setting that is as exact is as quick, in any of its runs. `runs`: how many, the quickest and the slowest.\n"]
    for study in studies:
        parts.append(f"### {study.title}\n\nTurned: {study.what}. {truths_of(study)}\n\n" + pages.table(*accuracy_study.rows(study)))
    return "\n".join(parts) + f"\nGL: {gl_of(lines)}.\n"


def spacing_table(studies, lines):
    """Spacings by model: error and time."""
    study = next((study for study in studies if study.study == "spacing"), None)
    if study is None:
        raise pages.Told("no study of spacing, which docs/BENCHMARKS.md shows; run without --from, or give its lines too")
    models = list(dict.fromkeys(line["knobs"]["model"] for line in study.lines))
    found = {}
    for line in study.lines:
        cell = f"{pages.figure(accuracy_study.millimetres(line, 'rms'))} / {pages.figure(line['ms_step'])}"
        found.setdefault(line["knobs"]["spacing"], {})[line["knobs"]["model"]] = f"**{cell}**" if line["default"] else cell
    rows = [[accuracy_study.value("spacing", spacing), *(cells.get(model, "-") for model in models)] for spacing, cells in found.items()]
    return pages.table(["RMS error, mm / ms a step", *(f"`{model}`" for model in models)], rows) + \
        f"\n**Bold**: the default of the bench's other studies. {gl_of(lines)}.\n"


def write_plots(options, studies):
    accuracy_plots.gnuplot()
    written = []
    for study in studies:
        for name, script in accuracy_plots.plots(study):
            written += accuracy_plots.draw(options.out, name, script)
    return written


def picture(name, folder):
    return f"![{PUBLISHED[name]}]({folder}accuracy-{name}.svg)\n"


def show_in_readme(path, shown):
    """A line without markers, since README is short: in place of the one that is there, or before the limits."""
    text = path.read_text()
    changed, count = re.subn(r"(?m)^!\[[^\]\n]*\]\(docs/accuracy-\w+\.svg\)\n", lambda _: shown, text)
    if count == 0:
        changed, count = text.replace("\n## Limits\n", f"\n{shown}\n## Limits\n"), text.count("\n## Limits\n")
    if count != 1:
        raise pages.Told(f"{path}: no one place for its plot; have one heading `## Limits`, and at most one plot of accuracy")
    with pages.aside(path) as file:
        file.write(changed)


def publish(options, studies, lines, written, kept):
    """kept: the record; None for lines of an earlier run, whose machine nobody knows."""
    few = [line for line in lines if not line.get("source") and len(line["ms_runs"]) < accuracy_study.RUNS]
    if few:
        raise pages.Told(f"{few[0]['study']} {few[0]['knobs']}: {len(few[0]['ms_runs'])} runs; {accuracy_study.RUNS} are published, so run without --quick")
    for name in PUBLISHED:
        source = options.out / f"{name}.svg"
        if source not in written:
            raise pages.Told(f"{source}: not drawn, since its study is not in the lines; run without --from, or give them too")
    for name in PUBLISHED:
        shutil.copyfile(options.out / f"{name}.svg", ROOT / "docs" / f"accuracy-{name}.svg")
    readme, first, *_ = PUBLISHED
    pictures = "\n".join(picture(name, "../docs/") for name in PUBLISHED)
    for page, text in (("bench/ACCURACY.md", pictures + "\n" + report(studies, lines)),
                       ("docs/BENCHMARKS.md", picture(first, "") + "\n" + spacing_table(studies, lines))):
        pages.publish(ROOT / page, "accuracy", text)
        if kept is not None:
            kept.page(f"{page} accuracy", text)
    show_in_readme(ROOT / "README.md", picture(readme, "docs/"))
    if kept is not None:
        kept.renderer = gl_of(lines)
        kept.write(options.figures)
    print("README.md, docs/accuracy-*.svg, bench/ACCURACY.md, docs/BENCHMARKS.md: of this run now")


def publish_sheet(options, studies, lines, kept):
    """The table alone, in a part of its own."""
    text = f"Turned: {studies[0].what}.\n\n" + pages.table(*accuracy_study.rows(studies[0])) + f"\nGL: {gl_of(lines)}.\n"
    pages.publish(ROOT / "bench/ACCURACY.md", "accuracy_sheet", text)
    if kept is not None:
        kept.page("bench/ACCURACY.md accuracy_sheet", text)
        kept.renderer = gl_of(lines)
        kept.write(options.figures)
    print("bench/ACCURACY.md: its part of the sheet is of this run now")


def run():
    options = parse()
    options.out.mkdir(parents=True, exist_ok=True)
    kept = None if options.lines else record.Record("accuracy", options.build / "tools" / "furrow")
    lines = gather(options)
    studies = accuracy_study.studies(lines)
    text = report(studies, lines)
    with pages.aside(options.out / "accuracy.md") as file:
        file.write(text)
    print(text)
    print(f"{options.out / lines_of(options)}, {options.out / 'accuracy.md'}: {len(lines)} settings, {len(studies)} studies")
    if options.sheet:
        if options.publish:
            publish_sheet(options, studies, lines, kept)
        return
    written = write_plots(options, studies)
    print("\n".join(f"{path}" for path in written))
    if options.publish:
        publish(options, studies, lines, written, kept)


if __name__ == "__main__":
    pages.main(run)
