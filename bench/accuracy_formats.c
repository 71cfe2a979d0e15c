/*
 * The same drive straight through deform.h, with the slots' base and offsets kept in another texture format.
 *
 * Deformation computes on the lattice, whatever they are kept in: a variant holds each plane in a texture of its own
 * format, one pass brings it back to the lattice over the posts that a gather will read, and one puts it into its format
 * over those that a scatter wrote. So what a format loses is lost sweep by sweep, as it would be. The lattice itself
 * (R32I) takes no such pass, since gathering copies. These passes are in the times.
 *
 *   base    R8, R16: codes over the terrain's relief, as the dissertation loads its heights; R16F, R32F: metres from
 *           the store's reference
 *   offset  R8, R16: signed codes over +-RANGE (the dissertation stores "normalized compression offsets" and gives no
 *           range: RANGE holds the deepest rut and the highest heap here with some room, as one would choose it);
 *           R16F, R32F: metres
 *
 * Invariant: with R32I for both the ground becomes bit for bit what the product makes of it.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <xxhash.h>

#include "accuracy.h"
#include "bench.h"
#include "gpu/internal.h"
#include "run/ground.h"
#include "store/store.h"

#define RANGE 0.5      /* m */
#define INTERVAL 0.05  /* s: a scene's default, as the time step */
#define TIME_STEP 0.02
#define SPARE 1.0      /* m around the field that tiles must be there for */
enum { TILES_MOST = 64 };

extern const struct shader_text accuracy_shaders[];

static const struct {
	const char *name;
	enum gpu_format format;
	uint32_t bits; /* of a normalised code, 0: floats */
	size_t bytes;
} formats[KEPT_FORMATS] = {
	[KEPT_R8] = {"R8", GPU_R8, 8, 1},      [KEPT_R16] = {"R16", GPU_R16, 16, 2}, [KEPT_R16F] = {"R16F", GPU_R16F, 0, 2},
	[KEPT_R32F] = {"R32F", GPU_R32F, 0, 4}, [KEPT_R32I] = {"R32I", GPU_R32I, 0, 4},
};

const char *accuracy_format_name(enum accuracy_format format)
{
	return formats[format].name;
}

size_t accuracy_format_bytes(enum accuracy_format format)
{
	return formats[format].bytes;
}

/* std140 twin of kept.frag's block. */
struct kept_params {
	float low, zero, codes, top;
};

enum which { BASE, OFFSET, WHICH };

/* A plane as it is kept, of one tile. */
struct kept {
	struct gpu_texture *texture;
	struct gpu_target *encoded, *decoded; /* over the texture, and over the slot's */
};

struct rig {
	const struct accuracy_variant *of;
	enum accuracy_format format[WHICH];
	struct store *store;
	struct ground *ground;
	const struct world *world;
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct deform *deform;
	struct deform_tile tiles[TILES_MOST];
	struct kept kept[TILES_MOST][WHICH];
	bool read[TILES_MOST], written[TILES_MOST];
	size_t tile_count;
	struct gpu_program *encode[WHICH], *decode[WHICH];
	struct kept_params params[WHICH];
	struct deform_rest rest; /* the wheel where it was set last */
	bool in_contact;
	double begins;           /* of this pass over the path, s */
	int64_t intervals;       /* that are over */
};

static const struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = ACCURACY_RADIUS, .width = ACCURACY_WIDTH};

/* --- the passes --- */

static void get_programs(struct rig *rig)
{
	static struct shader_text table[3];
	table[0] = accuracy_shaders[0];
	for (const struct shader_text *file = shader_table; file->path != NULL; file++)
		if (strcmp(file->path, "full.vert") == 0)
			table[1] = *file;
	for (int which = 0; which < WHICH; which++)
		for (int encode = 0; encode < 2; encode++) {
			struct gpu_program_request request = {.vertex = "full.vert", .fragment = table[0].path};
			size_t count = 0;
			if (encode == 1)
				request.defines[count++] = "ENCODE";
			if (which == BASE)
				request.defines[count++] = "BASE";
			if (formats[rig->format[which]].bits > 0)
				request.defines[count++] = "NORMALISED";
			if (rig->format[which] == KEPT_R16F)
				request.defines[count++] = "HALF";
			if (rig->format[which] != KEPT_R32I)
				bench_must(gpu_program_get_from(rig->gpu, table, &request,
								encode == 1 ? &rig->encode[which] : &rig->decode[which]));
		}
}

static struct kept_params params_of(const struct rig *rig, enum which which)
{
	const struct store_meta *meta = store_meta(rig->store);
	float top = (float)((1u << formats[rig->format[which]].bits) - 1), half = (top + 1) / 2;
	if (which == OFFSET)
		return (struct kept_params){0, half, (half - 1) / (float)RANGE, top};
	return (struct kept_params){(float)(meta->low - ground_reference(rig->store)), 1,
				    (top - 1) / (float)(meta->high - meta->low), top};
}

/* Over the posts of `rect` that the tile has. */
static void pass(struct rig *rig, size_t tile, enum which which, bool encode, struct post_rect rect)
{
	struct post_rect own = tile_post_rect(rig->world, rig->tiles[tile].tile), both = post_rect_intersect(own, rect);
	const struct kept *kept = &rig->kept[tile][which];
	const struct gpu_slot *slot = gpu_slots_get(rig->slots, rig->tiles[tile].slot);
	if (post_rect_empty(both) || kept->texture == NULL)
		return;
	gpu_pass_run(rig->gpu, &(struct gpu_pass){
		.stage = GPU_SUBDIVIDE, /* nothing else here is */
		.program = encode ? rig->encode[which] : rig->decode[which],
		.target = encode ? kept->encoded : kept->decoded,
		.viewport = {(uint32_t)(both.x0 - own.x0), (uint32_t)(both.y0 - own.y0), (uint32_t)(both.x1 - both.x0),
			     (uint32_t)(both.y1 - both.y0)},
		.textures = {!encode ? kept->texture : which == BASE ? slot->base : slot->planes[PLANE_OFFSET]},
		.params = &rig->params[which],
		.params_bytes = sizeof rig->params[which],
	});
}

static bool shares(const struct rig *rig, size_t tile, struct post_rect rect)
{
	return !post_rect_empty(post_rect_intersect(tile_post_rect(rig->world, rig->tiles[tile].tile), rect));
}

static void decode(struct rig *rig, struct post_rect read)
{
	for (size_t i = 0; i < rig->tile_count; i++) {
		for (int which = 0; which < WHICH; which++)
			pass(rig, i, (enum which)which, false, read);
		rig->read[i] = rig->read[i] || shares(rig, i, read);
	}
}

static void encode(struct rig *rig, struct post_rect written)
{
	for (size_t i = 0; i < rig->tile_count; i++) {
		pass(rig, i, OFFSET, true, written);
		rig->written[i] = rig->written[i] || shares(rig, i, written);
	}
}

/* --- what is driven over --- */

static struct gpu_target *target_over(struct rig *rig, struct gpu_texture *texture)
{
	struct gpu_target *target;
	bench_must(gpu_target_create(rig->gpu, &(struct gpu_attachment){texture, 0}, 1, (struct gpu_attachment){NULL, 0}, &target));
	return target;
}

static void keep(struct rig *rig, size_t tile, enum which which)
{
	struct kept *kept = &rig->kept[tile][which];
	const struct gpu_slot *slot = gpu_slots_get(rig->slots, rig->tiles[tile].slot);
	if (rig->format[which] == KEPT_R32I)
		return;
	bench_must(gpu_texture_create(rig->gpu, formats[rig->format[which]].format, rig->world->cells + 1, rig->world->cells + 1, 0,
				      &kept->texture));
	kept->encoded = target_over(rig, kept->texture);
	kept->decoded = target_over(rig, which == BASE ? slot->base : slot->planes[PLANE_OFFSET]);
	pass(rig, tile, which, true, tile_post_rect(rig->world, rig->tiles[tile].tile));
}

static void make_tiles(struct rig *rig)
{
	int64_t spare = (int64_t)ceil(SPARE / rig->of->spacing);
	struct post_rect field = accuracy_rect(rig->of->spacing);
	struct post_rect all = {field.x0 - spare, field.y0 - spare, field.x1 + spare, field.y1 + spare};
	struct tile first, last;
	size_t bytes = (size_t)tile_posts(rig->world) * tile_posts(rig->world) * sizeof(int32_t);
	struct gpu_staging *staging;
	bool any = tile_range_of(rig->world, 0, all, &first, &last);
	if (!any || (last.x - first.x + 1) * (last.y - first.y + 1) > TILES_MOST)
		bench_must(fail_with(STATUS_FAILED, "bench: the field takes more tiles than expected; raise TILES_MOST"));
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++) {
			rig->tiles[rig->tile_count] = (struct deform_tile){{0, x, y}, (uint32_t)rig->tile_count};
			rig->tile_count++;
		}
	bench_must(gpu_slots_create(rig->gpu, rig->world->cells, (uint32_t)rig->tile_count, deform_planes(rig->of->model, false),
				    &rig->slots));
	bench_must(gpu_staging_create(rig->gpu, bytes, &staging));
	for (size_t i = 0; i < rig->tile_count; i++) {
		gpu_finish(rig->gpu);
		bench_must(ground_posts(rig->ground, rig->tiles[i].tile, gpu_staging_bytes(staging)));
		bench_must(gpu_slots_upload_base(rig->slots, rig->tiles[i].slot, staging, 0));
		bench_must(gpu_slots_deform(rig->slots, rig->tiles[i].slot));
		keep(rig, i, BASE);
		keep(rig, i, OFFSET);
	}
	gpu_staging_destroy(staging);
}

static void open_rig(const struct accuracy_variant *of, const struct scene *scene, struct rig *rig)
{
	*rig = (struct rig){.of = of, .format = {of->base, of->offset}};
	bench_must(store_open(accuracy_store(of->spacing, of->max_error), &(struct store_options){.mode = STORE_READ}, &rig->store));
	bench_must(ground_create(rig->store, 16, &rig->ground));
	const struct store_meta *meta = store_meta(rig->store);
	rig->world = &meta->world;
	bench_must(gpu_create(&(struct gpu_params){.draws = false}, &rig->gpu));
	get_programs(rig);
	for (int which = 0; which < WHICH; which++)
		rig->params[which] = params_of(rig, (enum which)which);
	make_tiles(rig);
	struct deform_params params = {
		.gpu = rig->gpu,
		.slots = rig->slots,
		.world = rig->world,
		.reference = ground_reference(rig->store),
		.model = of->model,
		.soils = {scene->soils[0]},
		.soil_count = 1,
		.iterations = scene->iterations,
		.relief = meta->high - meta->low,
		.depth = scene->depth,
		.stands = scene->undisturbed == SCENE_STANDS,
		.bulldozing = scene->bulldozing,
	};
	bench_must(deform_create(&params, &rig->deform));
	bench_must(deform_warm(rig->deform, &wheel, 0, false));
	decode(rig, accuracy_rect(of->spacing)); /* warms its programs too; encoding the tiles was that */
	gpu_finish(rig->gpu);
	memset(rig->read, 0, sizeof rig->read);
}

static void close_rig(struct rig *rig)
{
	deform_destroy(rig->deform);
	for (size_t i = 0; i < rig->tile_count; i++)
		for (int which = 0; which < WHICH; which++) {
			gpu_target_destroy(rig->kept[i][which].encoded);
			gpu_target_destroy(rig->kept[i][which].decoded);
			gpu_texture_destroy(rig->kept[i][which].texture);
		}
	gpu_slots_destroy(rig->slots);
	gpu_destroy(rig->gpu);
	ground_destroy(rig->ground);
	store_close(rig->store);
}

/* --- driving --- */

static size_t interval(struct rig *rig)
{
	size_t count;
	bench_must(deform_interval_begin(rig->deform, &rig->rest, rig->in_contact ? 1 : 0, &count));
	for (size_t i = 0; i < count; i++) {
		decode(rig, deform_interval_reads(rig->deform, i));
		bench_must(deform_interval_gather(rig->deform, i, rig->tiles, rig->tile_count));
	}
	for (size_t i = 0; i < count; i++) {
		bench_must(deform_interval_scatter(rig->deform, i, rig->tiles, rig->tile_count));
		encode(rig, deform_interval_writes(rig->deform, i));
	}
	if (count > 0)
		bench_must(deform_interval_end(rig->deform));
	return count;
}

/* Those that are over before `time`: stations of the same time come first. */
static void intervals_before(struct rig *rig, double time)
{
	for (; (double)(rig->intervals + 1) * INTERVAL < time; rig->intervals++)
		interval(rig);
}

static void sweep(struct rig *rig, const struct deform_sweep *of)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	bench_must(deform_windows(rig->deform, of, windows, &count));
	if (rig->in_contact && !deform_covers(rig->deform, of, &rig->rest.pose)) {
		const struct deform_sweep left = {.shape = &wheel, .from = rig->rest.pose, .to = rig->rest.pose};
		struct deform_window around[DEFORM_WINDOWS_MAX];
		size_t number;
		bench_must(deform_windows(rig->deform, &left, around, &number));
		for (size_t i = 0; i < number; i++)
			bench_must(deform_wake(rig->deform, around[i].write));
	}
	for (size_t i = 0; i < count; i++) {
		decode(rig, windows[i].read);
		bench_must(deform_compute(rig->deform, of, &windows[i], (uint32_t)i, rig->tiles, rig->tile_count));
	}
	for (size_t i = 0; i < count; i++) {
		bench_must(deform_scatter(rig->deform, &windows[i], (uint32_t)i, rig->tiles, rig->tile_count));
		encode(rig, windows[i].write);
		bench_must(deform_wake_swept(rig->deform, &windows[i], (uint32_t)i));
	}
	rig->rest = (struct deform_rest){.shape = &wheel, .pose = of->to};
	rig->in_contact = true;
}

static void station(struct rig *rig, const struct track *track, int64_t index)
{
	struct track_point point;
	int64_t ground;
	bool any;
	track_station(track, index, &point);
	bench_must(ground_height(rig->ground, point.qx, point.qy, &ground, &any));
	struct deform_sweep of = {.shape = &wheel};
	of.to = (struct deform_pose){.x = point.qx, .y = point.qy, .z = ground + lattice_offset(ACCURACY_RADIUS - ACCURACY_SINK),
				     .yaw = point.yaw};
	of.from = index > 0 ? rig->rest.pose : of.to;
	if (index > 0) {
		double along = lattice_offset_metres(of.to.x - of.from.x) * cos(of.to.yaw) +
			       lattice_offset_metres(of.to.y - of.from.y) * sin(of.to.yaw);
		of.seconds = point.time - track_station_time(track, index - 1);
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
	uint32_t side = tile_posts(rig->world);
	for (size_t i = 0; i < rig->tile_count; i++) {
		const struct gpu_slot *slot = gpu_slots_get(rig->slots, rig->tiles[i].slot);
		decode(rig, tile_post_rect(rig->world, rig->tiles[i].tile));
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
	uint32_t side = tile_posts(rig->world);
	bool found = false;
	for (size_t i = 0; i < rig->tile_count; i++) {
		struct post_rect own = tile_post_rect(rig->world, rig->tiles[i].tile);
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
	struct post_rect first = tile_post_rect(rig->world, rig->tiles[0].tile);
	struct post_rect last = tile_post_rect(rig->world, rig->tiles[rig->tile_count - 1].tile);
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
	double reference = ground_reference(rig->store);
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

/* As the product counts them: a base of every tile that was read, an offset of every one that was written. */
static int64_t slot_bytes(const struct rig *rig)
{
	int64_t side = tile_posts(rig->world), bytes = 0;
	for (size_t i = 0; i < rig->tile_count; i++)
		bytes += (rig->read[i] ? (int64_t)formats[rig->of->base].bytes : 0) +
			 (rig->written[i] ? (int64_t)formats[rig->of->offset].bytes : 0);
	return bytes * side * side;
}

void accuracy_variant(const struct accuracy_variant *variant, const struct accuracy_truth *truth,
		      struct accuracy_figures *figures)
{
	struct scene *scene = accuracy_scene(variant->model, 1, NULL, 0);
	struct track *track = accuracy_track(scene, variant->spacing);
	struct tile_posts posts[TILES_MOST];
	struct rig rig;
	*figures = (struct accuracy_figures){.time_step = TIME_STEP};
	open_rig(variant, scene, &rig);
	int64_t stations = track_stations(track);
	double seconds = accuracy_ends(track), began = clock_seconds();
	for (int turn = 0; turn < variant->passes; turn++, rig.begins += seconds)
		for (int64_t i = 0; i < stations; i++)
			station(&rig, track, i);
	gpu_finish(rig.gpu);
	figures->steps = (int64_t)lrint(seconds / TIME_STEP) * variant->passes;
	figures->ms_step = (clock_seconds() - began) * 1e3 / (double)figures->steps;
	figures->p50 = figures->p99 = (double)NAN;
	snprintf(figures->gl, sizeof figures->gl, "%s", gpu_info(rig.gpu)->renderer);
	size_t awake = 1;
	for (int i = 0; i < ACCURACY_REST && awake > 0 && truth != NULL; i++)
		awake = interval(&rig);
	figures->awake = (int64_t)awake;
	figures->slot_bytes = slot_bytes(&rig);
	read_tiles(&rig, posts);
	figures->drift = drift(&rig, posts);
	if (truth != NULL)
		compare(&rig, posts, truth->surfaces[variant->model], figures);
	for (size_t i = 0; i < rig.tile_count; i++) {
		mem_free(posts[i].base);
		mem_free(posts[i].offset);
	}
	close_rig(&rig);
	track_destroy(track);
	scene_destroy(scene);
}
