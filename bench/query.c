/*
 * Points and rays a second: over a store, and over a drive that runs, whose last steps are in slots. A lidar of 64 x 1024 rays
 * stands 2 m over the ground, beside ruts 0.125 m apart in posts; points are beside it, too, or all over the terrain.
 *
 * "first": with nothing kept, so that tiles are read; "again": the same once more. Store's own sampling of a point at a time, which
 * keeps nothing, stands beside.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench.h"
#include "deform/deform.h"
#include "world/made.h"

enum { BEAMS = 64, TURN = 1024, RAYS = BEAMS * TURN, POINTS = 1 << 20, SINGLES = 1 << 14, SIDE = 2049, LEVEL = -3, SLOTS = 64, STEPS = 40 };
#define RANGE 120.0 /* m, of the lidar */

static struct resident_ray rays[RAYS];
static struct resident_hit hits[RAYS];
static struct resident_point near_points[POINTS], far_points[POINTS];
static struct resident_height heights[POINTS];

static double unit(void)
{
	static uint64_t state = 1;
	state = state * 6364136223846793005u + 1442695040888963407u;
	return (double)(state >> 11) * 0x1p-53;
}

static void choose(double x, double y, double ground)
{
	for (int i = 0; i < RAYS; i++) {
		double up = (-25 + 40.0 * (i % BEAMS) / (BEAMS - 1)) * M_PI / 180, turn = 2 * M_PI * (i / BEAMS) / TURN;
		rays[i] = (struct resident_ray){{x, y, ground + 2}, {cos(up) * cos(turn), cos(up) * sin(turn), sin(up)}, RANGE};
	}
	for (int i = 0; i < POINTS; i++) {
		near_points[i] = (struct resident_point){x + (unit() - 0.5) * 100, y + (unit() - 0.5) * 100};
		far_points[i] = (struct resident_point){unit() * (SIDE - 1), unit() * (SIDE - 1)};
	}
}

static void tell(const char *over, const char *what, const char *when, double count, double seconds, const char *gl)
{
	printf("{\"bench\": \"query\", \"over\": \"%s\", \"what\": \"%s\", \"when\": \"%s\", \"count\": %.0f, \"ms\": %.2f, "
	       "\"per_second\": %.0f, \"gl\": \"%s\"}\n", over, what, when, count, seconds * 1e3, count / seconds, gl);
}

static void measure_rays(struct newest *newest, const char *over, const char *when, const char *gl)
{
	double began = clock_seconds();
	bench_must(resident_newest_rays(newest, rays, RAYS, hits));
	tell(over, "lidar", when, RAYS, clock_seconds() - began, gl);
}

static void measure_points(struct newest *newest, const char *over, const char *what, const struct resident_point *points, const char *when,
			   const char *gl)
{
	double began = clock_seconds();
	bench_must(resident_newest_heights(newest, points, POINTS, heights));
	tell(over, what, when, POINTS, clock_seconds() - began, gl);
}

static void measure_singles(struct newest *newest, const char *over, const char *gl)
{
	double began = clock_seconds();
	for (int i = 0; i < SINGLES; i++)
		bench_must(resident_newest_heights(newest, &near_points[i], 1, heights));
	tell(over, "points near, one a call", "again", SINGLES, clock_seconds() - began, gl);
}

static void measure_all(struct newest *newest, const char *over, const char *gl)
{
	measure_rays(newest, over, "first", gl);
	measure_rays(newest, over, "again", gl);
	measure_points(newest, over, "points near", near_points, "first", gl);
	measure_points(newest, over, "points near", near_points, "again", gl);
	measure_singles(newest, over, gl);
	measure_points(newest, over, "points all over", far_points, "first", gl);
}

static void measure_store(const char *path, const char *gl)
{
	struct store *store;
	struct store_reader *reader;
	struct newest *newest;
	bench_must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	bench_must(resident_newest_create(store, NULL, &newest));
	measure_all(newest, "store", gl);
	resident_newest_destroy(newest);
	bench_must(store_reader_create(store, &reader));
	double began = clock_seconds();
	for (int i = 0; i < 256; i++) {
		struct store_sample sample;
		bench_must(store_sample(reader, near_points[i].x, near_points[i].y, &sample));
	}
	tell("store", "store_sample", "always", 256, clock_seconds() - began, gl);
	store_reader_destroy(reader);
	store_close(store);
}

/* --- a drive that runs --- */

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
static const struct scene_object object = {.name = "wheel", .shape = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4}};

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK;
}

/* A drive that the bench makes and steps itself. */
struct drive {
	struct world *world;
	struct world_made made;
	struct scene scene;
	struct body body, *bodies[1];
	struct record *record;
	FILE *commit_log;
};

static void open_drive(struct drive *drive, const char *path)
{
	struct resident *ground = &drive->made.resident;
	*drive = (struct drive){
		.scene = {.slots = SLOTS, .hash = "0"},
		.body = {.object = &object},
		.bodies = {&drive->body},
		.made = {.scene = &drive->scene, .bodies = drive->bodies, .body_count = 1, .resident.level = LEVEL},
	};
	bench_must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &ground->store));
	bench_must(store_set_working_level(ground->store, LEVEL));
	ground->meta = store_meta(ground->store);
	const struct extent *extent = &ground->meta->extent;
	ground->spacing = extent_spacing(extent, LEVEL);
	drive->commit_log = tmpfile();
	bench_must(gpu_create(&(struct gpu_params){.draws = false}, &ground->gpu));
	bench_must(gpu_slots_create(ground->gpu, extent->cells, SLOTS, 0, &ground->slots));
	bench_must(resident_ground_create(ground->store, 8, &ground->ground));
	const struct deform_params deform = {.gpu = ground->gpu, .slots = ground->slots, .extent = extent, .level = LEVEL,
					     .reference = resident_ground_reference(ground->store), .model = DEFORM_NONE};
	bench_must(deform_create(&deform, &drive->made.deform));
	const struct pages_params pages = {.store = ground->store, .gpu = ground->gpu, .slots = ground->slots,
					   .planes = gpu_slots_planes(ground->slots), .level = LEVEL, .count = SLOTS, .loaders = 2,
					   .step_pages = 16, .record = world_record_pages(&drive->scene), .commit_log = drive->commit_log,
					   .before_read_back = before_read_back};
	bench_must(resident_pages_create(&pages, &ground->pages));
	ground->cache = resident_pages_cache(ground->pages);
	bench_must(resident_newest_create(ground->store, ground->pages, &ground->newest));
	drive->record = mem_calloc(1, world_record_bytes(0));
	drive->world = world_made(&drive->made);
	if (drive->record == NULL || drive->world == NULL)
		bench_must(fail_memory("a world"));
}

static void close_drive(struct drive *drive)
{
	const struct resident *ground = &drive->made.resident;
	world_made_free(drive->world);
	resident_newest_destroy(ground->newest);
	resident_pages_destroy(ground->pages);
	deform_destroy(drive->made.deform);
	resident_ground_destroy(ground->ground);
	gpu_slots_destroy(ground->slots);
	gpu_destroy(ground->gpu);
	store_close(ground->store);
	fclose(drive->commit_log);
	mem_free(drive->record);
}

/* One step: 5 cm on, beside the lidar. */
static void step(struct drive *drive, double x, double y)
{
	struct event event = {.contact = true, .pose = {.x = lattice_offset(x), .y = lattice_offset(y)}};
	int64_t ground;
	bool any;
	bench_must(resident_ground_height(drive->made.resident.ground, event.pose.x, event.pose.y, &ground, &any));
	event.pose.z = ground + lattice_offset(wheel.radius - 0.1);
	bench_must(world_made_contact(drive->world, &event));
	bench_must(page_cache_end_step(drive->made.resident.cache, drive->record));
}

static void measure_drive(const char *path)
{
	struct drive drive;
	double steps[STEPS], asked[STEPS];
	open_drive(&drive, path);
	const char *gl = gpu_info(drive.made.resident.gpu)->renderer;
	for (int i = 0; i < STEPS; i++)
		step(&drive, 1000 + i * 0.05, 1003);
	measure_all(drive.made.resident.newest, "drive", gl);
	for (int i = 0; i < STEPS; i++) {
		double began = clock_seconds();
		step(&drive, 1002 + i * 0.05, 1003);
		gpu_finish(drive.made.resident.gpu);
		steps[i] = clock_seconds() - began;
		bench_must(world_rays(drive.world, rays, RAYS, hits));
		asked[i] = clock_seconds() - began - steps[i];
	}
	tell("drive", "lidar", "each step", RAYS, bench_median(asked, STEPS), gl);
	tell("drive", "a step without it", "each step", 1, bench_median(steps, STEPS), gl);
	close_drive(&drive);
}

static const char ruts[] =
	"scene: 1\ntime_step: 0.05\nend_time: 20\nspacing: 0.125\nredistribute: {model: none}\nobjects:\n"
	"  - {name: a, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, path: {points: [[950, 1000], [1050, 1005]], speed: 5}}\n"
	"  - {name: b, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, path: {points: [[950, 998], [1050, 1001]], speed: 5}}\n"
	"cache: {slots: 64}\n";

int main(void)
{
	const struct dem_synth synth = {DEM_SYNTH_RIDGED, SIDE, SIDE, 1, 60, 1};
	const char *path = bench_path("query.furrow");
	struct store *store;
	struct newest *newest;
	struct resident_height under;
	bench_store(path, &synth, 256);
	mem_free(bench_drive(ruts, path));
	bench_must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	bench_must(resident_newest_create(store, NULL, &newest));
	bench_must(resident_newest_heights(newest, &(struct resident_point){1000, 1000}, 1, &under));
	resident_newest_destroy(newest);
	store_close(store);
	choose(1000, 1000, under.height);
	measure_store(path, "none");
	measure_drive(path);
	return 0;
}
