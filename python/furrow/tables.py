"""The tables of a drive for pandas, in a notebook:

    drive = furrow.load("out")
    drive.vehicles.groupby("name")["x"].last()
    drive.report("out.html")

docs/RESULTS.md says what the columns are. It needs pandas; furrow.results has the same without, as arrays.
"""
import io
import os
import pathlib
from typing import Any, Union

from furrow import _command
from furrow.results import Drive, ResultsError


class Tables:
    """The folder of one drive. A table is read when it is first asked for, and is empty where the drive wrote none.

    facts: run.json. drive: the same folder for numpy (furrow.results.Drive).
    """

    def __init__(self, folder: "Union[str, os.PathLike[str]]") -> None:
        self.drive = Drive(folder)
        self.folder, self.facts = self.drive.folder, self.drive.facts
        self._tables: "dict[str, Any]" = {}

    def _read(self, name: str) -> Any:
        if name not in self._tables:
            pandas = _command.need("pandas", "pandas")
            path = self.folder / name
            if not path.is_file():
                self._tables[name] = pandas.DataFrame()
                return self._tables[name]
            data = path.read_bytes()
            whole = data[:data.rfind(b"\n") + 1]  # a last line without its end: the drive was killed while it wrote it
            try:
                table = pandas.read_csv(io.BytesIO(whole)) if whole else pandas.DataFrame()
            except ValueError as error:
                raise ResultsError(f"{path}: {error}; give the folder that furrow drive -o wrote") from None
            for column in {"name", "soil", "state"} & set(table.columns):
                table[column] = table[column].astype("category")
            self._tables[name] = table
        return self._tables[name]

    @property
    def vehicles(self) -> Any:
        """A pandas.DataFrame of vehicles.csv: a row for each vehicle and time. Empty: the scene has no output.vehicles."""
        return self._read("vehicles.csv")

    @property
    def objects(self) -> Any:
        """The same of objects.csv: of each object, and each geom of a vehicle that presses the soil."""
        return self._read("objects.csv")

    @property
    def sensors(self) -> Any:
        """The same of sensors.csv."""
        return self._read("sensors.csv")

    @property
    def volume(self) -> Any:
        """A pandas.DataFrame of volume.csv: a row for each commit."""
        return self._read("volume.csv")

    def report(self, to: "Union[str, os.PathLike[str]]" = "report.html") -> pathlib.Path:
        """Writes the page of this drive. Returns its path. docs/REPORT.md tells what it has."""
        from furrow.report import write
        write([self.folder], to)
        return pathlib.Path(to)

    def __repr__(self) -> str:
        return f"furrow.load({str(self.folder)!r})"


def load(folder: "Union[str, os.PathLike[str]]") -> Tables:
    """What `furrow drive -o FOLDER` left, as pandas' tables. furrow.results.ResultsError: the folder has no results."""
    return Tables(folder)
