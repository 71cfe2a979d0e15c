/*
 * Batches of a model that conserves soil. The windows of a batch (batch.c) lie beside each other in layer 0. Each pass is one
 * draw over all of them. So its cost is paid once for a batch, not once for a body. Windows share no post, and each pass reads only posts of
 * the same window. So a window's posts have the same bits as if it were computed alone.
 *
 * Each window has a record: the numbers that a window's passes get as parameters, with posts counted from the first of the layer. The
 * contact alone counts posts from the first of its own window, since floating point rounds by how far a post is from there. A vertex shader
 * (windows.vert) finds the record of a window, and passes numbers on to the fragments. What the contacts hand on to the passes
 * that lay soil is kept apart for each window, too (`layings`).
 *
 * Records are sorted by the program of their contacts, so a draw computes all contacts of one variant. Flags and forces keep the order in
 * which contacts were added.
 */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "deform/batch.h"

#define ROWS_MOST (SIDE / DEFORM_ROWS_ABREAST) /* rows of the viewport that a window's rows of posts need, at most */

/* Numbers of 16 bytes. `at`: where a draw draws: posts, first and one behind the last; or such a rectangle of the viewport. `window`: the last
 * that a pass with rows gets: lib/rows.glsl. */
struct record_lines {
	int32_t at[2][4]; /* index: 1 along diagonal lines; empty: this window does not take part */
	int32_t place[4], written[4], window[4]; /* window[3]: `around` of lib/reached.glsl */
};
struct together_record {
	int32_t under_at[4], bodies[18][4];
	int32_t contact_at[4], contact[TOGETHER_CONTACT_NUMBERS][4], contact_window[4]; /* [3]: x, y << 16 of the window in the layer */
	int32_t spread_at[4], spread[6][4], spread_window[4];
	int32_t begin[5][4], excess[6][4];
	struct record_lines lines[DEFORM_LINES_MOST];
};
#define NUMBER(member) ((int32_t)(offsetof(struct together_record, member) / 16))
_Static_assert(sizeof(struct together_record) == 81 * 16, "windows.vert");

/* What decides which draws a window is in. */
struct key {
	unsigned variant;
	enum group group;
	uint32_t number; /* of the window */
};

struct together {
	struct gpu_list *list;
	struct gpu_buffer *layings;
	struct gpu_buffer *found; /* what a search before the contacts finds: lib/found.glsl */
	struct gpu_program *under[GROUPS];
	struct key keys[DEFORM_BATCH_MOST];
	struct together_record records[DEFORM_BATCH_MOST], sorted[DEFORM_BATCH_MOST];
};

enum status deform_together_create(struct deform *deform)
{
	deform->together = mem_calloc(1, sizeof *deform->together);
	if (deform->together == NULL)
		return fail_memory("a batch of windows");
	enum status status = gpu_list_create(deform->params.gpu, sizeof deform->together->sorted, &deform->together->list);
	if (status == STATUS_OK)
		status = gpu_buffer_create(deform->params.gpu, GPU_STORAGE, DEFORM_BATCH_MOST * DEFORM_LAYING_BYTES, NULL, &deform->together->layings);
	if (status == STATUS_OK && deform_tells_forces(deform->params.model))
		status = gpu_buffer_create(deform->params.gpu, GPU_STORAGE, DEFORM_BATCH_MOST * DEFORM_FOUND_BYTES, NULL, &deform->together->found);
	return status;
}

void deform_together_destroy(struct deform *deform)
{
	if (deform->together == NULL)
		return;
	gpu_list_destroy(deform->together->list);
	gpu_buffer_destroy(deform->together->layings);
	gpu_buffer_destroy(deform->together->found);
	mem_free(deform->together);
}

uint64_t deform_together_bytes(const struct deform_params *params)
{
	const uint64_t found = deform_tells_forces(params->model) ? DEFORM_BATCH_MOST * DEFORM_FOUND_BYTES : 0;
	return gpu_list_bytes(sizeof ((struct together *)NULL)->sorted) + DEFORM_BATCH_MOST * DEFORM_LAYING_BYTES + found;
}

/* The rows of all windows lie beside each other in the viewport. */
size_t deform_together_room(uint32_t side)
{
	return (size_t)(side / DEFORM_ROWS_ABREAST) * (side / ROWS_MOST);
}

/* --- draws --- */

void deform_together_draw(const struct deform *deform, int what, int32_t draw[4])
{
	static const int32_t passed[] = {
		[TOGETHER_UNDER] = NUMBER(bodies), [TOGETHER_CONTACT] = NUMBER(contact), [TOGETHER_SPREAD] = NUMBER(spread),
		[TOGETHER_BEGIN] = NUMBER(begin), [TOGETHER_EXCESS] = NUMBER(excess),
	};
	static const int32_t at[] = {
		[TOGETHER_UNDER] = NUMBER(under_at), [TOGETHER_CONTACT] = NUMBER(contact_at), [TOGETHER_SPREAD] = NUMBER(spread_at),
		[TOGETHER_BEGIN] = 0, [TOGETHER_EXCESS] = 0, /* follow from what was reached */
	};
	draw[0] = 0;
	draw[3] = (int32_t)deform->side;
	if (what >= TOGETHER_LINES) {
		const int pass = (what - TOGETHER_LINES) / 2, diagonal = (what - TOGETHER_LINES) % 2;
		const int32_t first = NUMBER(lines) + pass * (int32_t)(sizeof(struct record_lines) / 16);
		draw[1] = first + (int32_t)(offsetof(struct record_lines, place) / 16);
		draw[2] = first + diagonal;
	} else {
		draw[1] = passed[what];
		draw[2] = at[what];
	}
}

void deform_together_run(struct deform *deform, uint32_t count, struct gpu_pass *pass)
{
	pass->viewport = (struct gpu_rect){0, 0, deform->side, deform->side};
	pass->instances = count != TOGETHER_ALL ? count : (uint32_t)deform->batch->count;
	pass->lists[5] = deform->together->list;
	pass->storage[4] = deform->together->layings;
	gpu_pass_run(deform->params.gpu, pass);
}

void deform_together_compute(struct deform *deform, uint32_t count, struct gpu_pass *pass)
{
	pass->groups = count;
	pass->lists[5] = deform->together->list;
	gpu_pass_run(deform->params.gpu, pass);
}

struct gpu_buffer *deform_together_found(const struct deform *deform)
{
	return deform->together->found;
}

/* --- records --- */

/* Returns where the rows of a record lie in the viewport: `rows` of them. */
static void put_rows(const struct deform *deform, uint32_t place, int32_t rows, int32_t at[4])
{
	const uint32_t across = deform->side / DEFORM_ROWS_ABREAST;
	const struct gpu_rect rect = {place % across * DEFORM_ROWS_ABREAST, place / across * ROWS_MOST, DEFORM_ROWS_ABREAST,
				      (uint32_t)(rows + DEFORM_ROWS_ABREAST - 1) / DEFORM_ROWS_ABREAST};
	deform_posts_of(rect, at);
}

static int32_t rows_of(const int32_t posts[4])
{
	return posts[3] > posts[1] ? posts[3] - posts[1] : 0;
}

/* Fills the numbers of the lower envelope. One that has too many is drawn alone. */
static enum status fill_under(struct deform *deform, const struct batched *batched, struct key *key, struct together_record *record)
{
	const struct post_rect read = batched->window.read;
	struct gpu_rect posts = deform_under_posts(deform, &batched->contact, read);
	struct under_params under;
	posts.x += batched->posts.x;
	posts.y += batched->posts.y;
	deform_under_of(deform, &batched->contact, read.x0 - batched->posts.x, read.y0 - batched->posts.y, &under);
	key->group = deform_group_of(&under);
	deform_posts_of(posts, record->under_at);
	if (key->group != OTHERS) {
		deform_put_bodies(&under, record->bodies);
		return STATUS_OK;
	}
	deform->figures.batch_envelopes++;
	return deform_under_run(deform, &under, posts, 0);
}

/* Fills the numbers of sliding. Asks for flags, which nobody needs of a window beyond the world (warm.c). */
static enum status fill_slide(struct deform *deform, const struct batched *batched, struct together_record *record)
{
	const struct deform_window *window = &batched->window;
	struct deform_window shifted = *window;
	deform_begin_layer(deform, &batched->contact, window, 0);
	shifted.read.x0 -= batched->posts.x;
	shifted.read.y0 -= batched->posts.y;
	const struct slide_place place = deform_slide_place(deform, &shifted, 0);
	deform_slide_numbers(deform, &place, record->begin, record->excess);
	for (int i = 0; i < deform_line_passes(&deform->params); i++) {
		struct record_lines *lines = &record->lines[i];
		const bool diagonal = deform_lines_numbers(deform, &place, i, lines->place);
		deform_posts_of(place.written, lines->written);
		/* Filled as a rectangle of the viewport when the place of the record is known. */
		lines->at[diagonal][3] = (int32_t)(lines->place[1] == 1 ? place.written.width : place.written.height);
		lines->window[3] = place.around;
	}
	return batched->tile_count > 0 ? deform_wake_swept(deform, window, 0) : STATUS_OK;
}

static enum status fill(struct deform *deform, const struct together_model *model, const struct batched *batched, struct key *key,
			struct together_record *record)
{
	const struct spread_params spread = deform_spread_params(deform, &batched->contact, &batched->window, 0);
	memset(record, 0, sizeof *record);
	key->variant = model->variant(deform, &batched->contact);
	enum status status = fill_under(deform, batched, key, record);
	if (status == STATUS_OK)
		status = model->fill(deform, &batched->contact, &spread, &batched->window, record->contact);
	if (status != STATUS_OK)
		return status;
	record->contact_window[3] = (int32_t)(batched->posts.x | batched->posts.y << 16);
	record->contact_at[3] = rows_of(spread.shadow);
	deform_spread_numbers(&spread, &batched->posts, record->spread);
	record->spread_at[3] = rows_of(spread.written);
	return fill_slide(deform, batched, record);
}

/* Fills what follows from the place of a record among all. */
static void put_place(const struct deform *deform, uint32_t place, struct together_record *record)
{
	int32_t *const at[] = {record->contact_at, record->spread_at}, *const windows[] = {record->contact_window, record->spread_window};
	for (int i = 0; i < 2; i++) {
		put_rows(deform, place, at[i][3], at[i]);
		windows[i][0] = (int32_t)place;
		windows[i][1] = at[i][0];
		windows[i][2] = at[i][1];
	}
	for (int i = 0; i < deform_line_passes(&deform->params); i++) {
		struct record_lines *lines = &record->lines[i];
		for (int diagonal = 0; diagonal < 2; diagonal++)
			if (lines->at[diagonal][3] > 0) {
				put_rows(deform, place, lines->at[diagonal][3], lines->at[diagonal]);
				lines->window[1] = lines->at[diagonal][0];
				lines->window[2] = lines->at[diagonal][1];
			}
		lines->window[0] = (int32_t)place;
	}
}

static int compare(const void *a, const void *b)
{
	const struct key *first = a, *second = b;
	if (first->variant != second->variant)
		return first->variant < second->variant ? -1 : 1;
	if (first->group != second->group)
		return first->group < second->group ? -1 : 1;
	return first->number < second->number ? -1 : first->number > second->number;
}

static enum status prepare(struct deform *deform, const struct together_model *model)
{
	struct together *together = deform->together;
	const struct batch *batch = deform->batch;
	enum status status = deform_forces_reserve(deform, batch->tagged);
	for (size_t i = 0; i < batch->count && status == STATUS_OK; i++) {
		together->keys[i].number = (uint32_t)i;
		status = fill(deform, model, &batch->windows[i], &together->keys[i], &together->records[i]);
	}
	if (status != STATUS_OK)
		return status;
	qsort(together->keys, batch->count, sizeof *together->keys, compare);
	for (uint32_t place = 0; place < batch->count; place++) {
		together->sorted[place] = together->records[together->keys[place].number];
		put_place(deform, place, &together->sorted[place]);
	}
	gpu_list_write(together->list, batch->count * sizeof *together->sorted, together->sorted);
	return STATUS_OK;
}

/* --- passes --- */

/* Draws the lower envelopes of windows of one group. */
static enum status draw_under(struct deform *deform, enum group group, uint32_t first, uint32_t count)
{
	const enum soil_shape_kind kind = group == SPHERES ? SOIL_SPHERE : SOIL_WHEEL;
	struct gpu_program **program = &deform->together->under[group];
	int32_t draw[4];
	struct deform_request request;
	deform_programs_envelope(&deform->params, kind, group == SIDEWAYS_WHEELS, true, &request);
	enum status status = deform_program(deform, &request, program);
	if (status != STATUS_OK)
		return status;
	deform_together_draw(deform, TOGETHER_UNDER, draw);
	draw[0] = (int32_t)first;
	deform_together_run(deform, count, &(struct gpu_pass){
		.stage = GPU_ENVELOPE,
		.program = *program,
		.target = deform->scratch[0].to[TO_UNDER],
		.params = draw,
		.params_bytes = sizeof draw,
		.beside = true,
	});
	deform->figures.batch_envelopes++;
	return STATUS_OK;
}

static enum status draw_contacts(struct deform *deform, const struct together_model *model)
{
	const struct key *keys = deform->together->keys;
	const uint32_t all = (uint32_t)deform->batch->count;
	enum status status = STATUS_OK;
	for (uint32_t first = 0, end; first < all && status == STATUS_OK; first = end) {
		for (end = first + 1; end < all && keys[end].group == keys[first].group; end++)
			;
		if (keys[first].group != OTHERS)
			status = draw_under(deform, keys[first].group, first, end - first);
	}
	for (uint32_t first = 0, end; first < all && status == STATUS_OK; first = end) {
		for (end = first + 1; end < all && keys[end].variant == keys[first].variant; end++)
			;
		status = model->contact(deform, keys[first].variant, first, end - first);
		deform->figures.batch_draws++;
	}
	return status;
}

/* Copies the ground below all windows into the layer. */
static void gather(struct deform *deform)
{
	const struct batch *batch = deform->batch;
	const struct gpu_rect used = {0, 0, deform->side, batch->y + batch->height};
	for (size_t i = 0; i < batch->count; i++) {
		const struct batched *batched = &batch->windows[i];
		deform_gather(deform, batched->window.read, 0, batched->posts.x, batched->posts.y, false, deform->planes, batched->tiles,
			      batched->tile_count);
	}
	gpu_texture_clear(deform->contacts, 0, used, 0);
	gpu_texture_clear(deform->deposits, 0, used, 0);
	gpu_buffer_clear(deform->together->layings, 0, batch->count * DEFORM_LAYING_BYTES);
}

static enum status scatter(struct deform *deform)
{
	const struct batch *batch = deform->batch;
	struct scatter_from from = {.layer = 0};
	enum status status = STATUS_OK;
	for (int plane = 0; plane < PLANES; plane++)
		from.planes[plane] = deform->planes_of[deform->scratch[0].now[plane]][plane];
	for (size_t i = 0; i < batch->count && status == STATUS_OK; i++) {
		const struct batched *batched = &batch->windows[i];
		const struct deform_window *window = &batched->window;
		from.x = batched->posts.x + (uint32_t)(window->write.x0 - window->read.x0);
		from.y = batched->posts.y + (uint32_t)(window->write.y0 - window->read.y0);
		status = deform_scatter_from(deform, window->write, &from, batched->tiles, batched->tile_count);
	}
	return status;
}

enum status deform_together(struct deform *deform, const struct together_model *model)
{
	const struct batch *batch = deform->batch;
	const struct slide_place all = {.layer = 0, .batch = true, .flags = {.words = deform_active_words(deform)}};
	gather(deform);
	enum status status = prepare(deform, model);
	if (status == STATUS_OK)
		status = draw_contacts(deform, model);
	memset(deform->scratch[0].now, 0, sizeof deform->scratch[0].now);
	deform->scratch[0].now[PLANE_OFFSET] = deform->scratch[0].now[PLANE_DEPOSITED] = 1;
	if (status == STATUS_OK)
		status = deform_spread_together(deform);
	if (status == STATUS_OK)
		status = deform_slide_run(deform, &all);
	if (status == STATUS_OK && deform->params.disturbance)
		status = deform_disturb(deform, (struct post_rect){0, 0, deform->side, batch->y + batch->height}, 0);
	return status == STATUS_OK ? scatter(deform) : status;
}
