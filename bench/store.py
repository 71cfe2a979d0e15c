"""The store beside GDAL and LMDB, all in one run: bytes, encode, decode, reads, write-backs, import.

    store.py FURROW BENCH_STORE [--dem FOLDER] [--mosaic DEM...] [--posts N] [--json FILE] ...

Prints a table with the ratio to GDAL and, where there is one, the bar; --json leaves every figure as
JSON lines. README.md says what each row is. Nothing is asserted: the exit status is 0 if it ran."""
import argparse
import json
import os
import pathlib
import re
import shutil
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import time

import record

BLOCK = 256
LEVEL_0 = (32 << 56, (33 << 56) - 1)  # keys, FORMAT.md
SUFFIXES = {".hgt", ".tif", ".bil", ".png", ".dem", ".asc", ".img", ".vrt"}
LOWEST_GROUND = -12000  # metres: below it is a hole that no tag declares, as import's own note says
GDAL_LERC = ["-of", "COG", "-co", "COMPRESS=LERC", "-co", "NUM_THREADS=2", "-co", "OVERVIEWS=NONE"]


def parse():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("furrow", type=pathlib.Path)
    parser.add_argument("bench_store", type=pathlib.Path)
    parser.add_argument("--dem", type=pathlib.Path, help="a folder of DEMs: bytes, coding, reads of each")
    parser.add_argument("--mosaic", nargs="+", default=[], help="DEMs imported as one terrain, timed")
    parser.add_argument("--posts", type=int, default=16385, help="a side of the synthetic import (16385; 0: none)")
    parser.add_argument("--mixed", type=int, default=1025, help="a side of the 30 m source of the import of mixed sources (1025; 0: none)")
    parser.add_argument("--max-error", action="append", help="bytes at this bound too, metres (0.1 and 0.01)")
    parser.add_argument("--before", nargs=2, type=pathlib.Path, metavar=("FURROW", "BENCH_STORE"),
                        help="another build: its stores are decoded and read beside this one's")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--no-write", action="store_true", help="leave the write-backs out")
    parser.add_argument("--json", type=pathlib.Path, help="where the JSON lines go")
    parser.add_argument("--folder", type=pathlib.Path, help="where the scratch files go (the system's)")
    parser.add_argument("--quick", action="store_true", help="bytes at the DEMs' own bounds, coding and reads beside LERC, and the synthetic import alone")
    record.add_option(parser)
    return parser.parse_args()


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.lines, self.rows = [], []
        self.kept = record.Record("store", options.furrow)
        self.gdal = shutil.which("gdal_translate") is not None  # without it, our figures stand alone

    def path(self, name):
        return self.folder / name

    def call(self, *command):
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"store.py: {' '.join(map(str, command))}: {done.stderr.strip()}")
        return done.stdout

    def furrow(self, *arguments):
        return self.call(self.options.furrow, *arguments)

    def measure(self, *arguments, build=None):
        text = self.call(build or self.options.bench_store, "--runs", self.options.runs, *arguments)
        return [json.loads(line) for line in text.splitlines()]

    def note(self, **line):
        """A line of JSON; --json holds what is known so far even if the rest fails."""
        self.lines.append({"bench": "store", **line})
        if self.options.json:
            self.options.json.write_text("".join(json.dumps(line) + "\n" for line in self.lines))

    def mean_row(self, what, ratios, bar):
        """The geometric mean of what each DEM takes beside the other."""
        mean = statistics.geometric_mean(ratios)
        self.row(what, f"mean of {len(ratios)}", mean, 1, "ratio", bar, "LERC_ZSTD", runs=1)

    def keep(self, what, data, ours, theirs, unit, beside, runs):
        """Figures: DATA.WHAT.furrow, that of the other, and DATA.WHAT.ratio. Ours is there once, whatever stands beside it."""
        name, other = (re.sub(r"[^a-z0-9.]+", "_", text.lower()).strip("_") for text in (f"{data}.{what}", beside))
        values = ((f"{name}.furrow", ours, unit), (f"{name}.{other}", theirs, unit), (f"{name}.ratio_{other}", theirs and ours / theirs, ""))
        for key, value, of in values:
            if value is not None and key not in self.kept.figures:
                self.kept.add(key, value, of, runs=runs)

    def row(self, what, data, ours, theirs, unit, bar=None, beside="GDAL", runs=None):
        """`bar`: ("<=" or ">=", ratio). `runs`: of how many a rate or time is the median (those of the option); bytes are of one."""
        self.keep(what, data, ours, theirs, unit, beside, runs or (1 if unit == "B" else self.options.runs))
        ratio = ours / theirs if theirs else None
        met = None
        if bar and ratio is not None:
            met = ratio <= bar[1] if bar[0] == "<=" else ratio >= bar[1]
        self.rows.append((what, data, ours, theirs, beside, unit, ratio, bar, met))
        self.note(row=what, data=data, furrow=ours, other=theirs, beside=beside, unit=unit, ratio=ratio,
                  bar=bar and f"{bar[0]} {bar[1]}", met=met)
        print(f"store.py: {what} {data} {ratio or 0:.3f}", file=sys.stderr, flush=True)


def number(value):
    if value is None:
        return "-"
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def print_table(rows):
    head = ("row", "data", "furrow", "beside", "of", "unit", "ratio", "bar", "met")
    cells = [head] + [(what, data, number(ours), number(theirs), beside, unit, "-" if ratio is None else f"{ratio:.3f}",
                       f"{bar[0]} {bar[1]}" if bar else "", "" if met is None else "yes" if met else "NO")
                      for what, data, ours, theirs, beside, unit, ratio, bar, met in rows]
    widths = [max(len(line[i]) for line in cells) for i in range(len(head))]
    for line in cells:
        print("  ".join(cell.rjust(w) if 2 <= i <= 3 or i == 6 else cell.ljust(w)
                        for i, (cell, w) in enumerate(zip(line, widths))).rstrip())


# --- the same posts for both ---

class Posts:
    """A DEM as `furrow import` resamples it: the exact posts as a GeoTIFF, and that in other types."""

    def __init__(self, bench, dem):
        self.bench, self.name = bench, dem.name
        self.source = [dem]
        info = self.store("default")
        if info["height"][0] is not None and info["height"][0] <= LOWEST_GROUND:
            self.source += ["--nodata", info["height"][0]]
            info = self.store("default")
        self.default_error, self.size = info["max_error"], info["posts"]
        self.highest = max(abs(height or 0) for height in info["height"])
        self.store("exact", 0)
        self.exact = bench.path(f"{self.name}.exact.tif")
        bench.furrow("export", self.store_path("exact"), "--layer", "base", "--level", 0, "-o", self.exact)

    def store_path(self, name):
        return self.bench.path(f"{self.name}.{name}.furrow")

    def store(self, name, max_error=None):
        bound = [] if max_error is None else ["--max-error", max_error]
        self.bench.furrow("import", *self.source, *bound, "-o", self.store_path(name), "--overwrite")
        return json.loads(self.bench.furrow("info", self.store_path(name), "--json"))

    def within(self, path, bound, of=None):
        """Whether a raster's posts are within `bound` of the exact ones, and its holes theirs."""
        found, = self.bench.measure("error", of or self.exact, path)
        rounding = self.highest * 2 ** -23  # a float32's own
        return found["same_size"] and found["holes_differ"] == 0 and found["error"] <= bound + rounding

    def rasters(self, bound, exact):
        """`exact` in the types GDAL may like better, with the MAX_Z_ERROR that keeps the bound."""
        yield "Float32", exact, bound
        nan = self.bench.path("nan.tif")
        self.bench.call("gdalwarp", "-q", "-overwrite", "-srcnodata", -32767, "-dstnodata", "nan", exact, nan)
        yield "Float32 NaN", nan, bound
        # Rounded to whole metres, half a metre is spent: LERC then has to be lossless.
        for kind in ("Int16", "UInt16"):
            path = self.bench.path(f"{kind}.tif")
            self.bench.call("gdal_translate", "-q", "-ot", kind, exact, path)
            if self.within(path, bound, exact):
                yield kind, path, 0


def cog(bench, source, path, compression, bound, block):
    extra = ["-co", "PREDICTOR=YES"] if compression == "ZSTD" else ["-co", f"MAX_Z_ERROR={bound}"]
    bench.call("gdal_translate", "-q", "-of", "COG", "-co", f"COMPRESS={compression}", "-co", f"BLOCKSIZE={block}",
               "-co", "OVERVIEWS=NONE", *extra, source, path)
    return path


# --- rows ---

def level_0_bytes(store):
    database = sqlite3.connect(f"file:{store}?mode=ro", uri=True)
    found, = database.execute("SELECT sum(length(blob)) FROM base WHERE key BETWEEN ? AND ?", LEVEL_0).fetchone()
    database.close()
    return found


def compare_bytes(bench, posts, bound):
    """{row: (ours, theirs)}: the finest level alone is the sum of our blobs and GDAL's smallest file
    that keeps the bound."""
    store = posts.store_path("default")
    if bound != posts.default_error:
        store = posts.store_path("bound")
        posts.store("bound", bound)
    ours = level_0_bytes(store)
    if not bench.gdal:
        return {"bytes": (ours, None)}
    back = bench.path("back.tif")
    bench.furrow("export", store, "--layer", "base", "--level", 0, "-o", back)
    if not posts.within(back, bound):
        sys.exit(f"store.py: {store}: a height is further off than {bound} m")
    best = None
    for kind, raster, error in posts.rasters(bound, posts.exact):
        for block in (BLOCK, 2 * BLOCK):
            made = cog(bench, raster, bench.path("bytes.tif"), "LERC_ZSTD", error, block)
            size = made.stat().st_size
            if posts.within(made, bound) and (best is None or size < best[0]):
                best = size, kind, block, bench.measure("blocks", made)[0]["block_bytes"]
    bench.note(row="bytes in full", data=posts.name, max_error=bound, blobs=ours, store_file=store.stat().st_size,
               gdal_file=best[0], gdal_type=best[1], gdal_block=best[2], gdal_blocks=best[3])
    return {"bytes": (ours, best[0]), "bytes, blocks alone": (ours, best[3]),
            "bytes, whole file": (store.stat().st_size, best[0])}


def compare_before(bench, dem):
    """{row: (this build's tiles a second, the other's)}, each on the store that it makes of the DEM, in turns."""
    furrow, bench_store = bench.options.before
    nodata = dem.source[1:]
    store = bench.path("before.furrow")
    bench.call(furrow, "import", *dem.source[:1], *nodata, "-o", store, "--overwrite")
    found = {}
    for _ in range(3):
        for at, (build, path) in enumerate(((None, dem.store_path("default")), (bench_store, store))):
            for line in bench.measure("read", path, build=build):
                if line["subject"] == "" and line["row"] in ("encode", "decode", "decode native", "read"):
                    found.setdefault(line["row"], ([], []))[at].append(line["tiles_s"])
    return {row: tuple(map(statistics.median, rates)) for row, rates in found.items()}


def compare_reads(bench, posts):
    """Encode, decode, read of the tiles that GDAL's blocks cover whole, cut from the south-west.
    [(row, subject or "", tiles, tiles a second)]; of GDAL's types the fastest."""
    wide, high = (n // BLOCK * BLOCK for n in posts.size)
    cut = posts.exact
    if bench.gdal and wide and high:
        cut = bench.path("cut.tif")
        bench.call("gdal_translate", "-q", "-srcwin", 0, posts.size[1] - high, wide, high, posts.exact, cut)
    made = {}
    compressions = ("LERC",) if bench.options.quick else ("LERC", "LERC_ZSTD", "ZSTD")
    for compression in compressions if bench.gdal else ():
        for kind, raster, error in posts.rasters(posts.default_error, cut):
            if compression != "ZSTD" or kind != "Float32 NaN":  # the same to it
                path = bench.path(f"{compression}.{kind.replace(' ', '')}.tif")
                made[str(cog(bench, raster, path, compression, error, BLOCK))] = compression, kind
    best = {}
    paths = list(made)
    for first in range(0, len(paths) or 1, 4):  # each beside our own, which stays the first's
        for line in bench.measure("read", posts.store_path("default"), *paths[first:first + 4]):
            compression, kind = made.get(line["subject"], (line["subject"], ""))
            bench.note(row=line["row"] + " in full", data=posts.name, subject=compression, type=kind,
                       tiles=line["tiles"], tiles_s=line["tiles_s"], mb_s=line["mb_s"])
            name = line["row"], compression
            if compression in ("", "lmdb") and first > 0:
                continue
            if name not in best or best[name][1] < line["tiles_s"]:
                best[name] = line["tiles"], line["tiles_s"]
    return best


def over_all(found):
    """{(row, subject): tiles a second} over all DEMs: all tiles in all the time."""
    total = {}
    for best in found:
        for name, (tiles, rate) in best.items():
            sums = total.setdefault(name, [0, 0])
            sums[0] += tiles
            sums[1] += tiles / rate
    return {name: tiles / seconds for name, (tiles, seconds) in total.items()}


READS = (("encode", "LERC"), ("encode", "LERC_ZSTD"), ("encode", "ZSTD"), ("decode", "LERC"), ("decode", "LERC_ZSTD"),
         ("decode", "ZSTD"), ("decode native", "LERC"), ("read", "LERC"), ("read", "LERC_ZSTD"), ("read", "ZSTD"),
         ("raw read", "lmdb"))


def compare_all_bytes(bench, all_posts, bound):
    """At each DEM's default bound (None), which has the bars, or at one for all."""
    label = "" if bound is None else f" at {bound:g} m"
    sums, ratios = {}, []
    for posts in all_posts:
        sizes = compare_bytes(bench, posts, posts.default_error if bound is None else bound)
        for row, pair in sizes.items():
            sums[row] = [a + (b or 0) for a, b in zip(sums.get(row, [0, 0]), pair)]
        bench.row("bytes" + label, posts.name, *sizes["bytes"], "B", ("<=", 0.9), "LERC_ZSTD")
        if sizes["bytes"][1]:
            ratios.append(sizes["bytes"][0] / sizes["bytes"][1])
            bench.row("bytes, whole file" + label, posts.name, *sizes["bytes, whole file"], "B", None, "LERC_ZSTD")
    if ratios:
        bench.mean_row("bytes" + label, ratios, ("<=", 0.65))
    for row, (ours, theirs) in sums.items():
        bar = ("<=", 1.0) if row == "bytes, whole file" else None
        bench.row(row + label, "all DEMs", ours, theirs or None, "B", bar, "LERC_ZSTD")


def dems(bench, folder):
    paths = [path for path in sorted(folder.iterdir()) if path.suffix.lower() in SUFFIXES]
    all_posts = [Posts(bench, path) for path in paths]
    for bound in [None, *map(float, [] if bench.options.quick else bench.options.max_error or (0.1, 0.01))]:
        compare_all_bytes(bench, all_posts, bound)
    before = [compare_before(bench, posts) for posts in all_posts if bench.options.before]
    for posts, rows in zip(all_posts, before):
        for row, (ours, theirs) in rows.items():
            bench.row(row, posts.name, ours, theirs, "tiles/s", (">=", 1) if row == "decode native" else None, "before")
    for row in before[0] if before else ():
        ratios = [rows[row][0] / rows[row][1] for rows in before]
        bench.row(row, f"mean of {len(ratios)}", statistics.geometric_mean(ratios), 1, "ratio", None, "before")
    found = []
    for posts in all_posts:
        best = compare_reads(bench, posts)
        found.append(best)
        bench.row("decode", posts.name, *(best.get(("decode", subject), (0, None))[1] for subject in ("", "LERC")),
                  "tiles/s", (">=", 3), "LERC")
    total = over_all(found)
    for name, subject in READS:
        bar = (">=", 3) if (name, subject) == ("decode", "LERC") else None
        bench.row(name, "all DEMs", total[name, ""], total.get((name, subject)), "tiles/s", bar, subject)


def writes(bench):
    lines = bench.measure("write")
    for line in lines:
        bench.note(**{**line, "row": "write-back in full"})
    for line in lines:
        if line["subject"] != "":
            continue
        case = line["durability"], line["batch"]
        for other in lines:
            if other["subject"] != "" and (other["durability"], other["batch"]) == case:
                bench.row("write-back", f"{case[0]}, by {case[1]}", line["pages_s"], other["pages_s"], "pages/s",
                          beside=other["subject"])


def timed(bench, command, made):
    """Seconds, processor seconds and peak MB of a command that makes a file, which is removed first."""
    made.unlink(missing_ok=True)
    os.sync()
    began = time.monotonic()
    with open(bench.path("said"), "w") as said:
        process = subprocess.Popen([str(c) for c in command], stdout=said, stderr=said)
        _, status, usage = os.wait4(process.pid, 0)
    took = time.monotonic() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"store.py: {' '.join(map(str, command))}: {bench.path('said').read_text().strip()}")
    return took, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def compare_import(bench, data, sources, rasters, runs):
    """`sources`: and options of the import. `rasters`: {label: (what GDAL reads, further options)}; all take turns."""
    out = bench.path("import.tif")
    compare_commands(bench, data, sources, {label: (["gdal_translate", "-q", *GDAL_LERC, *more, raster, out], out)
                                            for label, (raster, more) in rasters.items()}, runs)


def compare_commands(bench, data, sources, rasters, runs):
    """`rasters`: {label: (GDAL's command, the file it makes)}."""
    store, out = bench.path("import.furrow"), bench.path("import.tif")
    commands = {"": ([bench.options.furrow, "import", *sources, "-o", store], store), **rasters}
    figures, size = {label: [] for label in commands}, {}
    for _ in range(runs):
        for label, (command, made) in commands.items():
            figures[label].append(timed(bench, command, made))
            size[label] = made.stat().st_size
    bench.note(row="import in full", data=data, seconds_processor_mb=figures, file_bytes=size)
    median = {label: [statistics.median(column) for column in zip(*found)] for label, found in figures.items()}
    for label in rasters or [None]:
        beside = label or "GDAL"
        theirs = median.get(label, [None] * 3)
        bench.row("import", data, median[""][0], theirs[0], "s", ("<=", 1.0), beside, runs)
        bench.row("import, processor", data, median[""][1], theirs[1], "s", None, beside, runs)
        bench.row("import, peak memory", data, median[""][2], theirs[2], "MB", None, beside, runs)
    for path in (store, out):
        path.unlink(missing_ok=True)


def synth(bench, posts):
    terrain, packed = bench.path("synth.tif"), bench.path("packed.tif")
    bench.furrow("synth", "-o", packed, "--posts", f"{posts}x{posts}", "--spacing", 1)
    if bench.gdal:  # else most of the time is that of DEFLATE, for both
        bench.call("gdal_translate", "-q", "-co", "COMPRESS=NONE", packed, terrain)
        packed.unlink()
    else:
        packed.rename(terrain)
    rasters = {"LERC": (terrain, []), "LERC same bound": (terrain, ["-co", "MAX_Z_ERROR=0.001"])}
    compare_import(bench, f"synth {posts}", [terrain], rasters if bench.gdal else {}, min(3, bench.options.runs))
    if bench.gdal and not bench.options.quick:
        quarters(bench, terrain, posts)
    terrain.unlink()


def quarters(bench, terrain, posts):
    """A quarter of the terrain as four rasters in metres that share their edge posts, as map sheets do."""
    side, joined, sheets = posts // 4 + 1, bench.path("joined.vrt"), []
    for i in range(4):
        x, y = i % 2 * (side - 1), i // 2 * (side - 1)
        sheets.append(bench.path(f"sheet{i}.tif"))
        bench.call("gdal_translate", "-q", "-srcwin", x, y, side, side, "-a_srs", "EPSG:32633", "-a_ullr", 500000 + x,
                   5000000 - y, 500000 + x + side, 5000000 - y - side, terrain, sheets[-1])
    bench.call("gdalbuildvrt", "-q", "-overwrite", joined, *sheets)
    compare_import(bench, f"four sheets of {side}", sheets, {"LERC": (joined, [])}, bench.options.runs)
    for sheet in sheets:
        sheet.unlink()


def placed(bench, name, side, spacing, west, north, kind):
    """A synthetic terrain with a place in UTM 33N."""
    plain, made = bench.path("plain.tif"), bench.path(name)
    bench.furrow("synth", "-o", plain, "--posts", f"{side}x{side}", "--spacing", spacing, "--kind", kind)
    bench.call("gdal_translate", "-q", "-co", "TILED=YES", "-a_srs", "EPSG:32633", "-a_ullr", west, north, west + side * spacing,
               north - side * spacing, plain, made)
    plain.unlink()
    return made


def mixed(bench, side):
    """A country of posts every 30 m and a site of 1 m, of a tenth of its side, to 4 m; and the site as an inset of the country."""
    country = placed(bench, "country.tif", side, 30, 400000, 5100000, "ridged")
    site = placed(bench, "site.tif", 3 * side, 1, 400000 + 9 * side, 5100000 - 9 * side, "dunes")
    warped, second = bench.path("warped.vrt"), bench.path("second.tif")
    bench.call("gdalwarp", "-q", "-overwrite", "-of", "VRT", "-r", "bilinear", "-ot", "Float32", "-wo", "NUM_THREADS=2", "-tr", 4, 4,
               "-te", 400000, 5100000 - 30 * side, 400000 + 30 * side, 5100000, country, site, warped)
    error = ["-co", "MAX_Z_ERROR=0.001"]
    posts = (7.5 * side) ** 2 / 1e6
    compare_import(bench, f"30 m and 1 m to 4 m, {posts:.0f} M posts", [site, country, "--spacing", 4], {"warp, LERC same bound": (warped, error)},
                   bench.options.runs)
    out = bench.path("import.tif")
    each = " && ".join(" ".join(map(str, ["gdal_translate", "-q", *GDAL_LERC, *error, raster, made])) for raster, made in
                       ((country, out), (site, second)))
    compare_commands(bench, f"inset of {(3 * side) ** 2 / 1e6:.0f} M posts", [country, site], {"LERC of each": (["sh", "-c", each], out)},
                     bench.options.runs)
    store = bench.path("inset.furrow")
    bench.furrow("import", country, site, "-o", store, "--overwrite")
    bench.call("sh", "-c", each)
    bench.row("whole file", "inset beside its COGs, without levels", store.stat().st_size, out.stat().st_size + second.stat().st_size, "B", None, "LERC of each")
    for path in (country, site, second, out, store):
        path.unlink(missing_ok=True)


def mosaic(bench, sources):
    if not bench.gdal:
        compare_import(bench, f"mosaic of {len(sources)}", sources, {}, 2 * bench.options.runs)
        return
    joined, warped, store = bench.path("joined.vrt"), bench.path("warped.vrt"), bench.path("mosaic.furrow")
    bench.furrow("import", *sources, "-o", store, "--overwrite")
    info = json.loads(bench.furrow("info", store, "--json"))
    bench.call("gdalbuildvrt", "-q", "-overwrite", joined, *sources)
    place = info["geotransform"]
    west, north, spacing = place[0], place[3], info["spacing"]
    east, south = west + info["posts"][0] * spacing, north - info["posts"][1] * spacing
    srs = bench.path("srs.wkt")
    srs.write_text(info["srs"])
    bench.call("gdalwarp", "-q", "-overwrite", "-of", "VRT", "-r", "bilinear", "-ot", "Float32", "-wo", "NUM_THREADS=2",
               "-t_srs", srs, "-tr", spacing, spacing, "-te", west, south, east, north, joined, warped)
    error = ["-co", f"MAX_Z_ERROR={info['max_error']}"]
    compare_import(bench, f"mosaic of {len(sources)}", sources,
                   {"LERC, not projected": (joined, []), "LERC, projected": (warped, error)}, 2 * bench.options.runs)


def main():
    options = parse()
    with tempfile.TemporaryDirectory(prefix="furrow-store-", dir=options.folder) as name:
        bench = Bench(options, pathlib.Path(name))
        if options.dem:
            dems(bench, options.dem)
        if not options.no_write and not options.quick:
            writes(bench)
        if options.mosaic:
            mosaic(bench, options.mosaic)
        if options.mixed and bench.gdal and not options.quick:
            mixed(bench, options.mixed)
        if options.posts:
            synth(bench, options.posts)
        bench.kept.write(options.figures)
    print_table(bench.rows)


if __name__ == "__main__":
    main()
