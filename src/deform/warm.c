/* Everything that an object's sweeps and its rest will run, once, where there is no ground. */
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

/* What a contact that asked for its forces is told, and nobody wants. */
static enum status drop_forces(struct deform *deform)
{
	struct deform_forces forces;
	bool taken = true;
	enum status status = deform_forces_begin(deform);
	while (status == STATUS_OK && taken)
		status = deform_forces_take(deform, true, &forces, &taken);
	return status;
}

/* Standing, or in motion, however little; a wheel along its own axis too. With a tag and without, as sweeps have them. */
static enum status sweep_all(struct deform *deform, const struct deform_planned *object, bool tags)
{
	const struct post_rect beyond = {-64, -64, -48, -48};
	const struct deform_window window = {beyond, beyond};
	const struct deform_pose middle = {.x = lattice_offset(-56 * deform->spacing), .y = lattice_offset(-56 * deform->spacing)};
	int ways = !object->moves ? 1 : object->shape->kind == DEFORM_WHEEL ? 3 : 2;
	enum status status = STATUS_OK;
	for (int i = 0; i < ways * (1 + tags) && status == STATUS_OK; i++) {
		struct deform_sweep sweep = {.shape = object->shape, .from = middle, .to = middle, .load = object->load,
					     .tag = (uint64_t)(i / ways)};
		sweep.to.x += i % ways > 0;
		sweep.to.y += i % ways > 1;
		status = deform_compute(deform, &sweep, &window, 0, NULL, 0);
	}
	return status;
}

/* A bit for each kind of object that programs are told apart by. */
static uint64_t kind_of(const struct deform_params *params, const struct deform_planned *object)
{
	const struct deform_shape *shape = object->shape;
	const bool facts[4] = {shape->lugs > 0, object->load > 0, object->moves, deform_is_counted(params, shape, object->load > 0)};
	int kind = (int)shape->kind;
	for (int i = 0; i < 4; i++)
		kind = 2 * kind + facts[i];
	return (uint64_t)1 << kind;
}

enum status deform_warm(struct deform *deform, const struct deform_planned *object, bool forces)
{
	const struct deform_params *params = &deform->params;
	uint64_t kind = kind_of(params, object);
	if (deform->warmed & kind)
		return STATUS_OK;
	deform->warmed |= kind;
	const struct deform_figures before = deform->figures;
	bool loaded = deform_tells_forces(params->model) && object->load > 0;
	struct linking linking = {.gpu = params->gpu};
	deform_programs_each(params, object, forces, link_program, &linking);
	enum status status = linking.status;
	if (status == STATUS_OK)
		status = sweep_all(deform, object, deform_tells_forces(params->model) && (forces || loaded));
	if (status == STATUS_OK && deform->interval != NULL)
		status = deform_interval_warm(deform, object->shape, loaded && params->loaded_bodies > 0);
	if (status == STATUS_OK)
		status = drop_forces(deform);
	deform->figures = before;
	return status;
}
