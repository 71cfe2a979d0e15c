/*
 * The loop of a drive that a host controls. A turn has four parts: the host, the steps that are due, loads, and a picture.
 *
 *     nothing drawn -> (something changed) -> drawn -> (read back) -> shown -> nothing drawn
 *
 * A picture is drawn only after the one before was shown. On a hardware GPU it is read back without waiting. It is shown in a
 * later turn than it was drawn in. So the host is called regularly, whatever the GPU does. Steps follow the clock: those that
 * are due are made, but in one turn only as many as fit a short time.
 */
#include <assert.h>
#include <math.h>
#include <string.h>
#include <time.h>

#include "drive/internal.h"

#define SLICE 0.03            /* s: after this no further step is begun in a turn; without a pace, as long as a picture takes */
#define BEHIND 0.25           /* s: a delay behind the clock up to this is caught up; more is dropped */
#define PICTURES (1.0 / 60)   /* s: least time between the begins of two pictures */
#define REST 1.0              /* s: time without pictures after which nothing counts as changing */
#define NAP 1000000           /* ns: sleep in a turn with nothing to do */
#define OFFSETS_LEAST 0.05    /* m: least range of colours of offsets, either way */
#define SLOPES_MOST 45.0      /* degrees */

struct host {
	struct drive *drive;
	const struct drive_host *calls;
	struct drive_control control, shown; /* now; of the last picture */
	struct gpu_staging *staging;
	uint32_t width, height;      /* size of the picture, and of staging */
	bool software;
	bool drawn;                  /* and not shown yet */
	bool read;                   /* drawn, and its read-back begun */
	bool stale;                  /* something changed since the last picture */
	uint64_t drops;              /* drops of the drive that changed it */
	double turned, credit;       /* s: time of the last turn; simulated time that is due */
	double began;                /* s: when the last picture was */
	double came;                 /* s: when the last picture was shown */
	double apart;                /* s: between pictures, about the mean of the last second */
	double frame_ms, step_ms;
};

/* --- the picture --- */

/* Returns the greatest sink of the objects, so that colours show their ruts. */
static double deepest(const struct scene *scene)
{
	double deep = OFFSETS_LEAST;
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		deep = fmax(deep, scene_sinkage_guess(scene, object));
	}
	return chart_round_range(deep);
}

static struct render_layer layer_of(const struct drive *drive, enum render_layer_kind kind)
{
	const struct store_meta *meta = world_resident(drive->world)->meta;
	struct render_layer layer = {kind, 0, 1};
	if (kind == RENDER_OFFSETS) {
		layer.high = deepest(world_scene(drive->world));
		layer.low = -layer.high;
	} else if (kind == RENDER_HEIGHTS && meta->high > meta->low) {
		layer.low = meta->low;
		layer.high = meta->high;
	} else if (kind == RENDER_SLOPES) {
		layer.high = SLOPES_MOST;
	}
	return layer;
}

static enum status make_staging(struct host *host, uint32_t width, uint32_t height)
{
	gpu_staging_destroy(host->staging);
	host->staging = NULL;
	host->width = width;
	host->height = height;
	return gpu_staging_create(world_resident(host->drive->world)->gpu, (size_t)4 * width * height, &host->staging);
}

/* A picture drawn at the old size is never shown. */
static enum status resize(struct host *host)
{
	const struct drive_control *control = &host->control;
	if (control->width == host->width && control->height == host->height)
		return STATUS_OK;
	assert(control->width > 0 && control->height > 0 && control->width <= DRIVE_PICTURE_MOST && control->height <= DRIVE_PICTURE_MOST);
	host->drawn = host->read = false;
	host->stale = true;
	TRY(render_view_resize(host->drive->view, control->width, control->height));
	return make_staging(host, control->width, control->height);
}

static bool same_camera(const struct drive_control *a, const struct drive_control *b)
{
	return a->free == b->free && (!a->free || memcmp(&a->camera, &b->camera, sizeof a->camera) == 0);
}

/* Counts only pictures that follow each other at once. A pause says nothing about their speed. */
static void count_picture(struct host *host, double now)
{
	double apart = now - host->came;
	if (apart < REST)
		host->apart += (apart - host->apart) * fmin(apart, 1);
	host->came = now;
}

static enum status show(struct host *host)
{
	struct drive *drive = host->drive;
	/* A software driver draws on the CPU beside the turn. Here it is waited for. */
	if (!host->read)
		render_view_read_into(drive->view, host->staging);
	host->read = true;
	if (!gpu_staging_idle(host->staging))
		return STATUS_OK;
	TRY(gpu_check(world_resident(drive->world)->gpu, "reading the picture back"));
	host->drawn = host->read = false;
	double now = clock_seconds();
	host->frame_ms = (now - host->began) * 1e3;
	times_add(&drive->report.picture_ms, host->frame_ms);
	count_picture(host, now);
	return host->calls->picture(host->calls->user, drive, gpu_staging_bytes(host->staging), host->width, host->height);
}

static enum status draw(struct host *host)
{
	struct drive *drive = host->drive;
	struct drive_control *control = &host->control;
	bool changed = host->stale || control->again || !same_camera(control, &host->shown) || control->layer != host->shown.layer;
	if (!changed || clock_seconds() - host->began < PICTURES)
		return STATUS_OK;
	host->began = clock_seconds();
	struct render_layer layer = layer_of(drive, control->layer);
	render_view_show_layer(drive->view, &layer);
	enum status status = render_view_frame(drive->view, NULL, false);
	host->shown = *control;
	control->again = false;
	host->stale = render_view_lacks(drive->view);
	host->drawn = true;
	if (status == STATUS_OK && !host->software) {
		render_view_read_into(drive->view, host->staging);
		host->read = true;
	}
	return status;
}

/* --- steps --- */

static enum status one_step(struct host *host)
{
	struct drive *drive = host->drive;
	const double began = clock_seconds();
	host->stale = true;
	TRY(drive_step(drive));
	host->step_ms = (clock_seconds() - began) * 1e3;
	times_add(&drive->report.step_ms, host->step_ms);
	return STATUS_OK;
}

/* Adds the simulated time that is due now. Time that a slow machine cannot catch up with is dropped. */
static void earn(struct host *host)
{
	double now = clock_seconds(), step = world_scene(host->drive->world)->time_step, pace = host->control.pace;
	double most = step + BEHIND * (isinf(pace) ? 0 : pace);
	host->credit = host->control.go != DRIVE_ON ? 0 : isinf(pace) ? INFINITY : fmin(host->credit + (now - host->turned) * pace, most);
	host->turned = now;
}

/* *any: there was something to do. */
static enum status steps(struct host *host, int64_t total, bool *any)
{
	struct drive *drive = host->drive;
	double began = clock_seconds(), step = world_scene(drive->world)->time_step;
	int64_t first = world_steps_done(drive->world);
	earn(host);
	double slice = isinf(host->credit) ? fmin(fmax(SLICE, host->frame_ms / 1e3), BEHIND) : SLICE;
	if (host->control.go == DRIVE_ONE)
		host->credit = step;
	while (world_steps_done(drive->world) < total && host->credit >= step && !world_stopped(drive->world) && vehicle_stopped(drive->vehicles) == NULL &&
	       clock_seconds() - began < slice) {
		TRY(one_step(host));
		host->credit -= isinf(host->credit) ? 0 : step;
	}
	*any = world_steps_done(drive->world) > first;
	if (*any)
		return STATUS_OK;
	/* Work that a step does beside stepping: loads go on, slots become free, and a commit may become due. */
	TRY(render_view_prefetch(drive->view));
	return world_idle(drive->world);
}

static enum status turn(struct host *host, int64_t total)
{
	struct drive *drive = host->drive;
	bool stepped = false, before = host->drawn;
	TRY(host->calls->turn(host->calls->user, drive, &host->control));
	host->stale = host->stale || world_counts(drive->world)->drops != host->drops; /* while a picture was shown, too */
	host->drops = world_counts(drive->world)->drops;
	TRY(resize(host));
	render_view_look_from(drive->view, host->control.free ? &host->control.camera : NULL);
	if (host->control.go != DRIVE_STOP)
		TRY(steps(host, total, &stepped));
	if (host->drawn)
		TRY(show(host));
	bool came = before && !host->drawn;
	if (!host->drawn)
		TRY(draw(host));
	bool begun = host->drawn && (came || !before);
	const struct timespec nap = {0, NAP};
	if (!stepped && !came && !begun)
		nanosleep(&nap, NULL);
	return STATUS_OK;
}

enum status drive_host_steps(struct drive *drive, int64_t total)
{
	const struct scene_view *view = &world_scene(drive->world)->view;
	struct host host = {
		.drive = drive,
		.calls = drive->params.host,
		.control = {.go = DRIVE_ON, .pace = 1, .width = (uint32_t)view->width, .height = (uint32_t)view->height},
		.software = gpu_info(world_resident(drive->world)->gpu)->software,
		.stale = true,
		.turned = drive->began,
		.apart = PICTURES,
	};
	drive->host = &host;
	enum status status;
	TRY_OR(done, make_staging(&host, (uint32_t)view->width, (uint32_t)view->height));
	while (host.control.go != DRIVE_STOP)
		TRY_OR(done, world_stopped(drive->world) ? world_interrupted(drive->world) : turn(&host, total));
done:
	gpu_staging_destroy(host.staging);
	drive->host = NULL;
	return status;
}

/* --- what a host asks --- */

struct pages_seen {
	uint32_t used;
	size_t dirty, queued;
};

static void see_resident(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	struct pages_seen *seen = user;
	seen->used++;
	seen->dirty += dirty;
}

static void see_queued(void *user, const struct page_image *image)
{
	struct pages_seen *seen = user;
	seen->queued++;
}

void drive_figures(struct drive *drive, struct drive_figures *figures)
{
	const struct host *host = drive->host;
	struct pages_seen seen = {0, 0, 0};
	struct page_stats stats;
	page_cache_each_resident(world_resident(drive->world)->cache, see_resident, &seen);
	page_cache_each_queued(world_resident(drive->world)->cache, see_queued, &seen);
	page_cache_stats(world_resident(drive->world)->cache, &stats);
	*figures = (struct drive_figures){
		.fps = 1 / host->apart,
		.frame_ms = host->frame_ms,
		.step_ms = host->step_ms,
		.slots = world_facts(drive->world)->limits.slots,
		.slots_used = seen.used,
		.hits = stats.hits,
		.misses = stats.misses,
		.dirty = seen.dirty,
		.queued = seen.queued,
		.triangles = render_view_triangles(drive->view),
		.step = world_steps_done(drive->world),
		.steps = world_step_count(drive->world),
		.time = world_time(drive->world),
		.end = world_scene(drive->world)->end_time,
		.over = world_steps_done(drive->world) >= world_step_count(drive->world),
		.layer = layer_of(drive, host->shown.layer),
	};
}

const struct scene *drive_scene(const struct drive *drive)
{
	return world_scene(drive->world);
}

const struct store_meta *drive_store(const struct drive *drive)
{
	return world_resident(drive->world)->meta;
}

void drive_scene_camera(const struct drive *drive, struct render_camera *camera)
{
	render_view_scene_camera(drive->view, camera);
}

size_t drive_followed_count(const struct drive *drive)
{
	return drive->scene->object_count + vehicle_count(drive->vehicles);
}

void drive_followed(const struct drive *drive, size_t number, struct drive_followed *out)
{
	const size_t objects = drive->scene->object_count;
	struct vehicle_info info;
	if (number < objects) {
		*out = (struct drive_followed){.name = drive->scene->objects[number].name};
		return;
	}
	vehicle_info(drive->vehicles, number - objects, &info);
	*out = (struct drive_followed){info.name, true, info.speed, info.slip, info.depth};
}

void drive_place(const struct drive *drive, size_t number, double place[3], double *yaw)
{
	const size_t objects = drive->scene->object_count;
	struct furrow_state state;
	double axes[3][3];
	if (number < objects) {
		world_place(drive->world, number, place, yaw);
		return;
	}
	vehicle_state(drive->vehicles, number - objects, &state);
	memcpy(place, state.pose.position, 3 * sizeof *place);
	world_axes(state.pose.orientation, axes);
	*yaw = atan2(axes[0][1], axes[0][0]);
}

enum status drive_drop(struct drive *drive, enum world_drop_shape shape, double x, double y, double yaw, bool *landed)
{
	TRY(world_drop(drive->world, shape, x, y, yaw, landed));
	return render_view_update(drive->view); /* before the next drop: that may have another shape */
}
