/*
 * Writes a raster row by row, from the south, into PATH.part. When it is complete, PATH.part is renamed to PATH.
 *
 *   created -> rows... -> published
 *      \__________\________ destroyed: PATH.part is removed
 */
#include "dem_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

#include "base/aside.h"

struct dem_writer {
	struct dem_raster raster;
	char *path, *srs;
	struct aside aside;
	struct dem_sink *sink;
	int64_t next; /* row to come, from the south */
};

double dem_raster_value(const struct dem_raster *raster, double value)
{
	if (isnan(value)) {
		if (raster->has_nodata)
			return raster->nodata;
		return raster->type == DEM_FLOAT32 || raster->type == DEM_FLOAT64 ? value : 0;
	}
	double low = 0, high = 0;
	switch (raster->type) {
	case DEM_FLOAT32:
	case DEM_FLOAT64:
		return value;
	case DEM_INT32:
		low = INT32_MIN;
		high = INT32_MAX;
		break;
	case DEM_UINT8:
		high = UINT8_MAX;
		break;
	case DEM_UINT16:
		high = UINT16_MAX;
		break;
	}
	value = round(value);
	return value < low ? low : value > high ? high : value;
}

static bool is_tiff(const char *path)
{
	return dem_path_ends(path, ".tif") || dem_path_ends(path, ".tiff");
}

enum status dem_writer_create(const struct dem_raster *raster, struct dem_writer **out)
{
	bool png = dem_path_ends(raster->path, ".png");
	bool raw = dem_path_ends(raster->path, ".r16") || dem_path_ends(raster->path, ".raw");
	if (!png && !raw && !is_tiff(raster->path))
		return fail_with(STATUS_USAGE, "%s: no raster that can be written has this ending; name a .tif, a .png, or a raw .r16",
				 raster->path);
	if ((png && raster->type != DEM_UINT8 && raster->type != DEM_UINT16) || (raw && raster->type != DEM_UINT16))
		return fail_with(STATUS_USAGE, "%s: a %s holds no such values; name a .tif", raster->path, png ? "PNG" : "raw heightmap");
	if (raster->width < 1 || raster->height < 1 || raster->width > INT32_MAX ||
	    raster->height > INT32_MAX)
		return fail_with(STATUS_INPUT, "%s: %lld x %lld posts make no raster; ask for another size",
				 raster->path, (long long)raster->width, (long long)raster->height);
	struct dem_writer *writer = mem_calloc(1, sizeof *writer);
	TRY_MEM(writer, raster->path);
	writer->raster = *raster;
	writer->path = mem_strdup(raster->path);
	writer->srs = mem_strdup(raster->srs != NULL ? raster->srs : "");
	enum status status;
	if (writer->path == NULL || writer->srs == NULL)
		TRY_OR(failed, fail_memory(raster->path));
	TRY_OR(failed, aside_name(&writer->aside, writer->path));
	writer->raster.path = writer->path;
	writer->raster.srs = writer->srs;
	writer->aside.begun = true;
	TRY_OR(failed, png   ? dem_png_sink(&writer->raster, writer->aside.part, &writer->sink)
		       : raw ? dem_raw_sink(&writer->raster, writer->aside.part, &writer->sink)
			     : dem_gdal_sink(&writer->raster, writer->aside.part, &writer->sink));
	*out = writer;
	return STATUS_OK;
failed:
	dem_writer_destroy(writer);
	return status;
}

enum status dem_writer_rows(struct dem_writer *writer, int64_t rows, const double *values)
{
	if (rows < 0 || rows > writer->raster.height - writer->next)
		return fail_with(STATUS_FAILED, "%s: more rows than it has; this is a bug", writer->path);
	for (int64_t row = 0; row < rows; row++) {
		TRY(writer->sink->row(writer->sink, writer->next, values + row * writer->raster.width));
		writer->next++;
	}
	return STATUS_OK;
}

FILE *dem_part_open(const char *part)
{
	const int file = output_create(part, O_WRONLY | O_TRUNC);
	return file >= 0 ? fdopen(file, "wb") : NULL;
}

static enum status sync_part(const struct dem_writer *writer)
{
	int file = open(writer->aside.part, O_RDONLY | O_CLOEXEC);
	bool synced = file >= 0 && fsync(file) == 0;
	int reason = errno;
	if (file >= 0)
		close(file);
	return synced ? STATUS_OK
		      : fail_with(STATUS_FAILED, "%s: cannot be brought to the disk: %s; check its room",
				  writer->aside.part, strerror(reason));
}

enum status dem_writer_publish(struct dem_writer *writer)
{
	if (writer->next != writer->raster.height)
		return fail_with(STATUS_FAILED, "%s: %lld rows are missing; this is a bug", writer->path,
				 (long long)(writer->raster.height - writer->next));
	TRY(writer->sink->finish(writer->sink));
	TRY(sync_part(writer));
	return aside_publish(&writer->aside);
}

void dem_writer_destroy(struct dem_writer *writer)
{
	if (writer == NULL)
		return;
	if (writer->sink != NULL)
		writer->sink->destroy(writer->sink);
	aside_finish(&writer->aside);
	mem_free_all(writer->path, writer->srs, writer);
}
