/*
 * Tiles whose base and offsets are kept in another format, and the passes between that and the lattice.
 *
 *   base    R8, R16: codes over the terrain's relief, as the dissertation loads its heights; R16F, R32F: metres from
 *           the store's reference
 *   offset  R8, R16: signed codes over +-RANGE (the dissertation stores "normalized compression offsets" and gives no
 *           range: RANGE holds the deepest rut and the highest heap here with some room, as one would choose it);
 *           R16F, R32F: metres
 */
#include "accuracy_rig.h"

#include <math.h>
#include <string.h>

#include "bench.h"
#include "gpu/internal.h"

#define RANGE 0.5 /* m */
#define SPARE 1.0 /* m around the field that tiles must be there for */

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

const struct soil_shape rig_wheel = {.kind = SOIL_WHEEL, .radius = ACCURACY_RADIUS, .width = ACCURACY_WIDTH};

const char *accuracy_format_name(enum accuracy_format format)
{
	return formats[format].name;
}

size_t accuracy_format_bytes(enum accuracy_format format)
{
	return formats[format].bytes;
}

static void get_programs(struct rig *rig)
{
	static struct shader_text table[3];
	table[0] = accuracy_shaders[0];
	for (const struct shader_text *file = gpu_shader_table; file->path != NULL; file++)
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
	return (struct kept_params){(float)(meta->low - resident_ground_reference(rig->store)), 1,
				    (top - 1) / (float)(meta->high - meta->low), top};
}

/* Over the posts of `rect` that the tile has. */
static void pass(struct rig *rig, size_t tile, enum which which, bool encode, struct post_rect rect)
{
	struct post_rect own = tile_post_rect(rig->extent, rig->tiles[tile].tile), both = post_rect_intersect(own, rect);
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
	return !post_rect_empty(post_rect_intersect(tile_post_rect(rig->extent, rig->tiles[tile].tile), rect));
}

void rig_decode(struct rig *rig, struct post_rect read)
{
	for (size_t i = 0; i < rig->tile_count; i++) {
		for (int which = 0; which < WHICH; which++)
			pass(rig, i, (enum which)which, false, read);
		rig->read[i] = rig->read[i] || shares(rig, i, read);
	}
}

void rig_encode(struct rig *rig, struct post_rect written)
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
	bench_must(gpu_texture_create(rig->gpu, formats[rig->format[which]].format, rig->extent->cells + 1, rig->extent->cells + 1, 0,
				      &kept->texture));
	kept->encoded = target_over(rig, kept->texture);
	kept->decoded = target_over(rig, which == BASE ? slot->base : slot->planes[PLANE_OFFSET]);
	pass(rig, tile, which, true, tile_post_rect(rig->extent, rig->tiles[tile].tile));
}

static void make_tiles(struct rig *rig)
{
	int64_t spare = (int64_t)ceil(SPARE / rig->of->spacing);
	struct post_rect field = accuracy_rect(rig->of->spacing);
	struct post_rect all = {field.x0 - spare, field.y0 - spare, field.x1 + spare, field.y1 + spare};
	struct tile first, last;
	size_t bytes = (size_t)tile_posts(rig->extent) * tile_posts(rig->extent) * sizeof(int32_t);
	struct gpu_staging *staging;
	bool any = tile_range_of(rig->extent, 0, all, &first, &last);
	if (!any || (last.x - first.x + 1) * (last.y - first.y + 1) > RIG_TILES)
		bench_must(fail_with(STATUS_FAILED, "bench: the field takes more tiles than expected; raise RIG_TILES"));
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++) {
			rig->tiles[rig->tile_count] = (struct tile_slot){{0, x, y}, (uint32_t)rig->tile_count};
			rig->tile_count++;
		}
	bench_must(gpu_slots_create(rig->gpu, rig->extent->cells, (uint32_t)rig->tile_count, deform_planes(rig->of->model, false, false),
				    &rig->slots));
	bench_must(gpu_staging_create(rig->gpu, bytes, &staging));
	for (size_t i = 0; i < rig->tile_count; i++) {
		gpu_finish(rig->gpu);
		bench_must(resident_ground_posts(rig->ground, rig->tiles[i].tile, gpu_staging_bytes(staging)));
		bench_must(gpu_slots_upload_base(rig->slots, rig->tiles[i].slot, staging, 0));
		bench_must(gpu_slots_deform(rig->slots, rig->tiles[i].slot));
		keep(rig, i, BASE);
		keep(rig, i, OFFSET);
	}
	gpu_staging_destroy(staging);
}

void rig_open(const struct accuracy_variant *of, const struct scene *scene, struct rig *rig)
{
	*rig = (struct rig){.of = of, .format = {of->base, of->offset}};
	bench_must(store_open(accuracy_store(of->spacing, of->max_error), &(struct store_options){.mode = STORE_READ}, &rig->store));
	bench_must(resident_ground_create(rig->store, 16, &rig->ground));
	const struct store_meta *meta = store_meta(rig->store);
	rig->extent = &meta->extent;
	bench_must(gpu_create(&(struct gpu_params){.draws = false}, &rig->gpu));
	get_programs(rig);
	for (int which = 0; which < WHICH; which++)
		rig->params[which] = params_of(rig, (enum which)which);
	make_tiles(rig);
	struct deform_params params = {
		.gpu = rig->gpu,
		.slots = rig->slots,
		.extent = rig->extent,
		.reference = resident_ground_reference(rig->store),
		.model = of->model,
		.soils = {scene->soils[0]},
		.soil_count = 1,
		.iterations = scene->iterations,
		.relief = meta->high - meta->low,
		.depth = scene->depth,
		.along_lines = true,
		.undisturbed_stable = scene->undisturbed == SCENE_STABLE,
		.bulldozing = scene->bulldozing,
	};
	bench_must(deform_create(&params, &rig->deform));
	bench_must(deform_warm(rig->deform, &(struct deform_planned){&rig_wheel, true, false}));
	rig_decode(rig, accuracy_rect(of->spacing)); /* warms its programs too; encoding the tiles was that */
	gpu_finish(rig->gpu);
	memset(rig->read, 0, sizeof rig->read);
}

void rig_close(struct rig *rig)
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
	resident_ground_destroy(rig->ground);
	store_close(rig->store);
}

int64_t rig_slot_bytes(const struct rig *rig)
{
	int64_t side = tile_posts(rig->extent), bytes = 0;
	for (size_t i = 0; i < rig->tile_count; i++)
		bytes += (rig->read[i] ? (int64_t)formats[rig->of->base].bytes : 0) +
			 (rig->written[i] ? (int64_t)formats[rig->of->offset].bytes : 0);
	return bytes * side * side;
}
