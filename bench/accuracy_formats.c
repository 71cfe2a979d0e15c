/*
 * The same drive straight through deform.h, with the slots' base and offsets kept in another texture format.
 *
 * Deformation computes on the lattice, whatever they are kept in: a variant holds each plane in a texture of its own
 * format, one pass brings it back to the lattice over the posts that a gather will read, and one puts it into its format
 * over those that a scatter wrote. So what a format loses is lost sweep by sweep, as it would be. The lattice itself
 * (R32I) takes no such pass, since gathering copies. These passes are in the times.
 *
 * Invariant: with R32I for both the ground becomes bit for bit what the product makes of it.
 */
#include <math.h>
#include <stdio.h>

#include <xxhash.h>

#include "accuracy_rig.h"
#include "bench.h"

#define INTERVAL 0.05 /* s: a scene's defaults */
#define TIME_STEP 0.02

static size_t interval(struct rig *rig)
{
	struct deform_interval size;
	bench_must(deform_interval_begin(rig->deform, &rig->rest, rig->has_last ? 1 : 0, &size));
	for (size_t i = 0; i < size.regions; i++) {
		rig_decode(rig, deform_interval_reads(rig->deform, i));
		bench_must(deform_interval_gather(rig->deform, i, rig->tiles, rig->tile_count));
	}
	for (size_t i = 0; i < size.runs; i++) {
		bench_must(deform_interval_scatter(rig->deform, i, rig->tiles, rig->tile_count));
		rig_encode(rig, deform_interval_writes(rig->deform, i));
	}
	if (size.blocks > 0)
		bench_must(deform_interval_end(rig->deform));
	return size.blocks;
}

/* Those that are over before `time`: stations of the same time come first. */
static void intervals_before(struct rig *rig, double time)
{
	for (; (double)(rig->intervals + 1) * INTERVAL < time; rig->intervals++)
		interval(rig);
}

static void sweep(struct rig *rig, const struct deform_contact *of)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	bench_must(deform_windows(rig->deform, of, windows, &count));
	if (rig->has_last && !deform_covers(rig->deform, of, &rig->rest.pose)) {
		const struct deform_contact left = {.shape = &rig_wheel, .from = rig->rest.pose, .to = rig->rest.pose};
		struct deform_window around[DEFORM_WINDOWS_MAX];
		size_t number;
		bench_must(deform_windows(rig->deform, &left, around, &number));
		for (size_t i = 0; i < number; i++)
			bench_must(deform_wake(rig->deform, around[i].write));
	}
	for (size_t i = 0; i < count; i++) {
		rig_decode(rig, windows[i].read);
		bench_must(deform_compute(rig->deform, of, &windows[i], (uint32_t)i, rig->tiles, rig->tile_count));
	}
	for (size_t i = 0; i < count; i++) {
		bench_must(deform_scatter(rig->deform, &windows[i], (uint32_t)i, rig->tiles, rig->tile_count));
		rig_encode(rig, windows[i].write);
		bench_must(deform_wake_swept(rig->deform, &windows[i], (uint32_t)i));
	}
	rig->rest = (struct deform_rest){.shape = &rig_wheel, .pose = of->to};
	rig->has_last = true;
}

static void sample(struct rig *rig, const struct track *track, int64_t index)
{
	struct track_point point;
	int64_t ground;
	bool any;
	motion_track_sample(track, index, &point);
	bench_must(resident_ground_height(rig->ground, point.qx, point.qy, &ground, &any));
	struct deform_contact of = {.shape = &rig_wheel};
	of.to = (struct soil_pose){.x = point.qx, .y = point.qy, .z = ground + lattice_offset(ACCURACY_RADIUS - ACCURACY_SINK),
				   .yaw = point.yaw};
	of.from = index > 0 ? rig->rest.pose : of.to;
	if (index > 0) {
		double along = lattice_offset_metres(of.to.x - of.from.x) * cos(of.to.yaw) +
			       lattice_offset_metres(of.to.y - of.from.y) * sin(of.to.yaw);
		of.seconds = point.time - motion_track_sample_time(track, index - 1);
		of.turned = along / ACCURACY_RADIUS;
		of.to.turn = remainder(of.from.turn + of.turned, 2 * M_PI);
	}
	intervals_before(rig, rig->begins + point.time);
	sweep(rig, &of);
}

/* --- what came of it --- */

struct tile_posts {
	int32_t *base, *offset;
};

static void read_tiles(struct rig *rig, struct tile_posts *posts)
{
	uint32_t side = tile_posts(rig->extent);
	for (size_t i = 0; i < rig->tile_count; i++) {
		const struct gpu_slot *slot = gpu_slots_get(rig->slots, rig->tiles[i].slot);
		rig_decode(rig, tile_post_rect(rig->extent, rig->tiles[i].tile));
		posts[i] = (struct tile_posts){mem_alloc((size_t)side * side, sizeof(int32_t)),
					       mem_alloc((size_t)side * side, sizeof(int32_t))};
		if (posts[i].base == NULL || posts[i].offset == NULL)
			bench_must(fail_memory("bench"));
		gpu_texture_read(slot->base, 0, (struct gpu_rect){0, 0, side, side}, posts[i].base);
		gpu_texture_read(slot->planes[PLANE_OFFSET], 0, (struct gpu_rect){0, 0, side, side}, posts[i].offset);
	}
}

/* Of the post, in whichever tile; all that have it must agree (law 1). */
static bool post(const struct rig *rig, const struct tile_posts *posts, int64_t x, int64_t y, int32_t *base, int32_t *offset)
{
	uint32_t side = tile_posts(rig->extent);
	bool found = false;
	for (size_t i = 0; i < rig->tile_count; i++) {
		struct post_rect own = tile_post_rect(rig->extent, rig->tiles[i].tile);
		if (x < own.x0 || x >= own.x1 || y < own.y0 || y >= own.y1)
			continue;
		size_t at = (size_t)(y - own.y0) * side + (size_t)(x - own.x0);
		if (found && (posts[i].base[at] != *base || posts[i].offset[at] != *offset))
			bench_must(fail_with(STATUS_FAILED, "bench: two tiles differ at a post they share; mend the variant"));
		*base = posts[i].base[at];
		*offset = posts[i].offset[at];
		found = true;
	}
	return found;
}

/* m3 by which offsets and what was compacted do not add up to nothing. */
static double drift(struct rig *rig, const struct tile_posts *posts)
{
	struct post_rect first = tile_post_rect(rig->extent, rig->tiles[0].tile);
	struct post_rect last = tile_post_rect(rig->extent, rig->tiles[rig->tile_count - 1].tile);
	struct deform_tally tally;
	int64_t sum = 0;
	int32_t base, offset;
	bench_must(deform_tally(rig->deform, &tally));
	for (int64_t y = first.y0; y < last.y1; y++)
		for (int64_t x = first.x0; x < last.x1; x++)
			sum += post(rig, posts, x, y, &base, &offset) ? offset : 0;
	return (double)(sum + tally.compacted) * lattice_offset_metres(1) * rig->of->spacing * rig->of->spacing;
}

static void compare(struct rig *rig, const struct tile_posts *posts, const double *truth, struct accuracy_figures *figures)
{
	struct accuracy_surface surface = {.rect = accuracy_rect(rig->of->spacing), .spacing = rig->of->spacing};
	size_t count = (size_t)((surface.rect.x1 - surface.rect.x0) * (surface.rect.y1 - surface.rect.y0)), i = 0;
	double reference = resident_ground_reference(rig->store);
	surface.heights = mem_alloc(count, sizeof(double));
	if (surface.heights == NULL)
		bench_must(fail_memory("bench"));
	for (int64_t y = surface.rect.y0; y < surface.rect.y1; y++)
		for (int64_t x = surface.rect.x0; x < surface.rect.x1; x++) {
			int32_t base = 0, offset = 0;
			post(rig, posts, x, y, &base, &offset);
			surface.heights[i++] = reference + lattice_base_metres(base) + lattice_offset_metres(offset);
		}
	figures->error = accuracy_compare(truth, &surface);
	figures->hash = XXH3_64bits(surface.heights, count * sizeof(double));
	figures->surface = surface;
}

void accuracy_variant(const struct accuracy_variant *variant, const struct accuracy_truth *truth,
		      struct accuracy_figures *figures)
{
	struct scene *scene = accuracy_scene(variant->model, 1, NULL, 0);
	struct track *track = accuracy_track(scene, variant->spacing);
	struct tile_posts posts[RIG_TILES];
	struct rig rig;
	*figures = (struct accuracy_figures){.time_step = TIME_STEP};
	rig_open(variant, scene, &rig);
	int64_t samples = motion_track_samples(track);
	double seconds = accuracy_ends(track), began = clock_seconds();
	for (int turn = 0; turn < variant->passes; turn++, rig.begins += seconds)
		for (int64_t i = 0; i < samples; i++)
			sample(&rig, track, i);
	gpu_finish(rig.gpu);
	figures->steps = (int64_t)lrint(seconds / TIME_STEP) * variant->passes;
	figures->ms_step = (clock_seconds() - began) * 1e3 / (double)figures->steps;
	figures->p99 = figures->worst = (double)NAN;
	snprintf(figures->gl, sizeof figures->gl, "%s", gpu_info(rig.gpu)->renderer);
	size_t awake = 1;
	for (int i = 0; i < ACCURACY_REST && awake > 0 && truth != NULL; i++)
		awake = interval(&rig);
	figures->awake = (int64_t)awake;
	figures->slot_bytes = rig_slot_bytes(&rig);
	read_tiles(&rig, posts);
	figures->drift = drift(&rig, posts);
	if (truth != NULL)
		compare(&rig, posts, truth->surfaces[variant->model], figures);
	for (size_t i = 0; i < rig.tile_count; i++) {
		mem_free(posts[i].base);
		mem_free(posts[i].offset);
	}
	rig_close(&rig);
	motion_track_destroy(track);
	scene_destroy(scene);
}
