"""What a drive noted, refused or skipped."""
import math

from furrow.report.blocks import Block, Section, sentence
from furrow.report.run import Report, Run, finite
from furrow.report.tables import began_on

LIES = {"overturned": "lay on its side or roof", "high_centred": "bore most of the weight: the vehicle hung on it", "buried": "was deeper in the soil than the soil bears",
        "under_ground": "was under the ground"}
COUNTED = (("refused_posts", "times a post would have been pressed deeper than an offset holds"), ("forces.sunk", "times the soil did not carry an object's load"),
           ("forces.slides", "times a loaded object stood where the soil cannot hold it"), ("forces.saturated", "times a post bore more than can be summed"))


def _lies(run: Run) -> "list[str]":
    """What was wrong with how vehicles lay."""
    told = []
    for vehicle in run.members("vehicles"):
        lies = run.named("vehicles", vehicle, "lies")
        for lie in lies if isinstance(lies, list) else []:
            at = lie.get("at") if isinstance(lie, dict) else None
            if not isinstance(at, list) or len(at) < 2 or not isinstance(lie.get("what"), str):
                continue
            time, depth, x, y = finite(lie.get("time")), finite(lie.get("depth")), finite(at[0]), finite(at[1])
            geom = lie["geom"] if isinstance(lie.get("geom"), str) else vehicle
            deep = "" if math.isnan(depth) else f", up to {depth:.3g} m deep"
            if not math.isnan(time + x + y):
                told.append(f"{geom} {LIES.get(lie['what'], lie['what'])} from t = {time:.4g} s on, at {x:.6g}, {y:.6g} m{deep}")
    return told


def _of(run: Run) -> "list[str]":
    told = []
    ended = run.text("ended")
    if ended != "complete":
        told.append(f"The drive did not complete. It ended as: {ended}")
    if math.isfinite(run.number("resumed_from")):
        told.append("The drive was resumed (--resume). Times, cache, memory and files are those of the last part")
    notes = run.at("notes")
    told += [note for note in (notes if isinstance(notes, list) else []) if isinstance(note, str)]
    told += _lies(run)
    told += [f"{run.number(path):.0f} {what}" for path, what in COUNTED if run.number(path) > 0]
    for name in run.members("objects"):
        skipped = finite(run.named("objects", name, "skipped"))
        if skipped > 0:
            told.append(f"{skipped:.0f} path samples of {name} had no ground")
    return told


def notes(report: Report) -> Section:
    blocks = [] if report.several else began_on(report)
    for i, run in enumerate(report.runs):
        blocks += [sentence(report, i, text) for text in _of(run)]
    return Section("notes", "Notes", blocks or [Block("p", "None.")])
