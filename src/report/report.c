/* run.json: what a drive did and what it used. */
#include <math.h>

#include "base/aside.h"
#include "base/json.h"
#include "report/report.h"

#define RANGES 4	  /* of step times, for each octave */
#define WAY_POINTS 64 /* of a way */

static const char *const group_names[GPU_GROUPS] = {
	[GPU_DISPLACE] = "displace", [GPU_REDISTRIBUTE] = "redistribute", [GPU_ATTRIBUTES] = "attributes",
	[GPU_DECIMATE] = "pyramid", [GPU_RENDER] = "render", [GPU_DIVIDE] = "subdivide",
};

/* Edges are those of neighbours, so there is one more than counts. */
static void add_range(void *user, double from, double to, uint64_t count)
{
	cJSON **lists = user;
	if (cJSON_GetArraySize(lists[0]) == 0)
		cJSON_AddItemToArray(lists[0], cJSON_CreateNumber(from));
	cJSON_AddItemToArray(lists[0], cJSON_CreateNumber(to));
	cJSON_AddItemToArray(lists[1], cJSON_CreateNumber((double)count));
}

/* Adds how many of something there are in a second. p99 is at the slow end. null: there was none. */
static void add_rates(cJSON *root, const char *name, const struct times *ms)
{
	if (ms->count == 0) {
		cJSON_AddNullToObject(root, name);
		return;
	}
	cJSON *rates = cJSON_AddObjectToObject(root, name);
	json_number(rates, "mean", 1e3 / times_mean(ms));
	json_number(rates, "p50", 1e3 / times_percentile(ms, 0.5));
	json_number(rates, "p99", 1e3 / times_percentile(ms, 0.99));
}

static void add_times(cJSON *root, const struct report *report)
{
	add_rates(root, "steps_per_second", &report->step_ms);
	add_rates(root, "fps", &report->picture_ms);
	cJSON *step = cJSON_AddObjectToObject(root, "step_ms");
	json_number(step, "p50", times_percentile(&report->step_ms, 0.5));
	json_number(step, "p95", times_percentile(&report->step_ms, 0.95));
	json_number(step, "p99", times_percentile(&report->step_ms, 0.99));
	json_number(step, "max", times_percentile(&report->step_ms, 1));
	cJSON *histogram = cJSON_AddObjectToObject(step, "histogram");
	cJSON *lists[2] = {cJSON_AddArrayToObject(histogram, "edges"), cJSON_AddArrayToObject(histogram, "counts")};
	times_ranges(&report->step_ms, RANGES, add_range, lists);
}

static void add_stages(cJSON *root, const struct gpu_stats *gpu, const struct resident_pages_io *io)
{
	cJSON *stages = cJSON_AddObjectToObject(root, "stage_ms");
	json_number(stages, "load", io->load_ms);
	for (int group = 0; group < GPU_DIVIDE; group++)
		json_number(stages, group_names[group], gpu_group_ms(gpu, (enum gpu_group)group));
	json_number(stages, "readback", io->readback_ms);
	json_number(stages, "writeback", io->writeback_ms);
}

static void add_cache(cJSON *root, const struct report *report, const struct page_stats *stats)
{
	cJSON *cache = cJSON_AddObjectToObject(root, "cache");
	json_integer(cache, "slots", world_facts(report->world)->limits.slots);
	json_integer(cache, "loaders", world_facts(report->world)->limits.loaders);
	cJSON_AddBoolToObject(cache, "holds_all", world_facts(report->world)->limits.all);
	json_integer(cache, "touched", (int64_t)stats->touched);
	json_integer(cache, "hits", (int64_t)stats->hits);
	json_integer(cache, "misses", (int64_t)stats->misses);
	json_integer(cache, "prefetched", (int64_t)stats->prefetched);
	json_integer(cache, "cancelled", (int64_t)stats->cancelled);
	json_integer(cache, "late", (int64_t)stats->late);
	json_integer(cache, "not_begun", (int64_t)stats->not_begun);
	json_integer(cache, "evictions", (int64_t)stats->evictions);
	json_integer(cache, "writebacks", (int64_t)stats->writebacks);
	struct stalls stalls;
	world_stalls(report->world, &stalls);
	json_integer(cache, "stalls", (int64_t)stalls.count);
	json_number(cache, "stall_ms", stalls.ms);
	struct stalls ranges;
	world_range_waits(report->world, &ranges);
	json_integer(cache, "range_waits", (int64_t)ranges.count);
	json_number(cache, "range_wait_ms", ranges.ms);
	json_integer(cache, "stalls_late", report->settled ? (int64_t)(stalls.count - report->stalls_settled.count) : 0);
}

/* Before the first step: the whole time, and the waits for the store within it. */
static void add_warm_up(cJSON *root, const struct report *report)
{
	const struct world_warmed *warmed = &world_counts(report->world)->warmed;
	cJSON *warm = cJSON_AddObjectToObject(root, "warm_up");
	json_number(warm, "seconds", report->warm_seconds);
	json_number(warm, "load_ms", warmed->load_ms);
	json_number(warm, "stall_ms", warmed->stalls.ms + warmed->range_waits.ms);
}

static void add_gpu(cJSON *root, const struct report *report, const struct gpu_stats *stats)
{
	cJSON *passes = cJSON_AddObjectToObject(root, "passes");
	for (int group = 0; group < GPU_GROUPS; group++)
		json_integer(passes, group_names[group], (int64_t)gpu_group_passes(stats, (enum gpu_group)group));
	struct bearing_figures bearing = {.contacts = 0};
	if (world_bearing(report->world) != NULL)
		bearing_figures(world_bearing(report->world), &bearing);
	cJSON *computed = cJSON_AddObjectToObject(root, "computed"); /* what computes the ground, and how much the CPU did */
	json_string(computed, "by", !world_changes_ground(report->world) ? NULL : world_bearing(report->world) != NULL ? "cpu" : "gpu");
	json_integer(computed, "contacts", (int64_t)bearing.contacts);
	json_integer(computed, "feels", (int64_t)bearing.feels);
	json_integer(computed, "regions", (int64_t)bearing.regions);
	json_integer(root, "tiles_per_window", (int64_t)world_counts(report->world)->windows.tiles_most);
	const struct gpu_info *info = gpu_info(world_resident(report->world)->gpu);
	cJSON *gl = cJSON_AddObjectToObject(root, "gl");
	cJSON_AddStringToObject(gl, "vendor", info->vendor);
	cJSON_AddStringToObject(gl, "renderer", info->renderer);
	cJSON_AddStringToObject(gl, "version", info->version);
	cJSON_AddBoolToObject(gl, "software", info->software);
}

void report_most(cJSON *memory, const char *name, const struct resident_pages_budget *most)
{
	cJSON *budget = cJSON_AddObjectToObject(memory, name);
	json_integer(budget, "slots", (int64_t)most->slots);
	json_integer(budget, "loads", (int64_t)most->loads);
	json_integer(budget, "queue", (int64_t)most->queue);
	json_integer(budget, "queue_few", (int64_t)most->queue_few);
	json_integer(budget, "ground", (int64_t)most->ground);
	json_integer(budget, "total", (int64_t)(most->slots + most->loads + most->queue + most->ground));
	json_integer(budget, "total_few", (int64_t)(most->slots + most->loads + most->queue_few + most->ground));
}

struct report_tiles report_tiles_of(const struct world *world, const struct resident_pages_budget *most)
{
	return (struct report_tiles){world_facts(world)->limits.slots, most->images_few, world_facts(world)->limits.ground, world_facts(world)->limits.queries};
}

void report_tile_counts(cJSON *memory, const struct report_tiles *tiles)
{
	cJSON *object = cJSON_AddObjectToObject(memory, "tiles");
	json_integer(object, "slots", tiles->slots);
	json_integer(object, "changed", tiles->changed);
	json_integer(object, "ground", tiles->ground);
	if (tiles->queries > 0)
		json_integer(object, "queries", tiles->queries);
}

void report_usable(cJSON *memory, const struct mem_usable *usable)
{
	cJSON *object = cJSON_AddObjectToObject(memory, "usable");
	json_integer(object, "bytes", (int64_t)usable->bytes);
	cJSON_AddStringToObject(object, "of", usable->of);
}

/* Returns the bytes of tiles in slots, wherever these are. A mirror for pictures does not count. */
static struct resident_host_in_slots slot_bytes(const struct world *world)
{
	struct resident_host_in_slots in = {.base_bytes = 0};
	struct gpu_slots_bytes bytes;
	if (world_resident(world)->host != NULL) {
		resident_host_in_slots(world_resident(world)->host, &in);
		return in;
	}
	gpu_slots_bytes(world_resident(world)->slots, &bytes);
	in.base_bytes = bytes.base;
	in.class_bytes = bytes.classes;
	for (int plane = 0; plane < PLANES; plane++)
		in.plane_bytes[plane] = bytes.planes[plane];
	return in;
}

static unsigned slot_planes(const struct world *world)
{
	return world_resident(world)->host != NULL ? resident_host_planes(world_resident(world)->host) : gpu_slots_planes(world_resident(world)->slots);
}

static void add_memory(cJSON *root, const struct report *report, const struct gpu_stats *gpu,
		       const struct resident_pages_io *io)
{
	const struct resident_host_in_slots slots = slot_bytes(report->world);
	cJSON *memory = cJSON_AddObjectToObject(root, "memory");
	json_integer(memory, "rss_peak", (int64_t)mem_peak_resident());
	json_integer(memory, "gpu_bytes", (int64_t)gpu->bytes);
	json_integer(memory, "host_bytes", (int64_t)io->host_bytes);
	/* The most memory that may be used, whatever the terrain's size and the drive's length. */
	struct resident_pages_budget most;
	world_budget(report->world, &most);
	report_most(memory, "budget", &most);
	const struct report_tiles tiles = report_tiles_of(report->world, &most);
	report_tile_counts(memory, &tiles);
	report_usable(memory, &world_facts(report->world)->limits.usable);
	cJSON *bytes = cJSON_AddObjectToObject(memory, "plane_bytes");
	json_integer(bytes, "base", (int64_t)slots.base_bytes);
	if (slots.class_bytes > 0)
		json_integer(bytes, "classes", (int64_t)slots.class_bytes);
	if (slots.level_bytes > 0)
		json_integer(bytes, "numbers", (int64_t)slots.level_bytes);
	for (int plane = 0; plane < PLANES; plane++)
		if (slot_planes(report->world) & PLANE_BIT(plane))
			json_integer(bytes, plane_name(plane), (int64_t)slots.plane_bytes[plane]);
	json_integer(root, "programs", gpu->programs);
}

static void add_io(cJSON *root, const struct report *report, const struct resident_pages_io *io,
		   const struct resident_ground_figures *ground)
{
	int64_t side = tile_posts(&world_resident(report->world)->meta->extent), reads = (int64_t)ground->reads;
	cJSON *object = cJSON_AddObjectToObject(root, "io");
	json_integer(object, "tiles_read", io->tiles_read + reads);
	json_integer(object, "tiles_written", io->tiles_written);
	json_integer(object, "bytes_read", io->bytes_read + reads * side * side * (int64_t)sizeof(int32_t));
	json_integer(object, "bytes_written", io->bytes_written);
	json_integer(object, "commits", io->commits);
}

/* The sums count what bodies carry, and what is in flight, as compacted. carries, throws: a body may carry some; soil may fly. */
static void add_volume(cJSON *root, double spacing, const struct pages_sums *sums, bool carries, bool throws)
{
	double unit = lattice_offset_metres(1) * spacing * spacing;
	const int64_t removed = -sums->below, raised = sums->above, compacted = sums->compacted - sums->carried - sums->in_flight;
	cJSON *volume = cJSON_AddObjectToObject(root, "volume");
	json_number(volume, "removed", (double)removed * unit);
	json_number(volume, "raised", (double)raised * unit);
	json_number(volume, "net", (double)(raised - removed) * unit);
	json_number(volume, "compacted", (double)compacted * unit);
	json_number(volume, "added", (double)sums->added * unit);
	if (carries)
		json_number(volume, "carried", (double)sums->carried * unit);
	if (throws)
		json_number(volume, "in_flight", (double)sums->in_flight * unit);
	cJSON *units = cJSON_AddObjectToObject(volume, "quanta");
	json_integer(units, "removed", removed);
	json_integer(units, "raised", raised);
	json_integer(units, "net", raised - removed);
	json_integer(units, "compacted", compacted);
	json_integer(units, "added", sums->added);
	if (carries)
		json_integer(units, "carried", sums->carried);
	if (throws)
		json_integer(units, "in_flight", sums->in_flight);
}

/* Adds an interface in the scene's units. null: the soil's own number. Adds nothing if both numbers are the soil's own. */
static void add_interface(cJSON *object, const struct soil_interface *interface)
{
	if (!interface->has_friction && !interface->has_adhesion)
		return;
	cJSON *told = cJSON_AddObjectToObject(object, "interface");
	json_number(told, "friction_angle", interface->has_friction ? interface->friction_angle * 180 / M_PI : (double)NAN);
	json_number(told, "adhesion", interface->has_adhesion ? interface->adhesion : (double)NAN);
}

/* Adds places of a way, at most WAY_POINTS of them, and its end. */
static void add_places(cJSON *object, const double (*places)[2], size_t count)
{
	cJSON *way = cJSON_AddArrayToObject(object, "way");
	const size_t every = count / WAY_POINTS + 1;
	for (size_t i = 0; i < count; i = i + every < count || i + 1 == count ? i + every : count - 1) {
		cJSON *point = cJSON_CreateDoubleArray(places[i], 2);
		if (!cJSON_AddItemToArray(way, point))
			cJSON_Delete(point);
	}
}

/* Adds the corners of an object's way up to now. */
static void add_way(cJSON *object, const struct body *body, double time)
{
	double(*places)[2] = mem_alloc(motion_track_corners(body->track), sizeof *places);
	add_places(object, (const double(*)[2])places, places != NULL ? motion_track_way(body->track, time, places) : 0);
	mem_free(places);
}

/* Adds what a body carries, or several do together. */
static cJSON *add_carried(cJSON *object, const char *name, const struct world_aboard *aboard)
{
	cJSON *told = cJSON_AddObjectToObject(object, name);
	json_number(told, "volume", aboard->volume);
	json_number(told, "weight", aboard->weight);
	json_integer(told, "quanta", aboard->units);
	return told;
}

/* Returns the struck capacity of a body as its path is level, m3; NaN: out of memory. */
static double capacity_of(const struct body *body)
{
	const double *attitude = body->object->path.attitude;
	struct soil_part whole = {.shape = &body->object->shape};
	double capacity;
	soil_axes(attitude[0], attitude[1], attitude[2], 0, whole.axes);
	return soil_struck_capacity(&whole, 1, &capacity) == STATUS_OK ? capacity : (double)NAN;
}

/* Adds what all soil geoms of a vehicle carry, and what each does. Adds nothing if none may. */
static void add_vehicle_carried(cJSON *vehicle, const struct vehicles *vehicles, size_t index, const struct vehicle_info *info)
{
	struct world_aboard all = {0, 0, 0};
	cJSON *geoms = cJSON_CreateObject();
	for (size_t g = 0; g < info->geom_count; g++) {
		struct vehicle_geom geom;
		bool carries;
		double capacity;
		const struct world_aboard one = vehicle_geom_aboard(vehicles, index, g, &carries);
		if (!carries)
			continue;
		vehicle_geom(vehicles, index, g, 1, &geom);
		json_number(add_carried(geoms, geom.name, &one), "capacity", vehicle_geom_capacity(vehicles, index, g, &capacity) == STATUS_OK ? capacity : (double)NAN);
		all = (struct world_aboard){all.units + one.units, all.volume + one.volume, all.weight + one.weight};
	}
	if (geoms == NULL || geoms->child == NULL || !cJSON_AddItemToObject(add_carried(vehicle, "carried", &all), "geoms", geoms))
		cJSON_Delete(geoms);
}

static void add_objects(cJSON *root, const struct report *report)
{
	cJSON *objects = cJSON_AddObjectToObject(root, "objects");
	for (size_t i = 0; i < world_scene(report->world)->object_count; i++) {
		const struct body *body = world_body(report->world, i);
		cJSON *object = cJSON_AddObjectToObject(objects, body->object->name);
		json_number(object, "distance", body->distance);
		json_number(object, "sinkage", body->sinkage);
		json_number(object, "load", body->object->load > 0 ? body->object->load : (double)NAN);
		json_number(object, "slip", body->object->slip);
		add_interface(object, &body->object->interface);
		if (body->object->carry) {
			const struct world_aboard aboard = world_aboard(report->world, i);
			cJSON *told = add_carried(object, "carried", &aboard);
			json_number(told, "capacity", capacity_of(body));
			json_number(told, "gravity", world_scene(report->world)->gravity);
		}
		if (body->object->load > 0 && body->has_last)
			json_number(object, "z", lattice_offset_metres(body->equilibrium));
		json_integer(object, "skipped", body->skipped);
		add_way(object, body, world_time(report->world));
	}
}

static void add_train(cJSON *vehicle, const struct vehicle_train *train)
{
	if (train->has_engine) {
		cJSON *told = cJSON_AddObjectToObject(vehicle, "powertrain");
		json_number(told, "engine_speed", train->engine_speed);
		json_integer(told, "gear", train->gear);
		json_number(told, "engine_work", train->engine_work);
		json_number(told, "engine_kinetic", train->engine_kinetic);
		json_number(told, "driveline_loss", train->loss);
	}
	if (train->has_brakes)
		json_number(vehicle, "brake_loss", train->brake_work);
}

static void add_drives(cJSON *vehicle, const struct vehicles *vehicles, size_t index)
{
	const size_t count = vehicle_drive_count(vehicles, index);
	cJSON *drives = count > 0 ? cJSON_AddObjectToObject(vehicle, "drives") : NULL;
	for (size_t i = 0; i < count; i++) {
		struct vehicle_drive drive;
		vehicle_drive(vehicles, index, i, &drive);
		if (drive.name[0] == '\0')
			continue;
		cJSON *told = cJSON_AddObjectToObject(drives, drive.name);
		json_number(told, "current", drive.current);
		json_number(told, "voltage", drive.voltage);
		json_number(told, "torque", drive.torque);
		json_number(told, "taken", drive.taken);
		json_number(told, "recovered", drive.recovered);
		json_number(told, "mechanical", drive.mechanical);
		json_number(told, "heat", drive.heat);
	}
}

/* What is wrong with how a vehicle lies. Nothing if nothing was told. */
static void add_lies(cJSON *vehicle, const struct vehicles *vehicles, size_t index)
{
	struct vehicle_lie lie;
	cJSON *lies = NULL;
	for (size_t n = 0; vehicle_lie(vehicles, index, n, &lie); n++) {
		cJSON *told = cJSON_CreateObject();
		lies = n == 0 ? cJSON_AddArrayToObject(vehicle, "lies") : lies;
		if (!cJSON_AddItemToArray(lies, told)) {
			cJSON_Delete(told);
			return;
		}
		cJSON_AddStringToObject(told, "what", lie.what);
		json_string(told, "geom", lie.geom);
		json_number(told, "time", lie.time);
		cJSON *at = cJSON_AddArrayToObject(told, "at");
		for (int k = 0; k < 2; k++)
			cJSON_AddItemToArray(at, cJSON_CreateNumber(lie.at[k]));
		json_number(told, "depth", lie.depth);
	}
}

static void add_vehicles(cJSON *root, const struct report *report)
{
	if (report->vehicles == NULL)
		return;
	cJSON *vehicles = cJSON_AddObjectToObject(root, "vehicles");
	for (size_t i = 0; i < vehicle_count(report->vehicles); i++) {
		struct vehicle_info info;
		vehicle_info(report->vehicles, i, &info);
		cJSON *vehicle = cJSON_AddObjectToObject(vehicles, info.name);
		json_number(vehicle, "mass", info.mass);
		json_number(vehicle, "gravity", info.gravity);
		json_integer(vehicle, "soil_geoms", (int64_t)info.geom_count);
		json_number(vehicle, "largest_step", info.largest_step);
		json_number(vehicle, "settled_after", info.settled ? info.settle_seconds : (double)NAN);
		json_number(vehicle, "distance", info.distance);
		json_number(vehicle, "kinetic", info.kinetic);
		json_number(vehicle, "work", info.work);
		add_train(vehicle, &info.train);
		add_drives(vehicle, report->vehicles, i);
		add_vehicle_carried(vehicle, report->vehicles, i, &info);
		cJSON_AddBoolToObject(vehicle, "arrived", info.arrived);
		json_number(vehicle, "stuck_since", info.stuck ? info.stuck_at : (double)NAN);
		add_lies(vehicle, report->vehicles, i);
		double places[VEHICLE_TRAIL + 1][2];
		const size_t count = vehicle_trail(report->vehicles, i, places);
		add_places(vehicle, (const double(*)[2])places, count);
	}
}

static void add_numbers(cJSON *to, const struct soil_numbers *soil)
{
	const char *key;
	double value;
	for (size_t n = 0; scene_soil_number(soil, n, &key, &value); n++)
		if (!isnan(value))
			json_number(to, key, value);
}

/* Every number of the soils, in the scene's units. None if no model reads a soil. */
static void add_soils(cJSON *root, const struct report *report)
{
	const struct scene *scene = world_scene(report->world);
	cJSON *soils = cJSON_AddArrayToObject(root, "soils");
	for (int i = 0; deform_conserves(scene->model) && i < scene->soil_count; i++) {
		cJSON *soil = cJSON_CreateObject();
		if (!cJSON_AddItemToArray(soils, soil)) {
			cJSON_Delete(soil);
			return;
		}
		cJSON_AddStringToObject(soil, "name", scene->soil_names[i]);
		const int value = scene_soil_value(scene, i);
		if (value >= 0)
			json_integer(soil, "class", value);
		else if (i > 0)
			cJSON_AddTrueToObject(soil, i == scene->rocks_soil ? "rock" : "road");
		else if (scene->soil_map != NULL)
			cJSON_AddNullToObject(soil, "class");
		add_numbers(soil, &scene->soils[i]);
		if (scene->soils[i].over == NULL)
			continue;
		json_number(soil, "thickness", scene->soils[i].thickness);
		cJSON *over = cJSON_AddObjectToObject(soil, "over");
		cJSON_AddStringToObject(over, "name", scene->base_names[i]);
		if (!soil_is_rigid(scene->soils[i].over))
			add_numbers(over, scene->soils[i].over);
	}
}

/* With a map: along what share of the paths each of the soils lies, in their order. */
static void add_soil_shares(cJSON *root, const struct report *report)
{
	const struct world_soils_met *met = world_facts(report->world)->met;
	if (met == NULL || world_resident(report->world)->soil_map == NULL)
		return;
	cJSON *shares = cJSON_AddArrayToObject(root, "soil_shares");
	for (int i = 0; i < world_scene(report->world)->soil_count; i++)
		cJSON_AddItemToArray(shares, cJSON_CreateNumber(met->soils[i] / met->all));
}

/* How finely numbers from rasters are kept, in the scene's units. */
static void add_rasters(cJSON *root, const struct report *report)
{
	const struct world *world = report->world;
	if (world_resident(world)->soil_rasters == NULL)
		return;
	cJSON *rasters = cJSON_AddObjectToObject(root, "rasters");
	for (int i = 0; i < world_scene(world)->raster_count; i++) {
		const struct world_raster told = world_raster(world, i);
		cJSON *raster = cJSON_AddObjectToObject(rasters, told.key);
		cJSON_AddStringToObject(raster, "file", told.path);
		json_number(raster, "low", told.low);
		json_number(raster, "high", told.high);
		json_number(raster, "step", told.step);
	}
}

/* What a drive threw, also before it was resumed. */
static void add_thrown(cJSON *root, const struct report *report)
{
	struct world_thrown_figures figures;
	const double spacing = world_resident(report->world)->spacing, unit = lattice_offset_metres(1) * spacing * spacing;
	if (!world_thrown_figures(report->world, &figures))
		return;
	const double mean = figures.thrown > 0 ? figures.mass / (double)figures.thrown : 0;
	cJSON *thrown = cJSON_AddObjectToObject(root, "thrown");
	json_number(thrown, "mass", figures.mass);
	json_number(thrown, "in_flight_mass", mean * (double)figures.flying);
	json_number(thrown, "volume", (double)figures.thrown * unit);
	json_integer(thrown, "grains", (int64_t)figures.grains);
	cJSON *units = cJSON_AddObjectToObject(thrown, "quanta");
	json_integer(units, "thrown", figures.thrown);
	json_integer(units, "landed", figures.landed);
	json_integer(units, "in_flight", figures.flying);
	json_integer(units, "lost", figures.lost);
}

static void add_slide(cJSON *root, const struct report *report)
{
	struct world_recorded recorded;
	world_recorded(report->world, &recorded);
	cJSON *slide = cJSON_AddObjectToObject(root, "slide");
	json_integer(slide, "awake", (int64_t)recorded.active);
	json_integer(slide, "visited", (int64_t)world_counts(report->world)->visited);
	json_integer(slide, "possible", (int64_t)world_counts(report->world)->possible);
}

/* `sums`: of the whole drive, also before it was resumed. */
static void add_forces(cJSON *root, const struct report *report, const struct pages_sums *sums)
{
	struct world_forces_figures figures;
	if (!world_forces_figures(report->world, &figures))
		return;
	if (figures.saturated > 0)
		note("%llu times a post bore more than can be summed (134 MPa): it counts as that", (unsigned long long)figures.saturated);
	cJSON *forces = cJSON_AddObjectToObject(root, "forces");
	json_integer(forces, "sunk", sums->sunk);
	json_integer(forces, "slides", sums->slid);
	json_integer(forces, "saturated", (int64_t)figures.saturated);
	report_failed(forces, report->world, sums->sunk, sums->slid);
}

static void add_view(cJSON *root, const struct report *report)
{
	struct render_view_figures figures;
	render_view_figures(report->view, &figures);
	cJSON *view = cJSON_AddObjectToObject(root, "view");
	json_integer(view, "frames", (int64_t)figures.frames);
	json_number(view, "triangles", figures.triangles);
	json_number(view, "overdraw", figures.overdraw);
	json_integer(view, "starved", (int64_t)figures.starved);
	json_integer(view, "coarsened", (int64_t)figures.coarsened);
	if (report->pictures == NULL)
		return;
	struct render_pictures_figures pictures;
	render_pictures_figures(report->pictures, &pictures);
	json_integer(view, "naps", (int64_t)figures.naps);
	json_number(view, "nap_ms", figures.nap_ms);
	json_integer(view, "images", (int64_t)pictures.written);
	json_integer(view, "image_waits", (int64_t)pictures.waits);
	json_number(view, "image_wait_ms", pictures.wait_ms);
	json_integer(view, "black", (int64_t)pictures.black);
}

/* What this process did and what it used. */
static void add_process(cJSON *root, const struct report *report, const struct resident_pages_io *io)
{
	struct gpu_stats gpu;
	struct page_stats pages;
	struct deform_tally tally = {.refused = 0};
	gpu_stats(world_resident(report->world)->gpu, &gpu);
	for (int i = 0; i < GPU_STAGES; i++) {
		gpu.passes[i] -= world_counts(report->world)->warmed.gpu.passes[i];
		gpu.stage_ms[i] -= world_counts(report->world)->warmed.gpu.stage_ms[i];
	}
	page_cache_stats(world_resident(report->world)->cache, &pages);
	struct resident_ground_figures ground;
	resident_ground_figures(world_resident(report->world)->ground, &ground);
	bool known = world_tally(report->world, &tally) == STATUS_OK;
	if (known && tally.refused > 0)
		note("%llu times a post would have been pressed deeper than an offset holds (1024 m): refused",
		     (unsigned long long)tally.refused);
	json_number(root, "seconds", report->seconds);
	json_number(root, "processor_seconds", report->processor);
	json_number(root, "rtf", report->seconds > 0 ? (world_time(report->world) - world_facts(report->world)->resumed.time) / report->seconds : 0);
	add_warm_up(root, report);
	add_times(root, report);
	add_stages(root, &gpu, io);
	add_cache(root, report, &pages);
	add_gpu(root, report, &gpu);
	add_memory(root, report, &gpu, io);
	add_io(root, report, io, &ground);
	report_where(root, report, &gpu);
	json_number(root, "refused_posts", known ? (double)tally.refused : (double)NAN);
	if (deform_conserves(world_scene(report->world)->model))
		add_slide(root, report);
	add_forces(root, report, &io->sums);
	if (report->view != NULL)
		add_view(root, report);
	report_counts(root, report, &gpu, io);
}

/* Returns the text of the object, and frees the object. */
static char *print(cJSON *root)
{
	char *printed = json_text(root), *json = NULL;
	cJSON_Delete(root);
	if (printed != NULL)
		json = mem_strdup(printed);
	cJSON_free(printed);
	return json;
}

char *report_json(const struct report *report, const char *ended)
{
	struct world_recorded recorded;
	world_recorded(report->world, &recorded);
	struct resident_pages_io io = {.sums = recorded.sums};
	if (world_resident(report->world)->pages != NULL)
		resident_pages_io(world_resident(report->world)->pages, &io);
	cJSON *root = cJSON_CreateObject();
	cJSON_AddStringToObject(root, "ended", ended);
	json_integer(root, "steps", world_steps_done(report->world));
	json_number(root, "simulated", world_time(report->world));
	if (world_facts(report->world)->resumed.is)
		json_integer(root, "resumed_from", world_facts(report->world)->resumed.from);
	else
		cJSON_AddNullToObject(root, "resumed_from");
	report_asked(root, report);
	struct report_sun sun;
	if (report_sun_find(report->world, &sun) == STATUS_OK)
		report_sun_add(root, &sun);
	report_cameras_add(root, world_scene(report->world), report->poses);
	json_number(root, "spacing", world_resident(report->world)->spacing);
	json_integer(root, "working_level", world_resident(report->world)->level);
	if (world_relief(report->world) != NULL || world_rocks(report->world) != NULL)
		cJSON_AddRawToObject(root, "relief", store_relief_text(world_resident(report->world)->store));
	add_volume(root, world_resident(report->world)->spacing, &io.sums, world_carries(report->world), world_grains_most(report->world) > 0);
	add_thrown(root, report);
	add_objects(root, report);
	add_vehicles(root, report);
	add_soils(root, report);
	add_soil_shares(root, report);
	add_rasters(root, report);
	if (world_resident(report->world)->pages != NULL)
		add_process(root, report, &io);
	return print(root);
}

enum status report_gathered(char **json, const struct world_ranked *ranked, int ranks)
{
	cJSON *root = cJSON_Parse(*json);
	TRY_MEM(root, "run.json");
	cJSON *forces = cJSON_GetObjectItemCaseSensitive(root, "forces");
	const cJSON *volume = cJSON_GetObjectItemCaseSensitive(root, "volume");
	const bool carries = cJSON_HasObjectItem(volume, "carried"), throws = cJSON_HasObjectItem(volume, "in_flight");
	cJSON_DeleteItemFromObjectCaseSensitive(root, "volume");
	add_volume(root, cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(root, "spacing")), &ranked->sums, carries, throws);
	if (forces != NULL) {
		cJSON_DeleteItemFromObjectCaseSensitive(forces, "sunk");
		cJSON_DeleteItemFromObjectCaseSensitive(forces, "slides");
		json_integer(forces, "sunk", ranked->sums.sunk);
		json_integer(forces, "slides", ranked->sums.slid);
	}
	cJSON *object = cJSON_AddObjectToObject(root, "ranks");
	json_integer(object, "count", ranks);
	json_integer(object, "tiles_moved", ranked->tiles_moved);
	json_integer(object, "bodies_moved", ranked->bodies_moved);
	json_integer(object, "blocks_moved", ranked->blocks_moved);
	json_integer(object, "bytes_moved", ranked->bytes_moved);
	json_integer(object, "exchanges", ranked->exchanges);
	json_number(object, "waiting", ranked->waiting);
	json_number(object, "busy", ranked->busy);
	json_number(object, "planning", ranked->planning);
	json_number(object, "moving", ranked->moving);
	json_number(object, "balance", ranked->balance);
	mem_free(*json);
	*json = print(root);
	return *json != NULL ? STATUS_OK : fail_memory("run.json");
}

enum status report_write(const char *directory, const char *json)
{
	char path[4096];
	struct aside aside;
	snprintf(path, sizeof path, "%s/run.json", directory);
	TRY(aside_begin(&aside, path));
	/* A failure here returns when the file is completed. */
	(void)fputs(json, aside.file);
	(void)fputc('\n', aside.file);
	return aside_end(&aside, true, STATUS_OK);
}
