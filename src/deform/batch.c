/*
 * Batches: small contacts whose windows share no post, computed together. Their windows lie beside each other in layer 0, and each pass
 * draws all of them. So the cost of a pass is paid once for a batch, not once for a body. A pass reads only posts of the same window, and
 * all numbers are whole. So a window's posts have the same bits as if it were computed alone.
 *
 * Passes read the ground from the tiles, and write it to them: a window is drawn in parts, one for each tile (batch_parts.c). They are:
 * the ground is copied into the layer; contacts, over it, where the objects are; smoothing; and the last pass, which writes the tiles. What
 * lies beyond the reach of an object is not computed.
 *
 * A batch: begun -> windows are added -> computed -> begun again.
 *
 * Invariant: windows lie in rows, from the south-west corner, and do not overlap.
 */
#include <assert.h>
#include <string.h>

#include "deform/batch.h"

#define SIDE_MOST (4 * SIDE) /* of the layer, posts. It grows when a batch is full */

enum status deform_batch_create(struct deform *deform)
{
	TRY(mem_zeroed(&deform->batch, 1, sizeof *deform->batch, "a batch of windows"));
	return gpu_list_create(deform->params.gpu, sizeof deform->batch->records, &deform->batch->list);
}

void deform_batch_destroy(struct deform *deform)
{
	if (deform->batch == NULL)
		return;
	gpu_list_destroy(deform->batch->list);
	mem_free(deform->batch);
}

void deform_batch_plan(const struct deform_params *params, struct plan *plan)
{
	deform_plan_buffer(plan, deform_displace_effect(params->model), 1, gpu_list_bytes(sizeof ((struct batch *)NULL)->records), DEFORM_BATCH_BUFFER);
}

static bool is_batched(const struct deform_params *params, const struct soil_shape *shape)
{
	return params->batches && deform_model_row(params->model)->batch != NULL && shape->kind != SOIL_MESH && shape->grousers == 0;
}

/* A model that smooths has fewer passes for a contact without motion, which comes once for each body. */
bool deform_batches(const struct deform_params *params, const struct deform_planned *object)
{
	return is_batched(params, object->shape) && (object->moves || !deform_model_row(params->model)->smooths);
}

bool deform_is_batched(const struct deform *deform, const struct deform_contact *contact, const struct deform_window *windows, size_t count)
{
	return count == 1 && windows[0].parts == 0 && is_batched(&deform->params, contact->shape) &&
	       !(deform_model_row(deform->params.model)->smooths && deform_is_contact_only(contact));
}

void deform_batch_begin(struct deform *deform)
{
	struct batch *batch = deform->batch;
	batch->count = batch->part_count = 0;
	batch->x = batch->y = batch->height = 0;
}

/* Windows begin at multiples of four posts. A software rasteriser computes squares of four by four. */
static uint32_t aligned(int64_t posts)
{
	return (uint32_t)(posts + 3) / 4 * 4;
}

static bool shares(const struct deform *deform, const struct tile_slot *tile, struct post_rect rect)
{
	return !post_rect_empty(post_rect_intersect(tile_post_rect(deform->params.extent, tile->tile), rect));
}

/* Returns true if some posts may lie on no tile, which makes one more part. */
static bool is_beyond(const struct deform *deform, struct post_rect rect)
{
	const struct extent *extent = deform->params.extent;
	const int level = deform->params.level;
	return rect.x0 < 0 || rect.y0 < 0 || rect.x1 > extent_tiles_x(extent, level) * (int64_t)extent->cells + 1 ||
	       rect.y1 > extent_tiles_y(extent, level) * (int64_t)extent->cells + 1;
}

/* Finds room for a window in the layer. A full layer grows, if it may. */
static enum status place(struct deform *deform, uint32_t width, uint32_t height, bool *found)
{
	struct batch *batch = deform->batch;
	if (batch->x + aligned(width) > deform->side) {
		batch->y += batch->height;
		batch->x = batch->height = 0;
	}
	*found = batch->y + aligned(height) <= deform->side;
	if (*found || deform->side >= SIDE_MOST)
		return STATUS_OK;
	TRY(deform_need_layers(deform, 1, 2 * deform->side));
	*found = true;
	return STATUS_OK;
}

enum status deform_batch_add(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			     const struct tile_slot *tiles, size_t count, bool *added)
{
	struct batch *batch = deform->batch;
	const struct post_rect read = window->read;
	const uint32_t width = (uint32_t)(read.x1 - read.x0), height = (uint32_t)(read.y1 - read.y0);
	*added = false;
	assert(width <= SIDE && height <= SIDE);
	if (batch->count == DEFORM_BATCH_MOST || batch->part_count + DEFORM_BATCH_TILES + 1 > PARTS_MOST)
		return STATUS_OK;
	TRY(place(deform, width, height, added));
	if (!*added)
		return STATUS_OK;
	struct batched *batched = &batch->windows[batch->count++];
	*batched = (struct batched){.contact = *contact, .window = *window, .posts = {batch->x, batch->y, width, height}};
	for (size_t i = 0; i < count; i++)
		if (shares(deform, &tiles[i], read)) {
			assert(batched->tile_count < DEFORM_BATCH_TILES);
			batched->tiles[batched->tile_count++] = tiles[i];
		}
	batch->part_count += batched->tile_count + is_beyond(deform, read);
	batch->x += aligned(width);
	batch->height = aligned(height) > batch->height ? aligned(height) : batch->height;
	return STATUS_OK;
}

/* Returns the group of a lower envelope. */
static enum group group_of(const struct under_params *under)
{
	if (under->kind == SOIL_WHEEL)
		return under->sideways ? SIDEWAYS_WHEELS : WHEELS;
	return under->kind == SOIL_SPHERE ? SPHERES : OTHERS;
}

static void *put(void *to, const void *numbers, size_t bytes)
{
	memcpy(to, numbers, bytes);
	return (char *)to + bytes;
}

static void *put_body(void *to, const struct body *body, size_t functionals)
{
	to = put(to, body->f, functionals * sizeof *body->f);
	to = put(to, body->a, sizeof body->a);
	to = put(to, body->b, sizeof body->b);
	return put(to, body->c, sizeof body->c);
}

/* Copies the numbers of a lower envelope as lib/envelope.glsl takes them from the vertex shader. */
static void put_bodies(const struct under_params *under, int32_t bodies[18][4])
{
	put_body(put_body(bodies, &under->motion, under->sideways ? 4 : 2), &under->end, 2);
}

static void fill_numbers(const struct deform *deform, const struct under_params *under, struct batched *batched)
{
	const struct contact_params contact = deform_contact_params(deform, &batched->contact, &batched->window, 0);
	const int32_t at[2] = {(int32_t)batched->posts.x, (int32_t)batched->posts.y};
	struct record *record = &batched->numbers;
	deform_posts_of(batched->posts, record->window);
	memcpy(record->zero, contact.zero, sizeof record->zero);
	for (int k = 0; k < 4; k++)
		record->written[k] = contact.written[k] + at[k % 2];
	if (batched->group != OTHERS)
		put_bodies(under, record->bodies);
}

/* Fills the records, and draws the lower envelopes that the contact pass does not compute. */
static enum status prepare(struct deform *deform)
{
	struct batch *batch = deform->batch;
	for (size_t i = 0; i < batch->count; i++) {
		struct batched *batched = &batch->windows[i];
		const struct post_rect read = batched->window.read;
		struct under_params under;
		deform_under_of(deform, &batched->contact, read.x0 - batched->posts.x, read.y0 - batched->posts.y, &under);
		batched->group = group_of(&under);
		fill_numbers(deform, &under, batched);
		if (batched->group == OTHERS) {
			deform->figures.batch_envelopes++;
			TRY(deform_under_run(deform, &under, batched->posts, 0));
		}
	}
	TRY(deform_batch_cut(deform));
	deform_batch_record(deform);
	gpu_list_write(batch->list, (batch->gather_count + batch->store_count) * sizeof *batch->records, batch->records);
	return STATUS_OK;
}

/* Runs a pass over `count` records from `first` on. Fills the pass's program, geometry and parameters. */
static enum status run(struct deform *deform, enum deform_batch_pass which, struct gpu_program **program, size_t first, size_t count,
		       struct gpu_pass *pass)
{
	const int32_t params[4] = {(int32_t)first, (int32_t)deform->side};
	struct deform_request request;
	deform_programs_batch(&deform->params, which, &request);
	TRY(deform_program(deform, &request, program));
	pass->program = *program;
	pass->viewport = (struct gpu_rect){0, 0, deform->side, deform->side};
	pass->lists[4] = deform->batch->list;
	pass->params = params;
	pass->params_bytes = sizeof params;
	pass->instances = (uint32_t)count;
	gpu_pass_run(deform->params.gpu, pass);
	return STATUS_OK;
}

static struct gpu_texture *either(struct gpu_texture *array, struct gpu_texture *none)
{
	return array != NULL ? array : none;
}

/* Copies the ground of tiles into the layer; or computes contacts, over it. A draw does not read what the others write. */
static enum status draw_contacts(struct deform *deform, bool gathers)
{
	static const enum deform_batch_pass passes[GROUPS] = {
		[WHEELS] = BATCH_WHEELS, [SIDEWAYS_WHEELS] = BATCH_SIDEWAYS_WHEELS, [SPHERES] = BATCH_SPHERES, [OTHERS] = BATCH_OTHERS,
	};
	struct batch *batch = deform->batch;
	size_t count;
	for (size_t first = 0; first < batch->gather_count; first += count) {
		const struct part *part = &batch->gathers[first];
		const enum group group = part->of->group;
		const bool drawn = group == OTHERS && !gathers;
		count = deform_batch_run(batch->gathers, first, batch->gather_count, gathers ? PARTS_GATHER : PARTS_CONTACT);
		struct gpu_program **program = gathers ? &batch->gather : &batch->contact[group];
		deform->figures.batch_draws++;
		TRY(run(deform, gathers ? BATCH_GATHER : passes[group], program, first, count, &(struct gpu_pass){
			.stage = GPU_CONTACT,
			.target = deform->scratch[0].to[TO_CONTACT],
			.images = {either(part->base, deform->bases), either(part->offset, deform->planes_of[0][PLANE_OFFSET]),
				   drawn ? deform->under : NULL, drawn ? deform->rest : NULL},
			.storage = {gathers ? NULL : deform->tally},
			.beside = first > 0 || !gathers,
		}));
	}
	return STATUS_OK;
}

enum status deform_batch_contact(struct deform *deform)
{
	TRY(draw_contacts(deform, true));
	TRY(draw_contacts(deform, false));
	deform->scratch[0].now[PLANE_OFFSET] = 1;
	return STATUS_OK;
}

/* Runs the last pass, which writes the tiles. */
static enum status store(struct deform *deform, enum deform_batch_pass which, enum gpu_stage stage, struct gpu_program **program)
{
	struct batch *batch = deform->batch;
	struct layer *scratch = &deform->scratch[0];
	const int now = scratch->now[PLANE_OFFSET];
	size_t count;
	for (size_t first = 0; first < batch->store_count; first += count) {
		count = deform_batch_run(batch->stores, first, batch->store_count, PARTS_STORE);
		deform->figures.batch_stores++;
		TRY(run(deform, which, program, batch->gather_count + first, count, &(struct gpu_pass){
			.stage = stage,
			.target = scratch->to[TO_BARE],
			.images = {deform->planes_of[now][PLANE_OFFSET], deform->contacts,
				   either(batch->stores[first].offset, deform->planes_of[1 - now][PLANE_OFFSET])},
			.beside = first > 0,
		}));
	}
	return STATUS_OK;
}

enum status deform_batch_store(struct deform *deform)
{
	return store(deform, BATCH_STORE, GPU_CONTACT, &deform->batch->store);
}

enum status deform_batch_smooth(struct deform *deform)
{
	struct layer *scratch = &deform->scratch[0];
	for (int i = 1; i < deform->params.box_repetitions; i++) {
		int now = scratch->now[PLANE_OFFSET];
		TRY(run(deform, BATCH_BOX, &deform->batch->smooth, 0, deform->batch->gather_count, &(struct gpu_pass){
			.stage = GPU_SMOOTH,
			.target = scratch->to[now == 0 ? TO_SECOND : TO_FIRST],
			.images = {deform->planes_of[now][PLANE_OFFSET], deform->contacts},
		}));
		scratch->now[PLANE_OFFSET] = 1 - now;
	}
	return store(deform, BATCH_BOX_STORE, GPU_SMOOTH, &deform->batch->store);
}

static enum status disturb(struct deform *deform)
{
	struct batch *batch = deform->batch;
	size_t count;
	for (size_t first = 0; first < batch->store_count; first += count) {
		const struct part *part = &batch->stores[first];
		count = deform_batch_run(batch->stores, first, batch->store_count, PARTS_STORE);
		TRY(run(deform, BATCH_DISTURBANCE, &batch->disturb, batch->gather_count + first, count, &(struct gpu_pass){
			.stage = GPU_DISTURBANCE,
			.target = deform->scratch[0].to[TO_BARE],
			.images = {either(part->offset, deform->planes_of[0][PLANE_OFFSET]), deform->contacts,
				   either(part->disturbance, deform->planes_of[1][PLANE_DISTURBANCE])},
			.beside = first > 0,
		}));
	}
	return STATUS_OK;
}

/* A window without others is gathered, computed and scattered as a window that is alone. One beyond the world wakes nothing: warm.c. */
static enum status compute_one(struct deform *deform)
{
	const struct batched *batched = &deform->batch->windows[0];
	const struct deform_window *window = &batched->window;
	deform_gather(deform, window->read, 0, 0, 0, false, deform->planes, batched->tiles, batched->tile_count);
	TRY(deform_run_stages(deform, &batched->contact, window, 0));
	TRY(deform_scatter(deform, window, 0, batched->tiles, batched->tile_count));
	return batched->tile_count > 0 ? deform_wake_swept(deform, window, 0) : STATUS_OK;
}

static enum status run_passes(struct deform *deform)
{
	memset(deform->scratch[0].now, 0, sizeof deform->scratch[0].now);
	deform->figures.batches++;
	TRY(prepare(deform));
	TRY(deform_model_row(deform->params.model)->batch(deform));
	return deform->params.disturbance ? disturb(deform) : STATUS_OK;
}

/* Computes the windows together. The GPU starts on them even if a pass failed. */
static enum status compute_all(struct deform *deform)
{
	enum status status = run_passes(deform);
	gpu_start(deform->params.gpu);
	return status;
}

enum status deform_batch_compute(struct deform *deform)
{
	if (deform->batch->count == 0)
		return STATUS_OK;
	TRY(deform->batch->count == 1 ? compute_one(deform) : compute_all(deform));
	return gpu_check(deform->params.gpu, "deformation");
}
