"""Small rasters for the tests of the command, made and read back by GDAL's own programs."""
import array
import json
import pathlib
import subprocess

# struct code and GDAL's name of a pixel type
TYPES = {"b": "Byte", "B": "Byte", "h": "Int16", "H": "UInt16", "i": "Int32", "f": "Float32", "d": "Float64"}
UTM = "EPSG:32633"


def gdal(program, *arguments, stdin=None):
    return subprocess.run([program, *map(str, arguments)], input=stdin, check=True, capture_output=True, text=True).stdout


def make(path, width, height, values, code="f", west=500000, north=5000000, step=10, srs=UTM, nodata=None, driver="GTiff",
         options=()):
    """values: in rows from the north. (west, north): the outer corner of the first pixel. step: (dx, dy) or one."""
    path = pathlib.Path(path)
    dx, dy = step if isinstance(step, tuple) else (step, step)
    raw = path.with_name(path.name + ".bytes")
    cells = values if isinstance(values, array.array) else array.array(code, values)
    assert len(cells) == width * height
    raw.write_bytes(cells.tobytes())
    size = cells.itemsize
    vrt = path.with_name(path.name + ".made.vrt")
    vrt.write_text(
        f'<VRTDataset rasterXSize="{width}" rasterYSize="{height}">' + (f"<SRS>{srs}</SRS>" if srs else "") +
        (f"<GeoTransform>{west!r}, {dx!r}, 0, {north!r}, 0, {-dy!r}</GeoTransform>" if step else "") +
        f'<VRTRasterBand dataType="{TYPES[code]}" band="1" subClass="VRTRawRasterBand">'
        f'<SourceFilename relativetoVRT="1">{raw.name}</SourceFilename><ImageOffset>0</ImageOffset>'
        f"<PixelOffset>{size}</PixelOffset><LineOffset>{size * width}</LineOffset><ByteOrder>LSB</ByteOrder>"
        "</VRTRasterBand></VRTDataset>")
    gdal("gdal_translate", "-q", "-of", driver, *(["-a_nodata", nodata] if nodata is not None else []), *options, vrt, path)
    raw.unlink()
    vrt.unlink()
    return path


def pixels(path, code="d", band=1):
    """All pixels in rows from the north, as they are stored; (width, height, array)."""
    out = pathlib.Path(str(path) + ".read")
    gdal("gdal_translate", "-q", "-b", band, "-of", "ENVI", "-ot", TYPES[code], path, out)
    cells = array.array(code, out.read_bytes())
    header = out.with_suffix(".hdr")
    size = dict(line.split(" = ") for line in header.read_text().splitlines() if line.startswith(("samples", "lines")))
    for left in (*out.parent.glob(out.name + "*"), header):
        left.unlink()
    return int(size["samples"]), int(size["lines  "]), cells


def gdalinfo(path, *options):
    return json.loads(gdal("gdalinfo", "-json", *options, path))


def proj4(wkt):
    return gdal("gdalsrsinfo", "-o", "proj4", wkt).strip() if wkt else ""


def nodata_of(path):
    return gdalinfo(path)["bands"][0].get("noDataValue")


def values_at(path, points, srs=None):
    """What gdallocationinfo finds at points of the raster's own SRS, or of `srs`: text, "" outside."""
    text = "".join(f"{x!r} {y!r}\n" for x, y in points)
    how = ["-l_srs", srs] if srs else ["-geoloc"]
    return gdal("gdallocationinfo", "-valonly", *how, path, stdin=text).split("\n")[:len(points)]
