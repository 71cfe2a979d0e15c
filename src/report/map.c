/*
 * map.png: shows where the objects and vehicles of a drive went, and how they changed the ground. It has the hillshade around their
 * ways, and the offsets in false colour. A way is a thin line that begins at a dot with the name of the object or vehicle.
 *
 * The map is made at the drive's end, from the last commit, with a store reader of its own. The drive's counts do not include it.
 *
 * The map has at most SIDE_MOST posts on a side. Its level is the finest one that fits, but no finer than the stored one. It reads
 * at most TILES_MOST tiles of offsets. If the drive left more, it reads those of a coarser level. So its cost is about the same for
 * any drive and terrain. Even then each pixel is computed from 8 x 8 posts, or from all posts that are stored.
 */
#include <math.h>
#include <string.h>

#include "report/report.h"

#define SIDE_MOST 1080 /* pixels of the map, without its frame */
#define SIDE 900       /* pixels; a smaller map is enlarged to about this */
#define TILES_MOST 2048 /* tiles of offsets that are read */
#define POSTS_LEAST 64 /* a map shows at least so many posts of the working level on a side */
#define NAMES_MOST 24  /* objects that get a label */

/* Colours of the objects' ways, in the order of the objects. They differ from each other and from the colours of offsets. */
static const struct render_colour colours[] = {
	{20, 120, 60, 255}, {0, 0, 0, 255}, {0, 150, 150, 255}, {150, 110, 10, 255}, {190, 20, 130, 255}, {90, 90, 90, 255},
};

static struct render_colour colour_of(size_t object)
{
	return colours[object % (sizeof colours / sizeof *colours)];
}

/* Returns the object's colour, darker. It is the outline of the white letters of its name. */
static struct render_colour dark_of(size_t object)
{
	struct render_colour colour = colour_of(object);
	return (struct render_colour){colour.r * 3 / 5, colour.g * 3 / 5, colour.b * 3 / 5, 255};
}

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
	struct render_map_raster raster;
	struct render_canvas canvas;
	struct render_placed placed;
};

static void take_object(const struct body *body, double time, struct way *way)
{
	way->name = body->object->name;
	way->reach = deform_shape_bound(&body->object->shape);
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
	const size_t objects = world->scene->object_count, count = objects + vehicle_count(map->vehicles);
	map->ways = mem_calloc(count, sizeof *map->ways);
	if (map->ways == NULL && count > 0)
		return fail_memory("a map");
	for (map->count = 0; map->count < count; map->count++) {
		struct way *way = &map->ways[map->count];
		const struct body *body = map->count < objects ? &world->bodies[map->count] : NULL;
		way->places = mem_alloc(body != NULL ? motion_track_corners(body->track) : VEHICLE_TRAIL + 1, sizeof *way->places);
		if (way->places == NULL)
			return fail_memory("a map");
		if (body != NULL)
			take_object(body, world->time, way);
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
	double side = fmax(high[0] - low[0], high[1] - low[1]), most = POSTS_LEAST * world->spacing;
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
	const struct extent *extent = &world->meta->extent;
	const double size[2] = {(double)(extent->width - 1) * extent->spacing, (double)(extent->height - 1) * extent->spacing};
	double low[2], high[2];
	find_extent(map, size, low, high);
	int coarsest = extent_coarsest(extent);
	struct post_rect rect;
	for (*level = world->level < 0 ? world->level : 0;; ++*level) {
		double spacing = extent_spacing(extent, *level);
		const struct post_rect all = {0, 0, extent_posts(extent->width, *level), extent_posts(extent->height, *level)};
		rect = (struct post_rect){(int64_t)floor(low[0] / spacing), (int64_t)floor(low[1] / spacing),
					  (int64_t)ceil(high[0] / spacing) + 1, (int64_t)ceil(high[1] / spacing) + 1};
		rect = post_rect_intersect(rect, all);
		if (*level >= coarsest || (rect.x1 - rect.x0 <= SIDE_MOST && rect.y1 - rect.y0 <= SIDE_MOST))
			return rect;
	}
}

static enum status raster(struct map *map)
{
	const struct world *world = map->world;
	struct store_reader *reader = NULL;
	struct render_map_raster_params params = {
		.meta = world->meta,
		.layer = STORE_OFFSET,
		.exaggerate = 1,
		.tiles_most = TILES_MOST,
	};
	params.rect = find_rect(map, &params.level);
	params.deformed = store_has_working_level(world->store, &params.working);
	render_sun_of(RENDER_AZIMUTH, RENDER_ALTITUDE, &params.sun);
	enum status status = store_reader_create(world->store, &reader);
	params.reader = reader;
	if (status == STATUS_OK)
		status = render_map_raster_create(&params, &map->raster);
	/* Widen ruts of one pixel. Otherwise the line of the way would hide them. */
	if (status == STATUS_OK && params.deformed && params.level > params.working)
		status = render_map_raster_widen(&map->raster);
	store_reader_destroy(reader);
	return status;
}

/* --- drawing --- */

static double (*on_canvas(const struct map *map, const struct way *way))[2]
{
	const struct render_placed *placed = &map->placed;
	for (size_t i = 0; i < way->count; i++) {
		way->places[i][0] = placed->x + way->places[i][0] * placed->scale;
		way->places[i][1] = placed->y + way->places[i][1] * placed->scale;
	}
	return way->places;
}

/* The rectangle of an object's name on the canvas, pixels. */
struct label {
	int left, low, right, high;
};

static bool is_free(const struct label *label, const struct label *others, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (label->left < others[i].right && others[i].left < label->right && label->low < others[i].high &&
		    others[i].low < label->high)
			return false;
	return true;
}

/* Finds the nearest free place for a name beside a dot: right or left of it, above or below. Returns false if there is none on the
 * map. */
static bool place_label(const struct render_placed *placed, const double dot[2], const char *name, const struct label *others,
			size_t count, struct label *label)
{
	int unit = placed->unit, width = render_text_width(name, unit), high = RENDER_LETTER_HEIGHT * unit, away = 5 * unit;
	for (int line = 0; line < 12; line++)
		for (int side = 0; side < 2; side++) {
			int up = (line + 1) / 2 * (line % 2 == 0 ? -1 : 1) * high;
			int left = (int)dot[0] + (side == 0 ? away : -away - width), low = (int)dot[1] - high / 2 + up;
			*label = (struct label){left, low, left + width, low + high};
			bool on = left >= placed->left && low >= placed->low && label->right <= placed->right &&
				  label->high <= placed->high;
			if (on && is_free(label, others, count))
				return true;
		}
	return false;
}

static enum status draw_ways(const struct map *map)
{
	int unit = map->placed.unit;
	const struct render_colour pale = {255, 255, 255, 80};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < map->count && status == STATUS_OK; i++) {
		struct way *way = &map->ways[i];
		const double(*places)[2] = (const double(*)[2])on_canvas(map, way);
		struct render_colour colour = colour_of(i);
		colour.a = 200; /* the rut below stays visible */
		status = render_canvas_path(&map->canvas, places, way->count, 1.2 * unit, pale);
		if (status == STATUS_OK)
			status = render_canvas_path(&map->canvas, places, way->count, 0.6 * unit, colour);
	}
	return status;
}

static void draw_names(const struct map *map)
{
	int unit = map->placed.unit;
	const struct render_colour pale = {255, 255, 255, 255};
	struct label labels[NAMES_MOST];
	size_t named = 0;
	for (size_t i = 0; i < map->count; i++) {
		if (map->ways[i].count == 0)
			continue;
		const double *dot = map->ways[i].places[0];
		render_canvas_disc(&map->canvas, dot[0], dot[1], 2.6 * unit, pale);
		render_canvas_disc(&map->canvas, dot[0], dot[1], 1.8 * unit, colour_of(i));
	}
	for (size_t i = 0; i < map->count && named < NAMES_MOST; i++) {
		struct label *label = &labels[named];
		const char *name = map->ways[i].name;
		if (map->ways[i].count == 0 ||
		    !place_label(&map->placed, map->ways[i].places[0], name, labels, named, label))
			continue;
		render_canvas_text(&map->canvas, label->left, label->low, unit, name, pale, dark_of(i));
		named++;
	}
}

static enum status draw(struct map *map, const char *path, const char *ended)
{
	const struct world *world = map->world;
	const char *slash = strrchr(world->scene->file, '/');
	char title[256], subtitle[96];
	snprintf(title, sizeof title, "%s, %g s", slash != NULL ? slash + 1 : world->scene->file, world->time);
	snprintf(subtitle, sizeof subtitle, "%s%s%.4g m a post", strcmp(ended, "complete") == 0 ? "" : ended,
		 strcmp(ended, "complete") == 0 ? "" : ", ", map->raster.spacing);
	struct render_map_layout layout = {
		.raster = &map->raster,
		.title = title,
		.subtitle = subtitle,
		.layer = "offset",
		.ramp = RENDER_RAMP_SIGNED,
		.side = SIDE,
	};
	enum status status = render_map_layout_create(&layout, &map->canvas, &map->placed);
	if (status != STATUS_OK)
		return status;
	status = draw_ways(map);
	if (status == STATUS_OK)
		draw_names(map);
	if (status == STATUS_OK)
		status = render_map_layout_frame(&layout, &map->canvas, &map->placed);
	return status == STATUS_OK ? render_canvas_write(&map->canvas, path) : status;
}

enum status report_map(const struct world *world, const struct vehicles *vehicles, const char *path, const char *ended)
{
	struct map map = {.world = world, .vehicles = vehicles};
	enum status status = take_ways(&map);
	if (status == STATUS_OK)
		status = raster(&map);
	if (status == STATUS_OK)
		status = draw(&map, path, ended);
	for (size_t i = 0; i < map.count; i++)
		mem_free(map.ways[i].places);
	mem_free(map.ways);
	render_map_raster_finish(&map.raster);
	render_canvas_finish(&map.canvas);
	return status;
}
