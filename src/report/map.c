/*
 * The map of a drive: where its objects and vehicles went, and how they changed the ground. It has the hillshade around their ways,
 * and the offsets in false colour.
 *
 * The map is made only where the scene or the command asks for it. It is made at the drive's end, from the last commit, with a store reader of its own. The drive's counts do not include it.
 *
 * The map has at most PIXELS posts on a side. Its level is the finest one that fits, but no finer than the stored one. It reads
 * at most TILES_MOST tiles of offsets. If the drive left more, it reads those of a coarser level. So its cost is about the same for
 * any drive and terrain. Even then each pixel is computed from 8 x 8 posts, or from all posts that are stored.
 */
#include <math.h>
#include <string.h>

#include "report/report.h"

#define PIXELS 960      /* of the longer side of the map's frame */
#define TILES_MOST 2048 /* tiles of offsets that are read */
#define POSTS_LEAST 64  /* a map shows at least so many posts of the working level on a side */

/* The way of an object or a vehicle up to now, places in metres. */
struct way {
	const char *name;
	double reach; /* m around the way that it may touch */
	double (*places)[2];
	size_t count;
};

struct map {
	const struct world *world;
	const struct vehicles *vehicles;
	struct way *ways; /* of objects, then of vehicles */
	size_t count;
	size_t objects;
	struct chart_raster raster;
};

static void take_object(const struct body *body, double time, struct way *way)
{
	way->name = body->object->name;
	way->reach = soil_shape_bound(&body->object->shape);
	way->count = motion_track_way(body->track, time, way->places);
}

static void take_vehicle(const struct map *map, size_t vehicle, struct way *way)
{
	struct vehicle_info info;
	vehicle_info(map->vehicles, vehicle, &info);
	way->name = info.name;
	way->reach = info.reach;
	way->count = vehicle_trail(map->vehicles, vehicle, way->places);
}

static enum status take_ways(struct map *map)
{
	const struct world *world = map->world;
	const size_t objects = world_scene(world)->object_count, count = objects + vehicle_count(map->vehicles);
	map->objects = objects;
	map->ways = mem_calloc(count, sizeof *map->ways);
	if (map->ways == NULL && count > 0)
		return fail_memory("a map");
	for (map->count = 0; map->count < count; map->count++) {
		struct way *way = &map->ways[map->count];
		const struct body *body = map->count < objects ? world_body(world, map->count) : NULL;
		TRY(mem_make(&way->places, body != NULL ? motion_track_corners(body->track) : VEHICLE_TRAIL + 1, sizeof *way->places, "a map"));
		if (body != NULL)
			take_object(body, world_time(world), way);
		else
			take_vehicle(map, map->count - objects, way);
	}
	return STATUS_OK;
}

/* Finds the extent around all ways, metres, cut at the terrain's edges. If no way is on the terrain, it is the whole terrain. */
static void find_extent(const struct map *map, const double size[2], double low[2], double high[2])
{
	const struct world *world = map->world;
	double reach = 0;
	for (int axis = 0; axis < 2; axis++) {
		low[axis] = INFINITY;
		high[axis] = -INFINITY;
	}
	for (size_t i = 0; i < map->count; i++) {
		const struct way *way = &map->ways[i];
		reach = fmax(reach, way->reach);
		for (size_t k = 0; k < way->count; k++)
			for (int axis = 0; axis < 2; axis++) {
				double place = fmin(fmax(way->places[k][axis], 0), size[axis]);
				low[axis] = fmin(low[axis], place);
				high[axis] = fmax(high[axis], place);
			}
	}
	double side = fmax(high[0] - low[0], high[1] - low[1]), most = POSTS_LEAST * world_resident(world)->spacing;
	double margin = fmax(0.08 * side, 2 * reach), least = fmax(most, 0.4 * (side + 2 * margin));
	for (int axis = 0; axis < 2; axis++) {
		if (!(high[axis] >= low[axis])) { /* no object */
			low[axis] = 0;
			high[axis] = size[axis];
		}
		double more = fmax(margin, (least - (high[axis] - low[axis])) / 2);
		low[axis] -= more;
		high[axis] += more;
	}
}

/* Finds the level and its posts in view, at least two across if the terrain has so many. */
static struct post_rect find_rect(const struct map *map, int *level)
{
	const struct world *world = map->world;
	const struct extent *extent = &world_resident(world)->meta->extent;
	const double size[2] = {extent_side(extent, 0), extent_side(extent, 1)};
	double low[2], high[2];
	find_extent(map, size, low, high);
	int coarsest = extent_coarsest(extent);
	struct post_rect rect;
	for (*level = world_resident(world)->level < 0 ? world_resident(world)->level : 0;; ++*level) {
		double spacing = extent_spacing(extent, *level);
		const struct post_rect all = {0, 0, extent_posts(extent->width, *level), extent_posts(extent->height, *level)};
		rect = (struct post_rect){(int64_t)floor(low[0] / spacing), (int64_t)floor(low[1] / spacing),
					  (int64_t)ceil(high[0] / spacing) + 1, (int64_t)ceil(high[1] / spacing) + 1};
		rect = post_rect_intersect(rect, all);
		if (*level >= coarsest || (rect.x1 - rect.x0 <= PIXELS && rect.y1 - rect.y0 <= PIXELS))
			return rect;
	}
}

static enum status raster(struct map *map)
{
	const struct world *world = map->world;
	struct store_reader *reader = NULL;
	struct chart_raster_params params = {
		.meta = world_resident(world)->meta,
		.layer = STORE_OFFSET,
		.exaggerate = 1,
		.tiles_most = TILES_MOST,
	};
	params.rect = find_rect(map, &params.level);
	params.deformed = store_has_working_level(world_resident(world)->store, &params.working);
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &params.sun);
	enum status status;
	TRY_OR(done, store_reader_create(world_resident(world)->store, &reader));
	params.reader = reader;
	TRY_OR(done, chart_raster_create(&params, &map->raster));
	/* Widen ruts of one pixel. Otherwise the line of the way would hide them. */
	if (params.deformed && params.level > params.working)
		TRY_OR(done, chart_raster_widen(&map->raster));
done:
	store_reader_destroy(reader);
	return status;
}

/* --- drawing --- */

static void write_titles(const struct map *map, const char *ended, char *title, size_t title_room, char *subtitle, size_t subtitle_room)
{
	const struct world *world = map->world;
	const char *slash = strrchr(world_scene(world)->file, '/'), *path = store_file_path(world_resident(world)->store), *store = strrchr(path, '/');
	snprintf(title, title_room, "%s", slash != NULL ? slash + 1 : world_scene(world)->file);
	snprintf(subtitle, subtitle_room, "%s: %g s%s%s", store != NULL ? store + 1 : path, world_time(world), strcmp(ended, "complete") == 0 ? "" : ", ",
		 strcmp(ended, "complete") == 0 ? "" : ended);
}

/* Returns true if all of the scene's paths and starts are in local metres. */
static bool is_local(const struct scene *scene)
{
	bool local = scene->coordinates == SCENE_LOCAL;
	for (size_t i = 0; i < scene->object_count; i++)
		local = local && !scene->objects[i].path.degrees;
	for (size_t i = 0; i < scene->vehicle_count; i++)
		local = local && !scene->vehicles[i].way.degrees;
	return local;
}

static enum status draw(const struct map *map, const char *path, const char *ended)
{
	char title[256], subtitle[320];
	struct chart_way *ways = mem_calloc(map->count, sizeof *ways);
	if (ways == NULL && map->count > 0)
		return fail_memory("a map");
	for (size_t i = 0; i < map->count; i++) {
		const struct way *way = &map->ways[i];
		ways[i] = (struct chart_way){way->name, (const double(*)[2])way->places, way->count, i >= map->objects};
	}
	write_titles(map, ended, title, sizeof title, subtitle, sizeof subtitle);
	const struct chart_map chart = {
		.raster = &map->raster,
		.meta = world_resident(map->world)->meta,
		.title = title,
		.subtitle = subtitle,
		.layer = "Offset",
		.ramp = CHART_RAMP_SIGNED,
		.ways = ways,
		.way_count = map->count,
		.grid = is_local(world_scene(map->world)) ? CHART_GRID_LOCAL : CHART_GRID_METRES,
		.pixels = PIXELS,
	};
	enum status status = chart_map_write(&chart, path, NULL);
	mem_free(ways);
	return status;
}

enum status report_map_check(const struct scene *scene)
{
	const char *missing = scene->map ? chart_missing() : NULL;
	return missing == NULL ? STATUS_OK : fail_with(STATUS_INPUT, "%s: output.map: %s; or take it away", scene->file, missing);
}

enum status report_map(const struct world *world, const struct vehicles *vehicles, const char *path, const char *ended)
{
	struct map map = {.world = world, .vehicles = vehicles};
	enum status status;
	TRY_OR(done, take_ways(&map));
	TRY_OR(done, raster(&map));
	TRY_OR(done, draw(&map, path, ended));
done:
	for (size_t i = 0; i < map.count; i++)
		mem_free(map.ways[i].places);
	mem_free(map.ways);
	chart_raster_finish(&map.raster);
	return status;
}
