"""A soil's numbers from its tests in the field or the laboratory, by least squares: `furrow fit-soil`, or

    import furrow
    fit = furrow.fit_soil("plate.csv", "shear.csv")
    print(fit.soil["cohesion"], fit.told()["shear"]["cohesion"]["error"])      # Pa
    open("soil.yaml", "w").write(fit.block())

    plates of several widths, pressed into the soil     p = (kc / b + kphi) z^n                              Bekker 1969
    a shear ring or plate under several normal stresses tau = (c + sigma tan phi) (1 - exp(-j / K))          Janosi and Hanamoto 1961
    a level plate pushed straight down, slowly          p = 0.87574 xi_n z                                   Agarwal, Goldman and Kamrin 2023

It needs scipy (optimize.least_squares, by MINPACK's Levenberg-Marquardt). SI units: m, Pa, radians. docs/SOIL-TESTS.md
"""
import dataclasses
import math
import os
import pathlib
import sys
from typing import Any, Union

from furrow import _command, _fit_page, _fit_table, _fit_told
from furrow._fit_models import METHODS, Penetration, Plates, Shear, fit_penetration, fit_plates, fit_shear
from furrow._fit_table import Table
from furrow.results import ResultsError

Path = Union[str, "os.PathLike[str]"]
@dataclasses.dataclass
class Fit:
    """A soil from its tests. None: that test was not given. `named` is the soil that has the numbers that were not measured."""

    method: str
    named: str
    plate: "Table | None" = None
    plates: "Plates | None" = None
    shear: "Table | None" = None
    strength: "Shear | None" = None
    penetration: "Table | None" = None
    faces: "Penetration | None" = None

    @property
    def soil(self) -> "dict[str, Any]":
        """A scene's soil: SI units, the friction angle in degrees."""
        soil: "dict[str, Any]" = {"name": self.named}
        if self.plates:
            soil.update(bekker_kc=self.plates.kc[self.method].value, bekker_kphi=self.plates.kphi[self.method].value, bekker_n=self.plates.n[self.method].value)
        if self.strength:
            soil.update(cohesion=self.strength.cohesion.value, friction_angle=math.degrees(self.strength.friction.value), janosi_shear=self.strength.shear.value)
        if self.faces:
            soil["face_strength"] = self.faces.strength.value
        return soil

    def told(self) -> "dict[str, Any]":
        """What `furrow fit-soil --json` prints."""
        return _fit_told.told(self)

    def text(self) -> str:
        """Numbers, standard errors and residuals, as lines of text."""
        return _fit_told.text(self)

    def block(self) -> str:
        """A scene's `soil:`, as YAML."""
        return _fit_told.block(self)

    def plot(self) -> str:
        """The rows of each test and the fitted curves, as an SVG file's text. _command.Missing: there is no matplotlib."""
        return _fit_page.plot(self)

    def page(self) -> str:
        """An HTML page with plots of the curves and of their residuals. _command.Missing: there is no matplotlib, or no Jinja2."""
        return _fit_page.page(self)


def fit_soil(plate: "Path | None" = None, shear: "Path | None" = None, penetration: "Path | None" = None, area: "float | None" = None,
             method: str = "plain", soil: str = "dry_sand") -> Fit:
    """Fits a soil to CSV files of its tests: at least to that of plates, or to a penetration. `area`: m2, of the penetrating plate, where its file has forces alone.

    `method`: whose kc, kphi and n the soil has, plain or wong. `soil`: the named soil that has the other numbers. ResultsError names the file, and the line where
    one is wrong. _command.Missing: there is no scipy.
    """
    if method not in METHODS:
        raise ResultsError(f"fit-soil: method {method}: is none; give plain or wong")
    if plate is None and penetration is None:
        raise ResultsError("fit-soil: no test is given; give PLATE.csv, or --penetration FILE.csv")
    fit = Fit(method, soil)
    fit.plate = _fit_table.read(plate, "plate") if plate is not None else None
    fit.shear = _fit_table.read(shear, "shear") if shear is not None else None
    fit.plates = fit_plates(fit.plate) if fit.plate is not None else None
    fit.strength = fit_shear(fit.shear) if fit.shear is not None else None
    if penetration is not None:
        fit.penetration = _fit_table.read(penetration, "penetration")
        _fit_table.take_pressures(fit.penetration, area)
        fit.faces = fit_penetration(fit.penetration)
    return fit


def main(arguments: "list[str]") -> int:
    """The command. Returns its status."""
    parser = _command.parser("fit-soil", "Fits a soil to its tests: see furrow fit-soil --help.")
    parser.add_argument("tests", metavar="CSV", nargs="*")
    parser.add_argument("-o", "--output", metavar="FILE.yaml")
    parser.add_argument("--penetration", metavar="FILE.csv")
    parser.add_argument("--area", metavar="M2", type=float)
    parser.add_argument("--page", metavar="FILE.html")
    parser.add_argument("--method", choices=METHODS, default="plain")
    parser.add_argument("--soil", metavar="NAME", default="dry_sand")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    sys.stdout.reconfigure(errors="surrogateescape")  # type: ignore[union-attr]

    def work() -> None:
        fit = fit_soil(*given.tests[:2], penetration=given.penetration, area=given.area, method=given.method, soil=given.soil)
        page = fit.page() if given.page else ""
        for path, text in ((given.output, fit.block() if given.output else ""), (given.page, page)):
            if path:
                with _command.Whole(pathlib.Path(path)) as whole:
                    whole.write_text(text, encoding="utf-8", errors="replace")
        print(_fit_told.json_text(fit) if given.json else fit.text(), end="")
        if not given.json and given.output:
            print(f"\n{given.output}: a soil, for furrow drive SCENE --set soil={given.output}, and for --soil of furrow rig and furrow mobility")
        elif not given.json:
            print("\n" + fit.block(), end="")
        sys.stdout.flush()

    return _command.end("fit-soil", work, whole=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
