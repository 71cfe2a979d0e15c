/*
 * Fixed regions: the dissertation's first way to deform a large terrain (its figure 22). A region is a tile, with its own textures. Each
 * stage is drawn once in each region that the object touches, at most four, and writes the region's own planes. So nothing is gathered
 * or scattered. The other way is a window (deform.c), which has the same bits.
 *
 * A pass cannot read a plane that it writes, but for the fragment's own post. So smoothing writes the window's layer and the tile in
 * turn, and the last pass writes the tile. Lower envelopes and contacts lie in that layer too, at the posts of the window.
 *
 * Invariants: (1) A region writes only its own tile, and posts of the layer that its tile holds. (2) No pass of a stage reads what another
 * pass of the stage writes. So passes of a stage need not wait for each other. A post on a shared edge is computed in each region that
 * holds it, from equal numbers. (3) Posts around those that the contact writes do not change.
 */
#include <assert.h>
#include <string.h>

#include "deform/internal.h"

#define REGIONS 4

/* Two by two regions: south-west, south-east, north-west, north-east. */
struct regions {
	const struct gpu_slot *slots[REGIONS]; /* NULL: there is no tile, so no ground */
	struct gpu_rect posts[REGIONS];        /* posts of the layer that the contact writes in this region; empty: none */
	int32_t places[REGIONS][4];            /* x, y: from a post in the window to that in the tile */
	int32_t own[REGIONS][4];               /* posts in the window that no region before writes: first, one behind the last */
	int32_t split[2];                      /* first posts in the window of the eastern, and of the northern regions */
	size_t count;                          /* regions in which posts are written */
	struct gpu_texture *none;              /* in the place of a texture that a region lacks */
};

/* std140 twins of the blocks of none.frag, lib/regions.glsl and disturbance.frag. */
struct contact_params_of {
	struct contact_params contact;
	int32_t region[4];
};
struct smooth_params {
	int32_t window[4], written[4], own[4], split[4], places[REGIONS][4];
};
struct disturb_params {
	int32_t region[4];
};

bool deform_takes_regions(enum deform_model model)
{
	return deform_model_takes(model, "regions");
}

/* Finds the first tile, and the tiles in x and in y, that hold posts of the rectangle. Returns false if there is none. */
static bool tiles_of(const struct deform *deform, struct post_rect rect, struct tile *first, uint32_t *wide, uint32_t *high)
{
	struct tile last;
	if (!tile_range_of(deform->params.extent, deform->params.level, rect, first, &last))
		return false;
	*wide = last.x - first->x + 1;
	*high = last.y - first->y + 1;
	return true;
}

bool deform_is_fixed(const struct deform *deform, const struct deform_window *windows, size_t count)
{
	struct tile first;
	uint32_t wide, high;
	return deform->params.fixed && count == 1 && windows[0].parts == 0 && tiles_of(deform, windows[0].read, &first, &wide, &high) &&
	       wide <= 2 && high <= 2;
}

/* Adds the region of a tile. */
static enum status add(struct deform *deform, const struct deform_window *window, const struct tile_slot *tile, struct tile first, struct regions *regions)
{
	const struct post_rect own = tile_post_rect(deform->params.extent, tile->tile), read = window->read;
	const struct post_rect written = post_rect_intersect(own, window->write);
	const uint32_t east = tile->tile.x - first.x, north = tile->tile.y - first.y, k = east + 2 * north;
	regions->places[k][0] = (int32_t)(read.x0 - own.x0);
	regions->places[k][1] = (int32_t)(read.y0 - own.y0);
	if (east == 1)
		regions->split[0] = -regions->places[k][0];
	if (north == 1)
		regions->split[1] = -regions->places[k][1];
	if (!post_rect_empty(written)) {
		struct post_rect only = written;
		TRY(gpu_slots_deform(deform->params.slots, tile->slot));
		regions->posts[k] = (struct gpu_rect){(uint32_t)(written.x0 - read.x0), (uint32_t)(written.y0 - read.y0),
						      (uint32_t)(written.x1 - written.x0), (uint32_t)(written.y1 - written.y0)};
		only.x0 += east == 1 && only.x0 == own.x0;
		only.y0 += north == 1 && only.y0 == own.y0;
		deform_posts_in(window, only, regions->own[k]);
		regions->count++;
	}
	regions->slots[k] = gpu_slots_get(deform->params.slots, tile->slot);
	return STATUS_OK;
}

static enum status find(struct deform *deform, const struct deform_window *window, const struct tile_slot *tiles, size_t count, struct regions *regions)
{
	struct tile first;
	uint32_t wide, high;
	*regions = (struct regions){.split = {INT32_MAX, INT32_MAX}};
	if (!tiles_of(deform, window->read, &first, &wide, &high))
		return STATUS_OK;
	for (size_t i = 0; i < count; i++) {
		const struct tile tile = tiles[i].tile;
		if (tile.x < first.x || tile.y < first.y || tile.x - first.x >= wide || tile.y - first.y >= high)
			continue;
		TRY(add(deform, window, &tiles[i], first, regions));
		regions->none = regions->slots[tile.x - first.x + 2 * (tile.y - first.y)]->base;
	}
	return STATUS_OK;
}

static enum status draw_envelopes(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
				  const struct regions *regions)
{
	struct under_params under;
	/* Triangles are drawn over all regions at once: they bound their own area. */
	if (contact->shape->kind == SOIL_MESH)
		return deform_mesh(deform, contact, window, 0);
	deform_under_of(deform, contact, window->read.x0, window->read.y0, &under);
	for (int k = 0; k < REGIONS; k++)
		if (regions->posts[k].width > 0)
			TRY(deform_under_run(deform, &under, regions->posts[k], 0));
	const bool grousers = contact->shape->kind == SOIL_WHEEL && contact->shape->grousers > 0;
	return grousers ? deform_grousers(deform, contact, window, 0) : STATUS_OK;
}

/* Runs a pass over a region. Fills its program, its target and its posts. */
static enum status run(struct deform *deform, const struct regions *regions, int k, enum deform_fixed_pass which, bool first, struct gpu_pass *pass)
{
	struct deform_request request;
	deform_programs_fixed(&deform->params, which, &request);
	TRY(deform_program(deform, &request, &deform->fixed[which]));
	pass->program = deform->fixed[which];
	pass->target = deform->scratch[0].to[TO_BARE];
	pass->viewport = regions->posts[k];
	pass->beside = !first;
	gpu_pass_run(deform->params.gpu, pass);
	return STATUS_OK;
}

/* Lowers the ground. keeps: writes the offsets to the layer, since the next pass reads them there. */
static enum status lower(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			 const struct regions *regions, bool keeps)
{
	struct contact_params_of params = {deform_contact_params(deform, contact, window, 0), {0}};
	bool first = true;
	for (int k = 0; k < REGIONS; k++) {
		if (regions->posts[k].width == 0)
			continue;
		memcpy(params.region, regions->places[k], sizeof params.region);
		memcpy(params.contact.written, regions->own[k], sizeof params.contact.written);
		TRY(run(deform, regions, k, keeps ? FIXED_CONTACT_KEPT : FIXED_CONTACT, first, &(struct gpu_pass){
			.stage = GPU_CONTACT,
			.images = {regions->slots[k]->base, regions->slots[k]->planes[PLANE_OFFSET], deform->under, deform->rest, deform->contacts,
				   keeps ? deform->planes_of[1][PLANE_OFFSET] : NULL},
			.storage = {deform->tally},
			.params = &params,
			.params_bytes = sizeof params,
		}));
		first = false;
	}
	return STATUS_OK;
}

/* Fills the numbers and the textures by which a pass reads the ground around. */
static void read_around(const struct deform *deform, const struct deform_window *window, const struct regions *regions,
			struct smooth_params *params, struct gpu_texture *textures[GPU_PASS_TEXTURES])
{
	*params = (struct smooth_params){
		.window = {(int32_t)(window->read.x1 - window->read.x0), (int32_t)(window->read.y1 - window->read.y0), 0,
			   (int32_t)deform->params.extent->cells},
		.split = {regions->split[0], regions->split[1]},
	};
	deform_posts_in(window, window->write, params->written);
	memcpy(params->places, regions->places, sizeof params->places);
	for (int k = 0; k < REGIONS; k++) {
		const struct gpu_slot *slot = regions->slots[k];
		const bool offsets = slot != NULL && slot->planes[PLANE_OFFSET] != NULL;
		params->split[2] |= (slot != NULL) << k;
		params->split[3] |= offsets << k;
		textures[k] = slot != NULL ? slot->base : regions->none;
		textures[REGIONS + k] = offsets ? slot->planes[PLANE_OFFSET] : regions->none;
	}
}

/* Smooths once in each region. kept: the ground is read from the layer, and the tile is written; false: the other way round. */
static enum status smooth(struct deform *deform, const struct deform_window *window, const struct regions *regions, bool kept)
{
	struct gpu_texture *const layer = deform->planes_of[1][PLANE_OFFSET];
	struct smooth_params params;
	struct gpu_pass pass = {.stage = GPU_SMOOTH, .params = &params, .params_bytes = sizeof params};
	bool first = true;
	read_around(deform, window, regions, &params, pass.textures);
	pass.images[1] = deform->contacts;
	for (int k = 0; k < REGIONS; k++) {
		if (regions->posts[k].width == 0)
			continue;
		memcpy(params.own, regions->places[k], sizeof params.own);
		pass.images[0] = kept ? layer : NULL;
		pass.images[2] = kept ? regions->slots[k]->planes[PLANE_OFFSET] : layer;
		TRY(run(deform, regions, k, kept ? FIXED_BOX_KEPT : FIXED_BOX, first, &pass));
		first = false;
	}
	return STATUS_OK;
}

static enum status disturb(struct deform *deform, const struct regions *regions)
{
	bool first = true;
	for (int k = 0; k < REGIONS; k++) {
		if (regions->posts[k].width == 0)
			continue;
		struct disturb_params params;
		memcpy(params.region, regions->places[k], sizeof params.region);
		TRY(run(deform, regions, k, FIXED_DISTURBANCE, first, &(struct gpu_pass){
			.stage = GPU_DISTURBANCE,
			.images = {regions->slots[k]->planes[PLANE_OFFSET], deform->contacts, regions->slots[k]->planes[PLANE_DISTURBANCE]},
			.params = &params,
			.params_bytes = sizeof params,
		}));
		first = false;
	}
	return STATUS_OK;
}

static enum status run_stages(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			      const struct regions *regions)
{
	const bool smooths = deform_model_row(deform->params.model)->smooths && !deform_is_contact_only(contact);
	const int times = smooths ? deform->params.box_repetitions : 0;
	TRY(draw_envelopes(deform, contact, window, regions));
	/* The last of the passes that follow writes the tiles. */
	bool kept = times % 2 == 1;
	TRY(lower(deform, contact, window, regions, kept));
	for (int i = 0; i < times; i++, kept = !kept)
		TRY(smooth(deform, window, regions, kept));
	assert(!kept);
	return deform->params.disturbance ? disturb(deform, regions) : STATUS_OK;
}

enum status deform_fixed(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			 const struct tile_slot *tiles, size_t count, size_t *written)
{
	struct regions regions;
	assert(deform_is_fixed(deform, window, 1));
	TRY(find(deform, window, tiles, count, &regions));
	TRY(run_stages(deform, contact, window, &regions));
	*written = regions.count;
	return gpu_check(deform->params.gpu, "deformation");
}

/* --- before the first step --- */

/* Runs each program of an object's contacts once. A tile of no ground takes what they write. */
enum status deform_fixed_warm(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window)
{
	struct gpu *gpu = deform->params.gpu;
	const uint32_t side = (uint32_t)(window->read.x1 - window->read.x0);
	const struct gpu_rect all = {0, 0, side, side};
	struct gpu_slot slot = {.base = NULL};
	struct regions regions = {.slots = {&slot}, .posts = {all}, .split = {INT32_MAX, INT32_MAX}, .count = 1};
	enum status status;
	TRY_OR(done, gpu_texture_create(gpu, GPU_R32I, side, side, 0, &slot.base));
	TRY_OR(done, gpu_texture_create(gpu, GPU_R32I, side, side, 0, &slot.planes[PLANE_OFFSET]));
	TRY_OR(done, gpu_texture_create(gpu, GPU_R8UI, side, side, 0, &slot.planes[PLANE_DISTURBANCE]));
	gpu_texture_clear(slot.base, 0, all, BASE_NODATA);
	gpu_texture_clear(slot.planes[PLANE_OFFSET], 0, all, 0);
	gpu_texture_clear(slot.planes[PLANE_DISTURBANCE], 0, all, 0);
	regions.none = slot.base;
	TRY_OR(done, run_stages(deform, contact, window, &regions));
done:
	gpu_texture_destroy(slot.planes[PLANE_DISTURBANCE]);
	gpu_texture_destroy(slot.planes[PLANE_OFFSET]);
	gpu_texture_destroy(slot.base);
	return status;
}
