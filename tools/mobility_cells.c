/* furrow mobility: judges the cells of a map row by row, and writes them as a raster or as a picture. The terrain is read once. */
#include <math.h>

#include "mobility.h"

#define ROWS 64

const char *const mobility_layers[] = {"slip", "steepest", "class", "probability", "reason", NULL};
const char *const mobility_classes[CLASSES] = {"no-go", "go", "some headings", "unknown"};

enum mobility_class mobility_class_of(const struct mobility_slope *slope)
{
	if (slope->every)
		return CLASS_GO;
	if (!isnan(slope->steepest))
		return CLASS_SOME;
	return trials_is_unknown(slope->up.reason) ? CLASS_UNKNOWN : CLASS_NO_GO;
}

int mobility_colour_of(const struct mobility_cell *cell, enum mobility_layer layer)
{
	if (layer != LAYER_PROBABILITY)
		return (int)mobility_class_of(&cell->slope);
	if (isnan(cell->probability))
		return MOBILITY_RANGES - 1;
	return cell->probability >= 0.9 ? 3 : cell->probability >= 0.5 ? 2 : cell->probability >= 0.1 ? 1 : 0;
}

static void judge(const struct mobility_map *map, double east, double north, struct mobility_cell *cell)
{
	const double slope = atan(hypot(east, north)) * 180 / M_PI;
	cell->slope = trials_table_at(map->table, slope);
	cell->probability = NAN;
	/* What is unknown in the soil as given has no probability. */
	if (!trials_is_unknown(cell->slope.up.reason))
		cell->probability = trials_probability(map->columns, map->samples, slope);
	cell->shade = chart_shade(&map->sun, east, north);
}

/* What a pass over the map needs. */
struct pass {
	struct mobility_cell *cells;
	double *heights, *slopes, *values;
	struct dem_writer *writer;         /* or */
	struct mobility_picture *picture;
};

static enum status read_rows(const struct mobility_map *map, int64_t y0, int64_t y1, const struct pass *pass)
{
	const int64_t width = map->rect.x1 - map->rect.x0, rows = y1 - y0;
	const size_t room = (size_t)(width + 2) * (size_t)(rows + 2);
	TRY(store_read_posts(map->reader, STORE_SURFACE, map->level, (struct post_rect){map->rect.x0 - 1, y0 - 1, map->rect.x1 + 1, y1 + 1},
			     pass->heights));
	chart_slopes(pass->heights, width, rows, extent_spacing(&map->meta->extent, map->level), pass->slopes, pass->slopes + room);
	for (int64_t i = 0; i < width * rows; i++)
		judge(map, pass->slopes[i], pass->slopes[room + (size_t)i], &pass->cells[i]);
	return STATUS_OK;
}

static double value_of(const struct mobility_cell *cell, enum mobility_layer layer)
{
	switch (layer) {
	case LAYER_SLIP: return cell->slope.up.slip;
	case LAYER_STEEPEST: return cell->slope.steepest;
	case LAYER_CLASS: return cell->slope.up.reason == MOBILITY_NO_GROUND ? (double)NAN : (double)mobility_class_of(&cell->slope);
	case LAYER_PROBABILITY: return cell->probability;
	case LAYER_REASON: break;
	}
	return cell->slope.up.reason == MOBILITY_NO_GROUND ? (double)NAN : (double)cell->slope.up.reason;
}

static enum status write_rows(struct mobility_map *map, int64_t y0, int64_t y1, const struct pass *pass)
{
	const int64_t width = map->rect.x1 - map->rect.x0;
	for (int64_t i = 0; i < (y1 - y0) * width; i++) {
		const struct mobility_cell *cell = &pass->cells[i];
		if (pass->values != NULL)
			pass->values[i] = value_of(cell, map->layer);
		if (cell->slope.up.reason == MOBILITY_NO_GROUND)
			continue;
		map->shares[mobility_class_of(&cell->slope)]++;
		map->colours[mobility_colour_of(cell, map->layer)]++;
	}
	for (int64_t y = y0; y < y1 && pass->picture != NULL; y++)
		mobility_picture_row(pass->picture, map, y, pass->cells + (y - y0) * width);
	return pass->writer != NULL ? dem_writer_rows(pass->writer, y1 - y0, pass->values) : STATUS_OK;
}

static enum status go_through(struct mobility_map *map, struct dem_writer *writer, struct mobility_picture *picture)
{
	const size_t width = (size_t)(map->rect.x1 - map->rect.x0), room = (width + 2) * (ROWS + 2);
	struct pass pass = {.cells = mem_alloc(width * ROWS, sizeof *pass.cells), .heights = mem_alloc(room, sizeof(double)),
			    .slopes = mem_alloc(2 * room, sizeof(double)), .values = writer != NULL ? mem_alloc(width * ROWS, sizeof(double)) : NULL,
			    .writer = writer, .picture = picture};
	struct progress progress;
	enum status status = pass.cells != NULL && pass.heights != NULL && pass.slopes != NULL && (writer == NULL || pass.values != NULL)
				     ? STATUS_OK : fail_memory("cells");
	progress_start(&progress, map->path, "rows");
	for (int64_t y = map->rect.y0; y < map->rect.y1 && status == STATUS_OK; y += ROWS) {
		const int64_t end = y + ROWS < map->rect.y1 ? y + ROWS : map->rect.y1;
		status = read_rows(map, y, end, &pass);
		if (status == STATUS_OK)
			status = write_rows(map, y, end, &pass);
		if (status == STATUS_OK)
			status = progress_step(&progress, end - map->rect.y0, map->rect.y1 - map->rect.y0);
	}
	progress_end(&progress);
	mem_free_all(pass.cells, pass.heights, pass.slopes, pass.values);
	double ground = 0;
	for (int i = 0; i < CLASSES; i++)
		ground += map->shares[i];
	for (int i = 0; i < CLASSES && ground > 0; i++)
		map->shares[i] /= ground;
	for (int i = 0; i < MOBILITY_COLOURS && ground > 0; i++)
		map->colours[i] /= ground;
	return status;
}

static enum status draw_picture(struct mobility_map *map)
{
	struct mobility_picture picture = {.classes = NULL};
	enum status status;
	TRY_OR(done, mobility_picture_create(map, &picture));
	TRY_OR(done, go_through(map, NULL, &picture));
	TRY_OR(done, mobility_picture_write(&picture, map));
done:
	mobility_picture_finish(&picture);
	return status;
}

enum status mobility_draw(struct mobility_map *map)
{
	enum chart_format format;
	if (chart_path_format(map->path, &format))
		return draw_picture(map);
	const struct dem_raster raster = {
		.path = map->path,
		.width = map->rect.x1 - map->rect.x0,
		.height = map->rect.y1 - map->rect.y0,
		.type = DEM_FLOAT32,
		.srs = map->meta->srs,
		.west = map->meta->origin[0] + (double)map->rect.x0 * extent_spacing(&map->meta->extent, map->level),
		.south = map->meta->origin[1] + (double)map->rect.y0 * extent_spacing(&map->meta->extent, map->level),
		.spacing = extent_spacing(&map->meta->extent, map->level),
		.has_nodata = true,
		.nodata = NAN,
	};
	struct dem_writer *writer = NULL;
	enum status status;
	TRY_OR(done, dem_writer_create(&raster, &writer));
	TRY_OR(done, go_through(map, writer, NULL));
	TRY_OR(done, dem_writer_publish(writer));
done:
	dem_writer_destroy(writer);
	return status;
}
