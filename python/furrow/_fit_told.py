"""What furrow fit-soil found: as text, as a scene's soil, as JSON."""
import json
import math
from typing import TYPE_CHECKING, Any

from furrow import _library
from furrow._fit_models import METHODS
from furrow._fit_squares import Number, Quality
from furrow._fit_table import Table

if TYPE_CHECKING:
    from furrow.fit import Fit

OFFSET = 3  # standard errors: a larger offset is told
JANOSI = "Janosi's K, m"


def error_text(error: float) -> str:
    """Two digits."""
    if not (100 <= error < 1e7):
        return f"{error:.2g}"
    digit = 10 ** (math.floor(math.log10(error)) - 1)
    return f"{math.floor(error / digit + 0.5) * digit:.0f}"


def known(number: Number) -> bool:
    """Whether it was fitted."""
    return math.isfinite(number.error)


# --- text ---

def _number(number: Number, scale: float = 1) -> str:
    return f"{f'{number.value * scale:.5g}' + (f' +- {error_text(number.error * scale)}' if known(number) else ''):>24}"


def _quality(quality: Quality, before: str) -> str:
    return f"{before}residuals: rms {quality.rms:.4g} Pa, largest {quality.largest:.4g} Pa in line {quality.largest_line}; goodness of fit {quality.goodness:.3f}"


def _head(table: Table, what: str, scale: float, unit: str) -> str:
    groups = " " + ", ".join(f"{group * scale:g}" for group in table.groups) + f" {unit}" if unit else ""
    return f"{table.path}: {len(table)} rows, {what}{groups}" + (f"; {table.skipped} at 0 left out" if table.skipped else "")


def _plates(fit: "Fit") -> "list[str]":
    assert fit.plates and fit.plate
    plates, table = fit.plates, fit.plate
    lines = [_head(table, "plates of", 1e3, "mm"), f"  {'':<16}{'plain':>24}{'weighted as Wong':>24}"]
    for name, numbers in (("kc, N/m^(n+1)", plates.kc), ("kphi, N/m^(n+2)", plates.kphi), ("n", plates.n)):
        lines.append(f"  {name:<16}" + "".join(_number(numbers[method]) for method in METHODS))
    lines += [_quality(plates.quality["plain"], "  plain: "), _quality(plates.quality["wong"], "  Wong:  ")]
    for width, curve in zip(table.groups, plates.curves):
        lines.append(f"  the plate of {width * 1e3:g} mm alone, as Wong: p = {curve.k:.4g} z^{curve.n:.4g}; goodness of fit {curve.quality.goodness:.3f}")
    if plates.one_width:
        lines.append(f"  One width does not tell kc and kphi apart. kc is 0, and kphi is k = kc / b + kphi for b = {table.groups[0] * 1e3:g} mm.")
    kc, kphi = plates.kc[fit.method].value, plates.kphi[fit.method].value
    if kc < 0:
        lines.append(f"  kc is below 0. So k = kc / b + kphi is above 0 only for widths over {-kc / kphi * 1e3:.3g} mm.")
    if plates.no_kphi:
        lines.append("  kphi came out below 0, which no scene takes. It is 0, and the others were fitted with it.")
    return lines


def _shear(fit: "Fit") -> "list[str]":
    assert fit.strength and fit.shear
    shear = fit.strength
    lines = [_head(fit.shear, "normal stresses of", 1e-3, "kPa"), f"  {'cohesion, Pa':<16}{_number(shear.cohesion)}",
             f"  {'friction, deg':<16}{_number(shear.friction, math.degrees(1))}", f"  {JANOSI:<16}{_number(shear.shear)}",
             _quality(shear.quality, "  ")]
    if shear.one_stress:
        lines.append(f"  One normal stress does not tell cohesion and friction apart. The {'cohesion' if known(shear.friction) else 'friction'} is taken for 0.")
    if shear.no_cohesion or shear.no_friction:
        lines.append(f"  The {'cohesion' if shear.no_cohesion else 'friction'} came out below 0, which no scene takes. It is 0, and the others were fitted with it.")
    return lines


def _penetration(fit: "Fit") -> "list[str]":
    assert fit.faces and fit.penetration
    faces, table = fit.faces, fit.penetration
    areas = table.groups[0] > 0
    lines = [_head(table, "plates of" if areas else "pressures", 1e4, "cm2" if areas else ""), f"  {'faces, N/m3':<16}{_number(faces.strength)}", _quality(faces.quality, "  ")]
    if len(table.groups) > 1:
        lines += [f"  the plate of {area * 1e4:g} cm2 alone: {alone.value:.5g} N/m3" for area, alone in zip(table.groups, faces.alone)]
    if faces.offset.error > 0:
        lines.append(f"  with an offset: {faces.slope.value:.5g} +- {error_text(faces.slope.error)} N/m3, and {faces.offset.value:.4g} +- {error_text(faces.offset.error)} Pa at the surface")
        if abs(faces.offset.value) > OFFSET * faces.offset.error:
            lines.append("  The offset is more than its error: the pressure is not in proportion to depth, as it is in dry soil without cohesion. Look at the residuals.")
    return lines


def text(fit: "Fit") -> str:
    """The numbers as lines, each test's after the other's."""
    return "".join(line + "\n" for part, there in ((_plates, fit.plates), (_shear, fit.strength), (_penetration, fit.faces)) if there for line in part(fit))


# --- a scene's soil ---

def _key(key: str, number: Number, unit: str, scale: float = 1) -> str:
    return f"  {key}: {number.value * scale:.12g}  # {unit}{', ' if unit else ''}" + (f"+- {error_text(number.error * scale)}" if known(number) else "not fitted")


def block(fit: "Fit") -> str:
    """A scene's `soil:`."""
    paths = ["".join("?" if char < " " or char == "\x7f" else char for char in table.path) for table in (fit.plate, fit.shear, fit.penetration) if table is not None]
    lines = [f"# furrow fit-soil {_library.version()}, {' and '.join(paths)}" + (f", method {fit.method}" if fit.plates else "") + ". Behind +-: standard errors",
             "soil:", f"  name: {fit.named}  # what was not measured is that soil's"]
    if fit.plates:
        lines += [_key("bekker_kc", fit.plates.kc[fit.method], "N/m^(n+1)"), _key("bekker_kphi", fit.plates.kphi[fit.method], "N/m^(n+2)"), _key("bekker_n", fit.plates.n[fit.method], "")]
    if fit.strength:
        shear = fit.strength
        lines += [_key("cohesion", shear.cohesion, "Pa"), _key("friction_angle", shear.friction, "degrees", math.degrees(1)), _key("janosi_shear", shear.shear, "m")]
        if shear.friction.value > 0:
            lines.append(f"  repose: {math.degrees(shear.friction.value):.12g}  # degrees: the friction angle")
    if fit.faces:
        lines.append(_key("face_strength", fit.faces.strength, "N/m3"))
    return "".join(line + "\n" for line in lines)


# --- JSON ---

def _pair(number: Number, scale: float = 1) -> "dict[str, float | None]":
    return {"value": number.value * scale, "error": number.error * scale if known(number) else None}


def _figures(quality: Quality) -> "dict[str, Any]":
    return {"rms": quality.rms, "largest": quality.largest, "largest_line": quality.largest_line, "goodness": quality.goodness if math.isfinite(quality.goodness) else None}


def _table(table: Table, groups: str) -> "dict[str, Any]":
    return {"file": table.path.encode("utf-8", "replace").decode(), "rows": len(table), "skipped": table.skipped, groups: list(table.groups)}


def told(fit: "Fit") -> "dict[str, Any]":
    """All numbers. None: there is none. Bytes of a path that are no UTF-8 are question marks."""
    out: "dict[str, Any]" = {"soil": fit.soil, "method": fit.method}
    if fit.plates and fit.plate is not None:
        plates = fit.plates
        out["plate"] = {**_table(fit.plate, "widths"), "one_width": plates.one_width, "no_kphi": plates.no_kphi}
        for method in METHODS:
            out["plate"][method] = {"kc": _pair(plates.kc[method]), "kphi": _pair(plates.kphi[method]), "n": _pair(plates.n[method]), **_figures(plates.quality[method])}
        out["plate"]["curves"] = [{"width": width, "k": curve.k, "n": curve.n, **_figures(curve.quality)} for width, curve in zip(fit.plate.groups, plates.curves)]
    if fit.strength and fit.shear is not None:
        shear = fit.strength
        out["shear"] = {**_table(fit.shear, "normal_stresses"), "one_stress": shear.one_stress, "no_cohesion": shear.no_cohesion, "no_friction": shear.no_friction,
                        "cohesion": _pair(shear.cohesion), "friction_angle": _pair(shear.friction, math.degrees(1)), "janosi_shear": _pair(shear.shear), **_figures(shear.quality)}
    if fit.faces and fit.penetration is not None:
        faces = fit.faces
        out["penetration"] = {**_table(fit.penetration, "areas"), "face_strength": _pair(faces.strength), **_figures(faces.quality),
                              "with_offset": {"face_strength": _pair(faces.slope), "offset": _pair(faces.offset)}, "alone": [alone.value for alone in faces.alone]}
    return out


def json_text(fit: "Fit") -> str:
    """told() as JSON."""
    return json.dumps(told(fit), indent="\t") + "\n"
