"""furrow fit-soil's page: measured rows, fitted curves and residuals. It is one file that needs nothing beside it."""
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from furrow import _command, _fit_told, _library, _svg
from furrow._fit_models import LEVEL_PLATE
from furrow._fit_squares import Number, Quality
from furrow._fit_table import Table

if TYPE_CHECKING:
    from furrow.fit import Fit

CURVE, DOTS = 80, 1500  # points of a curve; dots of a group, at most
PANEL = 690             # pixels across, of plot()
WORDS = {"plates": ("pressure over sinkage", "residuals of pressure", "sinkage, mm", "pressure, kPa"),
         "shear": ("shear stress over displacement", "residuals of shear stress", "displacement, mm", "shear stress, kPa"),
         "penetration": ("pressure over depth", "residuals of pressure over depth", "depth, mm", "pressure, kPa")}
TEMPLATE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"/><meta name="viewport" content="width=device-width, initial-scale=1"/>
<title>furrow fit-soil</title>
<style>
:root{color-scheme:light dark;--text:#222;--back:#fefefe;--line:#ddd;--pale:#666}
@media (prefers-color-scheme: dark){:root{--text:#ddd;--back:#111;--line:#333;--pale:#aaa}}
body{font:15px/1.5 sans-serif;color:var(--text);background:var(--back);max-width:1120px;margin:0 auto;padding:12px 16px}
h1{font-size:24px} h2{font-size:18px;margin-top:32px;overflow-wrap:anywhere} .small{color:var(--pale)}
.scroll,pre{overflow-x:auto} table{border-collapse:collapse} th,td{border-bottom:1px solid var(--line);padding:4px 12px;text-align:left} td.number{text-align:right}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,420px),1fr));gap:12px} figure{margin:0} figure svg{width:100%;height:auto}
.none{color:var(--pale)} pre{border:1px solid var(--line);padding:8px}
.legend{list-style:none;padding:0;display:flex;flex-wrap:wrap;gap:4px 20px} .key{display:inline-block;width:28px;height:3px;margin-right:6px;vertical-align:middle}
</style></head><body>
<h1>A soil from its tests</h1>
<p class="small">Told by furrow fit-soil {{ version }}, method {{ fit.method }}</p>
{% for test in tests %}<section id="{{ test.id }}"><h2>{{ test.path }}</h2>
<div class="scroll"><table><thead><tr><th>number</th><th>value</th><th>standard error</th><th>unit</th></tr></thead><tbody>
{% for name, value, error, unit in test.rows %}<tr><th>{{ name }}</th><td class="number">{{ value }}</td>
<td class="number">{% if error %}{{ error }}{% else %}<span class="none">not fitted</span>{% endif %}</td><td>{{ unit }}</td></tr>
{% endfor %}</tbody></table></div>
<p>{{ test.quality }}</p>
{% for note in test.notes %}<p>{{ note }}</p>
{% endfor %}<div class="plots">
{% for plot in test.plots %}<figure>{{ plot | safe }}</figure>
{% endfor %}</div>
<ul class="legend">
{% for colour, label in test.labels %}<li><span class="key" style="background:{{ colour }}"></span>{{ label }}</li>
{% endfor %}</ul>
<p class="small">Dots: measured. Lines: fitted.</p>
</section>
{% endfor %}<section id="soil"><h2>soil of a scene</h2>
<pre>{{ block }}</pre></section>
</body></html>
"""


def _row(name: str, number: Number, unit: str, scale: float = 1) -> "tuple[str, str, str, str]":
    return name, f"{number.value * scale:.5g}", _fit_told.error_text(number.error * scale) if _fit_told.known(number) else "", unit


def _told(quality: Quality) -> str:
    return (f"{quality.rows} rows. Residuals: rms {quality.rms * 1e-3:.4g} kPa, largest {quality.largest * 1e-3:.4g} kPa in line {quality.largest_line}. "
            f"Goodness of fit: {quality.goodness:.3f}.")


def _model(fit: "Fit", test: str, group: Any, x: Any) -> Any:
    if test == "plates":
        assert fit.plates
        return fit.plates.pressure(fit.method, group, x)
    if test == "shear":
        assert fit.strength
        return fit.strength.stress(group, x)
    assert fit.faces
    return LEVEL_PLATE * fit.faces.strength.value * x


def _draw(axes: Any, fit: "Fit", test: str, table: Table, residuals: bool) -> None:
    """Draws the rows of a test as dots, and the fitted curves."""
    most, lowest, highest = float(table.x.max()), 0.0, 0.0
    rest = table.y - _model(fit, test, table.group, table.x)
    for group, value in enumerate(table.groups):
        colour = _svg.COLOURS[group % len(_svg.COLOURS)]
        order = np.flatnonzero(table.of(group))[np.argsort(table.x[table.of(group)], kind="stable")]
        order = order[::len(order) // DOTS + 1]
        dots = (rest if residuals else table.y)[order] * 1e-3
        axes.plot(table.x[order] * 1e3, dots, "o", color=colour, markersize=5, markeredgewidth=0, clip_on=False)[0].set_gid(f"rows-{test}-{group}-{'left' if residuals else 'all'}")
        lowest, highest = min(lowest, float(dots.min())), max(highest, float(dots.max()))
        if not residuals:
            x = np.linspace(0, most, CURVE)
            y = _model(fit, test, value, x) * 1e-3
            axes.plot(x * 1e3, y, color=colour, linewidth=2)
            lowest, highest = min(lowest, float(y.min())), max(highest, float(y.max()))
    _svg.ruled(axes, "x", _svg.steps(0 if not residuals else float(table.x.min()) * 1e3, most * 1e3))
    _svg.ruled(axes, "y", _svg.steps(lowest, highest))
    _svg.titled(axes, "measured - fitted, kPa" if residuals else WORDS[test][3])
    axes.set_xlabel(WORDS[test][2])


def _plot(fit: "Fit", test: str, table: Table, residuals: bool) -> str:
    fig = _svg.figure(520, 320)
    _draw(_svg.axes(fig, 64, 30, 444, 244), fit, test, table, residuals)
    return _svg.written(fig, inline=WORDS[test][1 if residuals else 0])


def _labels(test: str, table: Table) -> "list[str]":
    if test == "plates":
        return [f"plate of {width * 1e3:g} mm" for width in table.groups]
    if test == "shear":
        return [f"normal stress {stress * 1e-3:g} kPa" for stress in table.groups]
    return [f"plate of {area * 1e4:g} cm2" if area > 0 else "penetration" for area in table.groups]


def _tests(fit: "Fit") -> "list[dict[str, Any]]":
    tests: "list[dict[str, Any]]" = []
    if fit.plates and fit.plate is not None:
        plates, method = fit.plates, fit.method
        tests.append({"id": "plates", "table": fit.plate, "quality": _told(plates.quality[method]),
                      "rows": [_row("kc", plates.kc[method], "N/m^(n+1)"), _row("kphi", plates.kphi[method], "N/m^(n+2)"), _row("n", plates.n[method], "")],
                      "notes": ["One width does not tell kc and kphi apart. kphi is their sum for that width."] if plates.one_width else []})
    if fit.strength and fit.shear is not None:
        shear = fit.strength
        tests.append({"id": "shear", "table": fit.shear, "quality": _told(shear.quality),
                      "notes": ["One normal stress does not tell cohesion and friction apart. One of them is taken for 0."] if shear.one_stress else [], "rows": [
            _row("cohesion", shear.cohesion, "Pa"), _row("friction angle", shear.friction, "degrees", math.degrees(1)), _row("Janosi's K", shear.shear, "m")]})
    if fit.faces and fit.penetration is not None:
        faces = fit.faces
        tests.append({"id": "penetration", "table": fit.penetration, "quality": _told(faces.quality), "notes": [], "rows": [
            _row("face strength", faces.strength, "N/m3"), _row("with an offset", faces.slope, "N/m3"), _row("the offset", faces.offset, "Pa")]})
    return tests


def plot(fit: "Fit") -> str:
    """The rows and curves of each test beside each other, as an SVG file's text. _command.Missing: there is no matplotlib."""
    tests = _tests(fit)
    with _svg.look():
        fig = _svg.figure(PANEL * len(tests), 330)
        for i, test in enumerate(tests):
            _draw(_svg.axes(fig, 64 + PANEL * i, 34, 400, 244), fit, test["id"], test["table"], False)
            looks = [{"color": _svg.COLOURS[k % len(_svg.COLOURS)], "linewidth": 2, "marker": "o", "markersize": 5} for k in range(len(test["table"].groups))]
            _svg.keys(fig, 478 + PANEL * i, 34, list(zip(looks, _labels(test["id"], test["table"]))))
        return _svg.written(fig)


def page(fit: "Fit") -> str:
    """The page as HTML. _command.Missing: there is no matplotlib, or no Jinja2."""
    jinja2 = _command.need("jinja2", "jinja2")
    tests = _tests(fit)
    with _svg.look():
        for test in tests:
            table = test.pop("table")
            test.update(path=_svg.visible(table.path), labels=[(_svg.COLOURS[i % len(_svg.COLOURS)], label) for i, label in enumerate(_labels(test["id"], table))],
                        plots=[_plot(fit, test["id"], table, residuals) for residuals in (False, True)])
    template = jinja2.Environment(autoescape=True).from_string(TEMPLATE)
    return str(template.render(version=_library.version(), fit=fit, tests=tests, block="\n".join(_svg.visible(line) for line in fit.block().split("\n"))))
