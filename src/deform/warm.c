/*
 * Prepares the programs of an object before the first step. Each pass that its contacts or its rest can need runs once, over a
 * window outside the world.
 */
#include "deform/internal.h"

struct linking {
	struct gpu *gpu;
	enum status status;
};

static void link_program(void *user, const char *effect, const struct gpu_program_request *request)
{
	struct linking *linking = user;
	struct gpu_program *program;
	(void)effect;
	if (linking->status == STATUS_OK)
		linking->status = gpu_program_get(linking->gpu, request, &program);
}

/* Runs contacts without motion, with a small motion, and for a wheel also with a motion along its axis. */
static enum status contact_all(struct deform *deform, const struct deform_planned *object)
{
	const struct post_rect beyond = {-64, -64, -48, -48};
	const struct deform_window window = {.read = beyond, .write = beyond};
	const struct soil_pose middle = {.x = lattice_offset(-56 * deform->spacing), .y = lattice_offset(-56 * deform->spacing)};
	int ways = !object->moves ? 1 : object->shape->kind == SOIL_WHEEL ? 3 : 2;
	for (int i = 0; i < ways * (1 + object->leans); i++) {
		struct deform_contact contact = {.shape = object->shape, .from = middle, .to = middle};
		contact.to.roll = i / ways * 0.1;
		contact.to.x += i % ways > 0;
		contact.to.y += i % ways > 1;
		TRY(deform_compute(deform, &contact, &window, 0, NULL, 0));
		if (deform->params.roofs && deform_conserves(deform->params.model)) {
			const struct deform_rest rest = {.shape = object->shape, .pose = contact.to, .roofs = true};
			contact.rests = &rest;
			contact.rest_count = 1;
			TRY(deform_compute(deform, &contact, &window, 0, NULL, 0));
		}
		if (deform->params.fixed)
			TRY(deform_fixed_warm(deform, &contact, &window));
	}
	return STATUS_OK;
}

/* Runs batches of contacts as above: two windows each. They lie beyond the world. */
static enum status batch_all(struct deform *deform, const struct deform_planned *object)
{
	const struct deform_window window = {.read = {-64, -64, -48, -48}, .write = {-64, -64, -48, -48}};
	const struct soil_pose middle = {.x = lattice_offset(-56 * deform->spacing), .y = lattice_offset(-56 * deform->spacing)};
	int ways = !object->moves ? 1 : object->shape->kind == SOIL_WHEEL ? 3 : 2;
	if (!deform_batches(&deform->params, object))
		return STATUS_OK;
	for (int i = 0; i < ways * (1 + object->leans); i++) {
		struct deform_contact contact = {.shape = object->shape, .from = middle, .to = middle};
		contact.to.roll = i / ways * 0.1;
		contact.to.x += i % ways > 0;
		contact.to.y += i % ways > 1;
		deform_batch_begin(deform);
		bool added = deform_is_batched(deform, &contact, &window, 1);
		for (int k = 0; k < 2 && added; k++)
			TRY(deform_batch_add(deform, &contact, &window, NULL, 0, &added));
		TRY(deform_batch_compute(deform));
	}
	return STATUS_OK;
}

/* Returns the kind of an object, below WARM_KINDS. Objects of one kind need the same programs. */
static int kind_of(const struct deform_planned *object)
{
	const struct soil_shape *shape = object->shape;
	const bool facts[WARM_FACTS] = {shape->grousers > 0, object->moves, object->leans};
	int kind = (int)shape->kind;
	for (int i = 0; i < WARM_FACTS; i++)
		kind = 2 * kind + facts[i];
	return kind;
}

/* Links all programs that an object needs, and runs each. */
static enum status run_all(struct deform *deform, const struct deform_planned *object)
{
	struct linking linking = {.gpu = deform->params.gpu};
	deform_programs_each(&deform->params, object, link_program, &linking);
	TRY(linking.status);
	TRY(contact_all(deform, object));
	TRY(batch_all(deform, object));
	return deform->interval != NULL ? deform_interval_warm(deform, object->shape) : STATUS_OK;
}

enum status deform_warm(struct deform *deform, const struct deform_planned *object)
{
	bool *warmed = &deform->warmed[kind_of(object)];
	if (*warmed)
		return STATUS_OK;
	*warmed = true;
	const struct deform_figures before = deform->figures;
	enum status status = run_all(deform, object);
	deform->figures = before;
	return status;
}
