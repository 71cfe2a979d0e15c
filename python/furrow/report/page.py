"""The page: sections in their order, as page.html writes them."""
import pathlib
import re
from typing import Any

import jinja2

from furrow.report import curves, figures, ground, notes, opening, plots, tables
from furrow.report.blocks import Section
from furrow.report.cache import Cache
from furrow.report.run import Report, Run

HERE = pathlib.Path(__file__).parent
# Control characters, halves of pairs (bytes that are no UTF-8 are read as such) and what is no character: neither HTML nor XML has them.
_NONE = re.compile("[\x00-\x1f\x7f\ud800-\udfff\ufffe\uffff]")


def _clean(value: Any) -> Any:
    return _NONE.sub("?", value) if type(value) is str else value


def read(folders: "list[str]") -> Report:
    """Reads the drives. ResultsError: a folder has no results, or they are damaged."""
    report = Report([Run(folder) for folder in folders])
    for run in report.runs:
        store, why = ground.open_store(run)
        try:
            report.ruts.append(_of_store(lambda: ground.rut(run, store, why), lambda text: ground.rut(run, None, text)))
            report.maps.append(_of_store(lambda: ground.read_map(run, store, why, 480 if report.several else 720), lambda text: ground.read_map(run, None, text, 0)))
        finally:
            if store is not None:
                store.close()
        report.caches.append(Cache(run))
    ground.draw_maps(report.maps)
    return report


def _of_store(found: Any, otherwise: Any) -> Any:
    """What the store shows; a store that cannot be read leaves out its section, with the library's reason."""
    from furrow import Error
    try:
        return found()
    except Error as error:
        return otherwise(str(error))


def sections(report: Report) -> "list[Section]":
    """Pictures and numbers, then plots, then tables."""
    cameras, camera_tables = opening.cameras(report)
    objects, object_tables = curves.objects(report)
    vehicles, vehicle_tables = curves.vehicles(report)
    pull, pull_tables = curves.pull(report)
    digging, digging_tables = curves.diggings(report)
    seen = [opening.opening(report), notes.notes(report), figures.map_section(report), *curves.ways(report), *cameras, *pull, objects, *vehicles, *digging, figures.rut(report),
            figures.volume(report), figures.steps(report), figures.cache_section(report)]
    told = [tables.what_ran(report), *tables.differences(report), tables.results(report), *camera_tables, *pull_tables, *object_tables, *vehicle_tables, *digging_tables, tables.volume(report),
            tables.steps(report), tables.soils(report), tables.settings(report)]
    return seen + told


def html(folders: "list[str]") -> str:
    """The page of the drives in these folders."""
    report = read(folders)
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(HERE), autoescape=True, finalize=_clean, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    try:
        from furrow import version
        own = version()
    except ImportError:  # of a package without its library
        own = ""
    return environment.get_template("page.html").render(report=report, sections=sections(report), style=(HERE / "style.css").read_text(encoding="utf-8"), dashes=plots.DASHES,
                                                        version=own, Number=_is("Number"), Place=_is("Place")).lstrip() + "\n"


def _is(name: str) -> Any:
    from furrow.report import blocks
    kind = getattr(blocks, name)
    return lambda value: isinstance(value, kind)
