/*
 * Fixed regions: the dissertation's first way to deform a large terrain (its figure 22). A region is a tile, with its own textures. Each
 * stage is drawn once in each region that a contact reads, at most four, and writes the region's own planes. So nothing is gathered
 * or scattered. The other way is a window (deform.c), which has the same bits.
 *
 * A pass cannot read a plane that it writes, but for the fragment's own post. So passes that smoothing reads write the window's layer, and the last
 * pass writes the tiles. Lower envelopes and contacts lie in that layer too, at the posts of the window. So a pass reads the posts of other
 * regions there.
 *
 * Invariants: (1) A region writes only its own tile, and posts of the layer that its tile holds. It writes the tile only at posts that the
 * contact writes. (2) No pass of a stage reads what another pass of the stage writes. So passes of a stage need not wait for each other. A
 * post on a shared edge is computed in each region that holds it, from equal numbers.
 */
#include <assert.h>
#include <string.h>

#include "deform/internal.h"

#define REGIONS 4
#define NO_GROUND 32 /* lib/window.glsl */

/* Two by two regions: south-west, south-east, north-west, north-east. */
struct regions {
	const struct gpu_slot *slots[REGIONS]; /* NULL: there is no tile, so no ground */
	struct gpu_rect posts[REGIONS];        /* posts of the layer that this region has; empty: none */
	int32_t places[REGIONS][4];            /* x, y: from a post in the window to that in the tile; 1: it has offsets */
	int32_t own[REGIONS][4];               /* written posts in the window that no region before writes: first, one behind the last */
	size_t count;
};

/* std140 twins of the blocks of none.frag, box.frag and disturbance.frag. */
struct lower_params {
	struct contact_params contact;
	int32_t region[4], reached[4];
};
struct smooth_params {
	struct window_params window;
	int32_t region[4], reached[4];
};
struct disturb_params {
	int32_t region[4], reached[4];
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

/* Adds the region of a tile. One that the contact writes gets offsets. */
static enum status add(struct deform *deform, const struct deform_window *window, const struct tile_slot *tile, struct tile first, struct regions *regions)
{
	const struct post_rect own = tile_post_rect(deform->params.extent, tile->tile), read = window->read;
	const struct post_rect has = post_rect_intersect(own, read);
	const uint32_t east = tile->tile.x - first.x, north = tile->tile.y - first.y, k = east + 2 * north;
	struct post_rect only = post_rect_intersect(own, window->write);
	if (!post_rect_empty(only)) {
		TRY(gpu_slots_deform(deform->params.slots, tile->slot));
		only.x0 += east == 1 && only.x0 == own.x0;
		only.y0 += north == 1 && only.y0 == own.y0;
		deform_posts_in(window, only, regions->own[k]);
	}
	regions->slots[k] = gpu_slots_get(deform->params.slots, tile->slot);
	regions->posts[k] = (struct gpu_rect){(uint32_t)(has.x0 - read.x0), (uint32_t)(has.y0 - read.y0), (uint32_t)(has.x1 - has.x0), (uint32_t)(has.y1 - has.y0)};
	regions->places[k][0] = (int32_t)(read.x0 - own.x0);
	regions->places[k][1] = (int32_t)(read.y0 - own.y0);
	regions->places[k][2] = regions->slots[k]->planes[PLANE_OFFSET] != NULL;
	regions->count++;
	return STATUS_OK;
}

static enum status find(struct deform *deform, const struct deform_window *window, const struct tile_slot *tiles, size_t count, struct regions *regions)
{
	struct tile first;
	uint32_t wide, high;
	*regions = (struct regions){.count = 0};
	if (!tiles_of(deform, window->read, &first, &wide, &high))
		return STATUS_OK;
	for (size_t i = 0; i < count; i++) {
		const struct tile tile = tiles[i].tile;
		if (tile.x >= first.x && tile.y >= first.y && tile.x - first.x < wide && tile.y - first.y < high)
			TRY(add(deform, window, &tiles[i], first, regions));
	}
	return STATUS_OK;
}

/* Beyond the world there is no ground, and no region. */
static void clear_beyond(struct deform *deform, const struct deform_window *window)
{
	const struct extent *extent = deform->params.extent;
	const int level = deform->params.level;
	const struct post_rect read = window->read;
	if (deform->contacts != NULL && (read.x0 < 0 || read.y0 < 0 || read.x1 > extent_tiles_x(extent, level) * (int64_t)extent->cells + 1 ||
					 read.y1 > extent_tiles_y(extent, level) * (int64_t)extent->cells + 1))
		gpu_texture_clear(deform->contacts, 0, deform_window_rect(window), NO_GROUND);
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
		if (regions->slots[k] != NULL)
			TRY(deform_under_run(deform, &under, regions->posts[k], 0));
	const bool grousers = contact->shape->kind == SOIL_WHEEL && contact->shape->grousers > 0;
	return grousers ? deform_grousers(deform, contact, window, 0) : STATUS_OK;
}

/* Returns a region's plane. A region that the contact does not write may have none: then that of another region, which nothing is read
 * from or written to. */
static struct gpu_texture *plane_of(const struct regions *regions, int k, enum plane plane)
{
	const struct gpu_slot *const *slots = regions->slots;
	for (int i = 0; i < REGIONS; i++) {
		const int at = (k + i) % REGIONS;
		if (slots[at] != NULL && slots[at]->planes[plane] != NULL)
			return slots[at]->planes[plane];
	}
	return NULL;
}

/* What of a region's tile a pass has as an image. */
enum of_tile { OF_NO_TILE, OF_BASE, OF_OFFSET, OF_DISTURBANCE };

/* A pass that runs once in each region. */
struct stage {
	enum deform_fixed_pass which; /* FIXED_PASSES: it reads and writes no tile, and has its program */
	struct gpu_pass pass;         /* the caller owns its parameters */
	int32_t *region;              /* four of these parameters, which are filled for each region; NULL: the pass has none */
	int32_t *own;                 /* four more: the posts that no region before writes; NULL: the pass has none */
	enum of_tile images[4];       /* takes the place of the pass's image */
};

static enum status run(struct deform *deform, const struct regions *regions, struct stage *stage)
{
	struct gpu_pass *pass = &stage->pass;
	struct deform_request request;
	if (stage->which != FIXED_PASSES) {
		deform_programs_fixed(&deform->params, stage->which, &request);
		TRY(deform_program(deform, &request, &deform->fixed[stage->which]));
		pass->program = deform->fixed[stage->which];
	}
	for (int k = 0; k < REGIONS; k++) {
		if (regions->slots[k] == NULL)
			continue;
		if (stage->region != NULL)
			memcpy(stage->region, regions->places[k], sizeof regions->places[k]);
		if (stage->own != NULL)
			memcpy(stage->own, regions->own[k], sizeof regions->own[k]);
		for (size_t i = 0; i < sizeof stage->images / sizeof *stage->images; i++)
			if (stage->images[i] == OF_BASE)
				pass->images[i] = regions->slots[k]->base;
			else if (stage->images[i] != OF_NO_TILE)
				pass->images[i] = plane_of(regions, k, stage->images[i] == OF_OFFSET ? PLANE_OFFSET : PLANE_DISTURBANCE);
		pass->viewport = regions->posts[k];
		gpu_pass_run(deform->params.gpu, pass);
		pass->beside = true;
	}
	return STATUS_OK;
}

/* Lowers the ground. keeps: writes the offsets to the layer, since smoothing reads them there. */
static enum status lower(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			 const struct regions *regions, bool keeps)
{
	struct lower_params params = {.contact = deform_contact_params(deform, contact, window, 0)};
	struct stage stage = {
		.which = keeps ? FIXED_CONTACT_KEPT : FIXED_CONTACT, .region = params.region, .own = params.contact.written, .images = {OF_BASE, OF_OFFSET},
		.pass = {
			.stage = GPU_CONTACT,
			.target = deform->scratch[0].to[keeps ? TO_CONTACT : TO_BARE],
			.images = {[2] = deform->under, deform->rest, keeps ? NULL : deform->contacts},
			.storage = {deform->tally},
			.params = &params,
			.params_bytes = sizeof params,
		},
	};
	deform_posts_in(window, window->write, params.reached);
	deform->scratch[0].now[PLANE_OFFSET] = 1;
	return run(deform, regions, &stage);
}

/* Smooths once in each region. last: writes the tiles; false: the layer's other plane. */
static enum status smooth(struct deform *deform, const struct deform_window *window, const struct regions *regions, bool last)
{
	struct layer *scratch = &deform->scratch[0];
	const int now = scratch->now[PLANE_OFFSET];
	struct smooth_params params = {.window = deform_window_params(window->read, 0)};
	struct deform_request request;
	deform_posts_in(window, window->write, params.reached);
	if (!last) {
		deform_programs_box(&deform->params, &request);
		TRY(deform_program(deform, &request, &deform->box));
	}
	struct stage stage = {
		.which = last ? FIXED_BOX : FIXED_PASSES, .region = params.region, .images = {[2] = last ? OF_OFFSET : OF_NO_TILE},
		.pass = {
			.stage = GPU_SMOOTH,
			.program = deform->box,
			.target = scratch->to[last ? TO_BARE : now == 0 ? TO_SECOND : TO_FIRST],
			.images = {deform->planes_of[now][PLANE_OFFSET], deform->contacts},
			.params = &params,
			.params_bytes = last ? sizeof params : sizeof params.window,
		},
	};
	scratch->now[PLANE_OFFSET] = 1 - now;
	return run(deform, regions, &stage);
}

static enum status disturb(struct deform *deform, const struct deform_window *window, const struct regions *regions)
{
	struct disturb_params params;
	struct stage stage = {
		.which = FIXED_DISTURBANCE, .region = params.region, .images = {OF_OFFSET, [2] = OF_DISTURBANCE},
		.pass = {
			.stage = GPU_DISTURBANCE,
			.target = deform->scratch[0].to[TO_BARE],
			.images = {[1] = deform->contacts},
			.params = &params,
			.params_bytes = sizeof params,
		},
	};
	deform_posts_in(window, window->write, params.reached);
	return run(deform, regions, &stage);
}

static enum status run_stages(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			      const struct regions *regions)
{
	const bool smooths = deform_model_row(deform->params.model)->smooths && !deform_is_contact_only(contact);
	const int times = smooths ? deform->params.box_repetitions : 0;
	clear_beyond(deform, window);
	TRY(draw_envelopes(deform, contact, window, regions));
	TRY(lower(deform, contact, window, regions, times > 0));
	for (int i = 1; i <= times; i++)
		TRY(smooth(deform, window, regions, i == times));
	return deform->params.disturbance ? disturb(deform, window, regions) : STATUS_OK;
}

enum status deform_fixed(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			 const struct tile_slot *tiles, size_t count, size_t *drawn)
{
	struct regions regions;
	assert(deform_is_fixed(deform, window, 1));
	TRY(find(deform, window, tiles, count, &regions));
	TRY(run_stages(deform, contact, window, &regions));
	*drawn = regions.count;
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
	struct regions regions = {.slots = {&slot}, .posts = {all}, .places = {{0, 0, 1}}, .count = 1};
	enum status status;
	TRY_OR(done, gpu_texture_create(gpu, GPU_R32I, side, side, 0, &slot.base));
	TRY_OR(done, gpu_texture_create(gpu, GPU_R32I, side, side, 0, &slot.planes[PLANE_OFFSET]));
	TRY_OR(done, gpu_texture_create(gpu, GPU_R8UI, side, side, 0, &slot.planes[PLANE_DISTURBANCE]));
	gpu_texture_clear(slot.base, 0, all, BASE_NODATA);
	gpu_texture_clear(slot.planes[PLANE_OFFSET], 0, all, 0);
	gpu_texture_clear(slot.planes[PLANE_DISTURBANCE], 0, all, 0);
	TRY_OR(done, run_stages(deform, contact, window, &regions));
done:
	gpu_texture_destroy(slot.planes[PLANE_DISTURBANCE]);
	gpu_texture_destroy(slot.planes[PLANE_OFFSET]);
	gpu_texture_destroy(slot.base);
	return status;
}
