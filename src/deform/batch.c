/*
 * Batches: small contacts whose windows share no post, computed together. Their windows lie beside each other in layer 0, and each pass
 * draws all of them. So the cost of a pass is paid once for a batch, not once for a body. A pass reads only posts of the same window, and
 * all numbers are whole. So a window's posts have the same bits as if it were computed alone.
 *
 * A batch: begun -> windows are added and gathered -> computed -> its windows are scattered -> begun again.
 *
 * Invariants: (1) Windows lie in rows, from the south-west corner, and do not overlap. The first is at (0, 0), so a batch of one window
 * is computed as a window that is alone. (2) Records are in the order of `group`, so that one draw takes all of a group.
 */
#include <assert.h>
#include <string.h>

#include "deform/internal.h"

/* The numbers of a window that batch.vert passes on: its posts, those of lib/contact.glsl, those of lib/envelope.glsl. */
struct record {
	int32_t posts[4];
	int32_t zero[4], written[4];
	int32_t bodies[18][4]; /* functionals and numbers of the motion, then those of the end pose */
};
_Static_assert(sizeof(struct record) == DEFORM_BATCH_RECORD * 16, "deform_programs_batch");

/* Windows of one group have one program for their contact, which also computes the lower envelope. In the last group that is drawn for
 * each window alone. */
enum group { WHEELS, SIDEWAYS_WHEELS, SPHERES, OTHERS, GROUPS };

struct batched {
	struct deform_contact contact;
	struct deform_window window;
	struct gpu_rect posts; /* where it lies in the layer */
};

struct batch {
	struct batched windows[DEFORM_BATCH_MOST];
	size_t count;
	uint32_t x, y, height; /* the first free post of the last row of windows, and the rows of posts that it takes */
	struct record records[DEFORM_BATCH_MOST], unsorted[DEFORM_BATCH_MOST];
	enum group groups[DEFORM_BATCH_MOST];
	size_t first[GROUPS + 1]; /* records of group g: first[g] to first[g + 1] */
	struct gpu_list *list;
	struct gpu_program *contact[GROUPS], *box, *disturbance;
};

enum status deform_batch_create(struct deform *deform)
{
	deform->batch = mem_calloc(1, sizeof *deform->batch);
	if (deform->batch == NULL)
		return fail_memory("a batch of windows");
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
	deform_plan_buffer(plan, deform_displace_effect(params->model), 1, gpu_list_bytes(sizeof(struct record) * DEFORM_BATCH_MOST), DEFORM_BATCH_BUFFER);
}

static bool is_batched(const struct deform_params *params, const struct deform_shape *shape)
{
	return params->batches && deform_model_row(params->model)->batch != NULL && shape->kind != DEFORM_MESH && shape->grousers == 0;
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
	batch->count = 0;
	batch->x = batch->y = batch->height = 0;
}

/* Windows begin at multiples of four posts. A software rasteriser computes squares of four by four. */
static uint32_t aligned(int64_t posts)
{
	return (uint32_t)(posts + 3) / 4 * 4;
}

bool deform_batch_add(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
		      const struct deform_tile *tiles, size_t count)
{
	struct batch *batch = deform->batch;
	const struct post_rect read = window->read;
	const uint32_t width = aligned(read.x1 - read.x0), height = aligned(read.y1 - read.y0);
	assert(width <= SIDE && height <= SIDE);
	if (batch->x + width > SIDE) {
		batch->y += batch->height;
		batch->x = batch->height = 0;
	}
	if (batch->count == DEFORM_BATCH_MOST || batch->y + height > SIDE)
		return false;
	struct batched *batched = &batch->windows[batch->count++];
	*batched = (struct batched){*contact, *window,
				    {batch->x, batch->y, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)}};
	batch->x += width;
	batch->height = height > batch->height ? height : batch->height;
	deform_gather(deform, read, 0, batched->posts.x, batched->posts.y, false, deform->planes, tiles, count);
	return true;
}

static enum group group_of(const struct under_params *under)
{
	if (under->kind == DEFORM_WHEEL)
		return under->sideways ? SIDEWAYS_WHEELS : WHEELS;
	return under->kind == DEFORM_SPHERE ? SPHERES : OTHERS;
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

static void fill_record(const struct deform *deform, const struct batched *batched, const struct under_params *under, enum group group,
			struct record *record)
{
	const struct contact_params contact = deform_contact_params(deform, &batched->contact, &batched->window, 0);
	const int32_t at[2] = {(int32_t)batched->posts.x, (int32_t)batched->posts.y};
	deform_posts_of(batched->posts, record->posts);
	memcpy(record->zero, contact.zero, sizeof record->zero);
	for (int k = 0; k < 4; k++)
		record->written[k] = contact.written[k] + at[k % 2];
	if (group != OTHERS)
		put_body(put_body(record->bodies, &under->motion, group == SIDEWAYS_WHEELS ? 4 : 2), &under->end, 2);
}

static void sort_records(struct batch *batch)
{
	size_t at = 0;
	for (int group = 0; group < GROUPS; group++) {
		batch->first[group] = at;
		for (size_t i = 0; i < batch->count; i++)
			if (batch->groups[i] == (enum group)group)
				batch->records[at++] = batch->unsorted[i];
	}
	batch->first[GROUPS] = at;
}

/* Runs a pass over `count` records from `first` on. Fills the pass's program, geometry and parameters. */
static enum status run(struct deform *deform, enum deform_batch_pass which, struct gpu_program **program, size_t first, size_t count,
		       struct gpu_pass *pass)
{
	const int32_t params[4] = {(int32_t)first};
	struct deform_request request;
	deform_programs_batch(&deform->params, which, &request);
	enum status status = deform_program(deform, &request, program);
	if (status != STATUS_OK)
		return status;
	pass->program = *program;
	pass->viewport = (struct gpu_rect){0, 0, SIDE, SIDE};
	pass->lists[4] = deform->batch->list;
	pass->params = params;
	pass->params_bytes = sizeof params;
	pass->instances = (uint32_t)count;
	gpu_pass_run(deform->params.gpu, pass);
	return STATUS_OK;
}

/* Fills the records, and draws the lower envelopes that the contact pass does not compute. */
static enum status prepare(struct deform *deform)
{
	struct batch *batch = deform->batch;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < batch->count && status == STATUS_OK; i++) {
		const struct batched *batched = &batch->windows[i];
		const struct post_rect read = batched->window.read;
		struct under_params under;
		deform_under_of(deform, &batched->contact, read.x0 - batched->posts.x, read.y0 - batched->posts.y, &under);
		batch->groups[i] = group_of(&under);
		fill_record(deform, batched, &under, batch->groups[i], &batch->unsorted[i]);
		if (batch->groups[i] == OTHERS) {
			status = deform_under_run(deform, &under, batched->posts, 0);
			deform->figures.batch_envelopes++;
		}
	}
	sort_records(batch);
	gpu_list_write(batch->list, batch->count * sizeof *batch->records, batch->records);
	return status;
}

enum status deform_batch_contact(struct deform *deform)
{
	static const enum deform_batch_pass passes[GROUPS] = {
		[WHEELS] = BATCH_WHEELS, [SIDEWAYS_WHEELS] = BATCH_SIDEWAYS_WHEELS, [SPHERES] = BATCH_SPHERES, [OTHERS] = BATCH_OTHERS,
	};
	struct batch *batch = deform->batch;
	struct layer *scratch = &deform->scratch[0];
	enum status status = STATUS_OK;
	for (int group = 0; group < GROUPS && status == STATUS_OK; group++) {
		const size_t first = batch->first[group], count = batch->first[group + 1] - first;
		const bool drawn = group == OTHERS;
		if (count == 0)
			continue;
		status = run(deform, passes[group], &batch->contact[group], first, count, &(struct gpu_pass){
			.stage = GPU_CONTACT,
			.target = scratch->to[TO_CONTACT],
			.images = {deform->bases, deform->planes_of[0][PLANE_OFFSET], drawn ? deform->under : NULL, drawn ? deform->rest : NULL},
			.storage = {deform->tally},
		});
		deform->figures.batch_draws++;
	}
	scratch->now[PLANE_OFFSET] = 1;
	return status;
}

enum status deform_batch_smooth(struct deform *deform)
{
	struct layer *scratch = &deform->scratch[0];
	enum status status = STATUS_OK;
	for (int i = 0; i < deform->params.box_repetitions && status == STATUS_OK; i++) {
		int now = scratch->now[PLANE_OFFSET];
		status = run(deform, BATCH_BOX, &deform->batch->box, 0, deform->batch->count, &(struct gpu_pass){
			.stage = GPU_SMOOTH,
			.target = scratch->to[now == 0 ? TO_SECOND : TO_FIRST],
			.images = {deform->planes_of[now][PLANE_OFFSET], deform->contacts},
		});
		scratch->now[PLANE_OFFSET] = 1 - now;
	}
	return status;
}

static enum status disturb(struct deform *deform)
{
	struct layer *scratch = &deform->scratch[0];
	int now = scratch->now[PLANE_OFFSET];
	scratch->now[PLANE_DISTURBANCE] = 1;
	return run(deform, BATCH_DISTURBANCE, &deform->batch->disturbance, 0, deform->batch->count, &(struct gpu_pass){
		.stage = GPU_DISTURBANCE,
		.target = scratch->to[TO_DISTURBANCE],
		.textures = {deform->planes_of[now][PLANE_OFFSET], deform->contacts, deform->planes_of[0][PLANE_DISTURBANCE]},
	});
}

enum status deform_batch_compute(struct deform *deform)
{
	struct batch *batch = deform->batch;
	enum status status;
	if (batch->count == 0)
		return STATUS_OK;
	if (batch->count == 1) {
		status = deform_run_stages(deform, &batch->windows[0].contact, &batch->windows[0].window, 0);
	} else {
		memset(deform->scratch[0].now, 0, sizeof deform->scratch[0].now);
		deform->figures.batches++;
		status = prepare(deform);
		if (status == STATUS_OK)
			status = deform_model_row(deform->params.model)->batch(deform);
		if (status == STATUS_OK && deform->params.disturbance)
			status = disturb(deform);
	}
	return status == STATUS_OK ? gpu_check(deform->params.gpu, "deformation") : status;
}

enum status deform_batch_scatter(struct deform *deform, size_t which, const struct deform_tile *tiles, size_t count)
{
	const struct batched *batched = &deform->batch->windows[which];
	const struct post_rect read = batched->window.read, write = batched->window.write;
	struct scatter_from from = {.x = batched->posts.x + (uint32_t)(write.x0 - read.x0), .y = batched->posts.y + (uint32_t)(write.y0 - read.y0)};
	assert(which < deform->batch->count);
	for (int plane = 0; plane < PLANES; plane++)
		from.planes[plane] = deform->planes_of[deform->scratch[0].now[plane]][plane];
	return deform_scatter_from(deform, write, &from, tiles, count);
}
