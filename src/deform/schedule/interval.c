/*
 * An interval: all active blocks make `iterations` iterations of the sliding rule, as if the whole lattice did.
 *
 * Blocks are computed in an atlas, a layer like a window's. It holds a batch of blocks at a time. Each block lies in a
 * square with a rim around it. Values near the square's border become wrong, and the rim is wide enough to keep them
 * out of the block. Results wait in `results` until all blocks have been gathered. So no block reads another's result.
 */
#include <assert.h>

#include "deform/internal.h"

#define CONTACT_CLOSED 8 /* lib/window.glsl */
#define RESULT_COLUMNS (SIDE / DEFORM_BLOCK)
#define RESULTS (RESULT_COLUMNS * RESULT_COLUMNS) /* blocks a layer */

struct interval {
	const struct deform_block *blocks;
	size_t count;
	const struct deform_rest *objects;
	size_t object_count;
	size_t begun;                  /* number of blocks of which a part was gathered */
	uint32_t side, columns, batch; /* posts along a square; squares in a row; squares in the atlas */
	struct gpu_texture *results[PLANES];
	struct gpu_buffer *flags;      /* one word for each block */
};

/* std140 twin of held.frag's block. */
struct held_params {
	uint32_t zero[4];
	int32_t window[4];
};

int64_t deform_interval_side(const struct deform_params *params)
{
	const struct deform deform = {.params = *params};
	return DEFORM_BLOCK + 2 * deform_slide_rim(&deform);
}

static void drop_results(struct deform *deform)
{
	struct interval *interval = deform->interval;
	for (int plane = 0; plane < PLANES; plane++) {
		gpu_texture_destroy(interval->results[plane]);
		interval->results[plane] = NULL;
	}
	deform->figures.result_layers = 0;
}

/* Returns the planes that sliding changes, a mask of PLANE_BIT. */
static unsigned sliding_planes(const struct deform_params *params)
{
	return deform_planes(params->model, params->disturbance, params->slip_sinkage > 0) & (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DEPOSITED));
}

static enum status need_results(struct deform *deform, size_t blocks)
{
	struct interval *interval = deform->interval;
	uint32_t layers = deform->figures.result_layers;
	while ((size_t)layers * RESULTS < blocks)
		layers = layers != 0 ? 2 * layers : 1;
	if (layers == deform->figures.result_layers)
		return STATUS_OK;
	drop_results(deform);
	enum status status = STATUS_OK;
	for (int plane = 0; plane < PLANES && status == STATUS_OK; plane++)
		if (sliding_planes(&deform->params) & PLANE_BIT(plane))
			status = gpu_texture_create(deform->params.gpu, GPU_R32I, SIDE, SIDE, layers, &interval->results[plane]);
	if (status == STATUS_OK)
		deform->figures.result_layers = layers;
	else
		drop_results(deform);
	return status;
}

enum status deform_interval_create(struct deform *deform)
{
	struct interval *interval = mem_calloc(1, sizeof *interval);
	if (interval == NULL)
		return fail_memory("the awake blocks");
	deform->interval = interval;
	interval->side = (uint32_t)deform_interval_side(&deform->params);
	interval->columns = SIDE / interval->side;
	interval->batch = interval->columns * interval->columns;
	enum status status = gpu_buffer_create(deform->params.gpu, GPU_STORAGE, DEFORM_BLOCKS_MAX * sizeof(uint32_t), NULL,
					       &interval->flags);
	return status == STATUS_OK ? need_results(deform, 1) : status;
}

void deform_interval_plan(const struct deform_params *params, struct plan *plan)
{
	const char *effect = deform_slide_effect(params->model);
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(sliding_planes(params) & PLANE_BIT(plane)))
			continue;
		struct plan_line line = {.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1};
		plan_add(plan, &line, "slid blocks");
		line.unit = PLAN_RESULT_LAYER;
		line.amount = 0;
		line.bytes = (uint64_t)SIDE * SIDE * gpu_format_bytes(GPU_R32I);
		plan_add(plan, &line, "slid blocks");
	}
	deform_plan_buffer(plan, effect, 1, DEFORM_BLOCKS_MAX * sizeof(uint32_t), "blocks' flags");
}

void deform_interval_destroy(struct deform *deform)
{
	struct interval *interval = deform->interval;
	if (interval == NULL)
		return;
	drop_results(deform);
	gpu_buffer_destroy(interval->flags);
	mem_free(interval);
}

static struct deform_contact rest_contact(const struct deform_rest *object)
{
	return (struct deform_contact){.shape = object->shape, .from = object->pose, .to = object->pose};
}

enum status deform_interval_begin(struct deform *deform, const struct deform_rest *objects, size_t object_count,
				  size_t *count)
{
	struct interval *interval = deform->interval;
	*count = 0;
	if (interval == NULL)
		return STATUS_OK;
	interval->begun = 0;
	enum status status = deform_active_visit(deform, &interval->blocks, &interval->count);
	if (status != STATUS_OK || interval->count == 0)
		return status;
	interval->objects = objects;
	interval->object_count = object_count;
	/* Makes all layers that the objects' windows will need. Making them later would lose the gathered blocks. */
	for (size_t i = 0; i < object_count && status == STATUS_OK; i++) {
		const struct deform_contact contact = rest_contact(&objects[i]);
		struct deform_window windows[DEFORM_WINDOWS_MAX];
		size_t needed;
		status = deform_windows(deform, &contact, windows, &needed);
	}
	if (status == STATUS_OK)
		status = need_results(deform, interval->count);
	gpu_buffer_clear(interval->flags, 0, interval->count * sizeof(uint32_t));
	*count = interval->count;
	return status;
}

struct post_rect deform_interval_writes(const struct deform *deform, size_t block)
{
	const struct extent *extent = deform->params.extent;
	const struct deform_block *at = &deform->interval->blocks[block];
	int64_t x = at->x * DEFORM_BLOCK, y = at->y * DEFORM_BLOCK;
	return post_rect_intersect((struct post_rect){x, y, x + DEFORM_BLOCK, y + DEFORM_BLOCK},
				   (struct post_rect){0, 0, extent_posts(extent->width, deform->params.level),
						      extent_posts(extent->height, deform->params.level)});
}

struct post_rect deform_interval_reads(const struct deform *deform, size_t block)
{
	const struct deform_block *at = &deform->interval->blocks[block];
	int64_t rim = deform_slide_rim(deform), x = at->x * DEFORM_BLOCK - rim, y = at->y * DEFORM_BLOCK - rim;
	return (struct post_rect){x, y, x + deform->interval->side, y + deform->interval->side};
}

/* Finds the first post of a block's square in the atlas. */
static void place_of(const struct interval *interval, size_t block, uint32_t *x, uint32_t *y)
{
	uint32_t square = (uint32_t)(block % interval->batch);
	*x = square % interval->columns * interval->side;
	*y = square / interval->columns * interval->side;
}

/* Marks the posts of one block that an object at rest holds. The object's lower envelope over `window` is in layer 0.
 * `shadow`: the posts that the object can be above. Elsewhere the envelope was not drawn. */
static enum status hold(struct deform *deform, const struct deform_rest *object, struct post_rect window,
			struct post_rect shadow, size_t block)
{
	bool loaded = object->loaded_body > 0;
	struct post_rect square = deform_interval_reads(deform, block);
	struct post_rect both = post_rect_intersect(post_rect_intersect(window, shadow), square);
	uint32_t x, y;
	if (post_rect_empty(both))
		return STATUS_OK;
	struct deform_request request;
	deform_programs_held(loaded, &request);
	enum status status = deform_program(deform, &request, &deform->held[loaded]);
	if (status != STATUS_OK)
		return status;
	place_of(deform->interval, block, &x, &y);
	int64_t zero = object->pose.z - (int64_t)deform->params.reference * (1 << OFFSET_BITS);
	const struct held_params params = {
		.zero = {(uint32_t)zero, (uint32_t)((uint64_t)zero >> 32), 0, deform->layers},
		.window = {(int32_t)(window.x0 - square.x0 + x), (int32_t)(window.y0 - square.y0 + y),
			   (int32_t)object->loaded_body - 1},
	};
	deform->figures.held++;
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_HOLD,
		.program = deform->held[loaded],
		.target = deform->scratch[deform->layers].to[TO_HELD],
		.viewport = {(uint32_t)(both.x0 - square.x0) + x, (uint32_t)(both.y0 - square.y0) + y,
			     (uint32_t)(both.x1 - both.x0), (uint32_t)(both.y1 - both.y0)},
		.images = {deform->rest, deform->bases, deform->planes_of[1][PLANE_OFFSET]},
		.storage = {deform->standing},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

static bool overlaps(const struct deform *deform, struct post_rect window, size_t first, size_t last)
{
	for (size_t block = first; block <= last; block++)
		if (!post_rect_empty(post_rect_intersect(window, deform_interval_reads(deform, block))))
			return true;
	return false;
}

/* Marks the posts of blocks first .. last that an object rests on as held, as at the end of a contact. */
static enum status hold_all(struct deform *deform, const struct deform_rest *object, size_t first, size_t last)
{
	const struct deform_contact contact = rest_contact(object);
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	enum status status = deform_windows(deform, &contact, windows, &count);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		if (!overlaps(deform, windows[i].read, first, last))
			continue;
		status = deform_envelope(deform, &contact, &windows[i], 0);
		deform->figures.resting += object->shape->kind != DEFORM_MESH;
		for (size_t block = first; block <= last && status == STATUS_OK; block++)
			status = hold(deform, object, windows[i].read, deform_shadow(deform, &contact), block);
	}
	return status;
}

/* Marks the posts of neighbouring blocks that are not visited, so that they exchange no soil with this one. An earlier drive may
 * have left them steep. Then one post of a pair would change and the other would not. */
static void close_sides(struct deform *deform, size_t block)
{
	const struct deform_block *own = &deform->interval->blocks[block];
	const uint32_t rim = (uint32_t)deform_slide_rim(deform);
	const uint32_t from[3] = {0, rim, rim + DEFORM_BLOCK}, length[3] = {rim, DEFORM_BLOCK, rim};
	uint32_t x, y;
	place_of(deform->interval, block, &x, &y);
	for (int k = 0; k < 9; k++) {
		int i = k % 3, j = k / 3;
		if (k == 4 || deform_active_is_visited(deform, (struct deform_block){own->x + i - 1, own->y + j - 1}))
			continue;
		const struct gpu_rect side = {x + from[i], y + from[j], length[i], length[j]};
		gpu_texture_clear(deform->contacts, deform->layers, side, CONTACT_CLOSED);
	}
}

/* Computes the blocks in the atlas: it is full, or `last` is the last block. Copies them into `results`. */
static enum status compute(struct deform *deform, size_t first, size_t last)
{
	struct interval *interval = deform->interval;
	const struct gpu_rect atlas = {0, 0, SIDE, SIDE};
	uint32_t rim = (uint32_t)deform_slide_rim(deform);
	enum status status = STATUS_OK;
	gpu_texture_clear(deform->contacts, deform->layers, atlas, 0);
	for (size_t i = 0; i < interval->object_count && status == STATUS_OK; i++)
		status = hold_all(deform, &interval->objects[i], first, last);
	for (size_t block = first; block <= last; block++)
		close_sides(deform, block);
	const struct slide_place place = {
		.layer = deform->layers,
		.all = atlas,
		.written = atlas,
		.blocks = (uint32_t)(last - first + 1),
		.side = interval->side,
		.columns = interval->columns,
		.first = (uint32_t)first,
		.flags = {.words = interval->flags},
	};
	if (status == STATUS_OK)
		status = deform_slide_run(deform, &place);
	deform->figures.atlases++;
	for (size_t block = first; block <= last && status == STATUS_OK; block++)
		for (int plane = 0; plane < PLANES; plane++) {
			uint32_t x, y, to = (uint32_t)(block % RESULTS);
			place_of(interval, block, &x, &y);
			if (interval->results[plane] != NULL)
				gpu_texture_copy(deform->planes_of[1][plane], deform->layers, x + rim, y + rim,
						 interval->results[plane], (uint32_t)(block / RESULTS),
						 (struct gpu_rect){to % RESULT_COLUMNS * DEFORM_BLOCK,
								   to / RESULT_COLUMNS * DEFORM_BLOCK, DEFORM_BLOCK, DEFORM_BLOCK});
		}
	return status == STATUS_OK ? gpu_check(deform->params.gpu, "sliding") : status;
}

void deform_interval_gather_part(struct deform *deform, size_t block, const struct deform_tile *tiles, size_t count)
{
	struct interval *interval = deform->interval;
	const struct post_rect reads = deform_interval_reads(deform, block);
	unsigned planes = sliding_planes(&deform->params);
	uint32_t x, y;
	assert(block < interval->count);
	place_of(interval, block, &x, &y);
	if (interval->begun == block + 1)
		deform_gather_more(deform, reads, deform->layers, x, y, true, planes, tiles, count);
	else
		deform_gather(deform, reads, deform->layers, x, y, true, planes, tiles, count);
	interval->begun = block + 1;
}

enum status deform_interval_gather(struct deform *deform, size_t block, const struct deform_tile *tiles, size_t count)
{
	const struct interval *interval = deform->interval;
	deform_interval_gather_part(deform, block, tiles, count);
	if (block % interval->batch != interval->batch - 1 && block != interval->count - 1)
		return STATUS_OK;
	return compute(deform, block - block % interval->batch, block);
}

enum status deform_interval_warm(struct deform *deform, const struct deform_shape *shape, uint32_t loaded_body)
{
	static const struct deform_block beyond = {-4, -4};
	struct interval *interval = deform->interval;
	const struct deform_rest object = {.shape = shape, .loaded_body = loaded_body};
	interval->blocks = &beyond;
	interval->count = 1;
	interval->begun = 0;
	interval->object_count = 0;
	enum status status = deform_interval_gather(deform, 0, NULL, 0);
	if (status == STATUS_OK)
		status = hold(deform, &object, deform_interval_reads(deform, 0), deform_interval_reads(deform, 0), 0);
	interval->count = 0;
	return status;
}

enum status deform_interval_scatter(struct deform *deform, size_t block, const struct deform_tile *tiles, size_t count)
{
	const struct interval *interval = deform->interval;
	uint32_t at = (uint32_t)(block % RESULTS);
	struct scatter_from from = {
		.layer = (uint32_t)(block / RESULTS),
		.x = at % RESULT_COLUMNS * DEFORM_BLOCK,
		.y = at / RESULT_COLUMNS * DEFORM_BLOCK,
	};
	for (int plane = 0; plane < PLANES; plane++)
		from.planes[plane] = interval->results[plane];
	return deform_scatter_from(deform, deform_interval_writes(deform, block), &from, tiles, count);
}

enum status deform_interval_end(struct deform *deform)
{
	return deform_active_visited(deform, deform->interval->flags);
}
