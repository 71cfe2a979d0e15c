/* furrow_mujoco.h: the soil under a model of MuJoCo that the host owns. */
#include "api/library.h"

#include <string.h>

#include "api/furrow_mujoco.h"

struct furrow_mujoco {
	struct furrow_world *world; /* NULL: it was closed */
	struct vehicle_lent *lent;
	bool begun;                 /* the first step has ended, and the ground at the start is committed */
	int64_t checkpoint;         /* how many checkpoints the world had made with the one to which a reset returns */
	struct furrow_mujoco *next; /* in the world's list */
};

int furrow_mujoco_version(void)
{
	return vehicle_engine_number();
}

const void *furrow_mujoco_own(void)
{
	return vehicle_engine_place();
}

static enum status need(const struct furrow_mujoco *soil)
{
	TRY(api_library_need(soil, "soil"));
	return api_library_need_world(soil->world);
}

/* A call of a step: its data are there, and a step has begun. */
static enum status need_step(const struct furrow_mujoco *soil, const void *data, bool begun)
{
	if (!vehicle_lent_takes(soil->lent, data))
		return fail_with(STATUS_USAGE, "mujoco: data is NULL, and furrow_mujoco_open got no arrays; give the const mjData *");
	if (begun && !vehicle_lent_begun(soil->lent))
		return fail_with(STATUS_USAGE, "mujoco: no step has begun; call furrow_mujoco_begin first");
	return STATUS_OK;
}

static enum status check(const struct furrow_mujoco_open *open)
{
	TRY(api_library_need_size(open->size, sizeof *open, sizeof *open, "mujoco_open"));
	TRY(api_library_need_writable(open->world, "mujoco_open"));
	if ((open->model == NULL) != (open->data == NULL) || (open->model != NULL && open->arrays != NULL))
		return fail_with(STATUS_USAGE, "mujoco: model and data are both given with arrays, or one of them alone; give both, or arrays of both");
	if (open->world->vehicles != NULL)
		return fail_with(STATUS_INPUT, "mujoco: the scene has vehicles of its own, which move by themselves; take them out of the scene");
	return open->arrays != NULL || open->array_count == 0 ? STATUS_OK : api_library_need(open->arrays, "arrays");
}

static enum status create(const struct furrow_mujoco_open *open, struct furrow_mujoco **out)
{
	struct vehicle_lending lending = {.name = open->name != NULL ? open->name : "mujoco", .model = open->model, .data = open->data,
					  .arrays = (const struct vehicle_array *)open->arrays, .array_count = open->array_count, .geoms = open->geoms, .carry = open->carry, .tyres = open->tyres};
	_Static_assert(sizeof(struct vehicle_array) == sizeof(struct furrow_array), "the same struct");
	memcpy(lending.origin, open->origin, sizeof lending.origin);
	struct furrow_mujoco *soil = mem_calloc(1, sizeof *soil);
	TRY_MEM(soil, "the soil under a model");
	soil->world = open->world;
	enum status status;
	TRY_OR(failed, vehicle_lend(&lending, open->world->world, &soil->lent));
	TRY_OR(failed, api_library_checkpoint(open->world));
	soil->checkpoint = open->world->checkpoints;
	soil->next = open->world->soils;
	open->world->soils = soil;
	*out = soil;
	return STATUS_OK;
failed:;
	struct failure failure;
	failure_capture(&failure, status);
	const enum status removed = soil->lent != NULL ? vehicle_lent_remove(soil->lent) : STATUS_OK;
	(void)removed; /* the first failure is told */
	vehicle_lent_destroy(soil->lent);
	mem_free(soil);
	return failure_restore(&failure);
}

furrow_status furrow_mujoco_open(const struct furrow_mujoco_open *open, struct furrow_mujoco **out)
{
	struct library_call call = {.world = NULL};
	enum status status;
	if (out != NULL)
		*out = NULL;
	if (open == NULL || out == NULL) {
		TRY_OR(done, api_library_begin());
		TRY_OR(done, api_library_need(open, "open"));
		TRY_OR(done, api_library_need(out, "out"));
	done:
		return api_library_end(status);
	}
	TRY_OR(left, api_library_enter(&call, open->world));
	TRY_OR(left, check(open));
	TRY_OR(left, create(open, out));
left:
	return api_library_leave(&call, status);
}

void furrow_mujoco_close(struct furrow_mujoco *soil)
{
	struct library_call call = {.world = NULL};
	if (soil == NULL)
		return;
	/* The bodies of a world whose last step has failed stay until it is closed. So they do where the call cannot enter the world. */
	if (soil->world != NULL) {
		for (struct furrow_mujoco **at = &soil->world->soils; *at != NULL; at = &(*at)->next)
			if (*at == soil) {
				*at = soil->next;
				break;
			}
		enum status status = api_library_enter(&call, soil->world);
		if (status == STATUS_OK && !world_is_torn(soil->world->world))
			status = vehicle_lent_remove(soil->lent);
		(void)api_library_leave(&call, status);
	}
	vehicle_lent_destroy(soil->lent);
	mem_free(soil);
}

void api_library_let_go_soils(struct furrow_world *host)
{
	for (struct furrow_mujoco *soil = host->soils; soil != NULL; soil = soil->next)
		soil->world = NULL;
	host->soils = NULL;
}

furrow_status furrow_mujoco_begin(struct furrow_mujoco *soil, const void *data, double seconds, bool again, double *forces)
{
	struct library_call call = {.world = NULL};
	enum status status;
	TRY_OR(done, api_library_enter(&call, soil != NULL ? soil->world : NULL));
	TRY_OR(done, api_library_need(forces, "forces"));
	TRY_OR(done, need_step(soil, data, again));
	TRY_OR(done, vehicle_lent_begin(soil->lent, data, seconds, again, forces));
done:
	return api_library_leave(&call, status);
}

/* What follows reads no ground. */
furrow_status furrow_mujoco_limit(struct furrow_mujoco *soil, const double *qvel, bool *again, double *forces)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, need(soil));
	TRY_OR(done, api_library_need(qvel != NULL && again != NULL ? forces : NULL, "qvel, again or forces"));
	TRY_OR(done, need_step(soil, soil, true));
	*again = vehicle_lent_limit(soil->lent, qvel, forces);
done:
	return api_library_end(status);
}

furrow_status furrow_mujoco_forces(struct furrow_mujoco *soil, const double *qvel, double *forces)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, need(soil));
	TRY_OR(done, api_library_need(qvel != NULL ? forces : NULL, "qvel or forces"));
	TRY_OR(done, need_step(soil, soil, true));
	vehicle_lent_forces(soil->lent, qvel, forces);
done:
	return api_library_end(status);
}

furrow_status furrow_mujoco_end(struct furrow_mujoco *soil, const double *qvel)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, need(soil));
	TRY_OR(done, api_library_need(qvel, "qvel"));
	TRY_OR(done, need_step(soil, soil, true));
	vehicle_lent_end(soil->lent, qvel);
done:
	return api_library_end(status);
}

/* Before the first step: a rollback to here needs no commit of the start again, so that no number of them lets the file grow. */
static enum status begin_run(struct furrow_mujoco *soil)
{
	if (soil->begun || !vehicle_lent_ended(soil->lent))
		return STATUS_OK;
	TRY(world_begin_run(soil->world->world));
	const bool own = soil->checkpoint == soil->world->checkpoints;
	TRY(api_library_checkpoint(soil->world));
	soil->checkpoint = own ? soil->world->checkpoints : soil->checkpoint;
	soil->begun = true;
	return STATUS_OK;
}

furrow_status furrow_mujoco_touch(struct furrow_mujoco *soil, const void *data)
{
	struct library_call call = {.world = NULL};
	enum status status;
	bool moved = false;
	TRY_OR(done, api_library_enter(&call, soil != NULL ? soil->world : NULL));
	TRY_OR(done, need_step(soil, data, false));
	TRY_OR(done, begin_run(soil));
	TRY_OR(done, vehicle_lent_touch(soil->lent, data, &moved));
	if (moved)
		TRY_OR(done, api_library_step(soil->world, vehicle_lent_seconds(soil->lent)));
done:
	return api_library_leave(&call, status);
}

furrow_status furrow_mujoco_reset(struct furrow_mujoco *soil)
{
	if (soil != NULL && soil->world != NULL && soil->checkpoint != soil->world->checkpoints) {
		enum status status;
		TRY_OR(done, api_library_begin());
		status = fail_with(STATUS_USAGE, "mujoco: a checkpoint was made after that of this soil, and a world keeps the last one alone; go back to that one with a rollback "
						 "of the world, or open the soil anew");
	done:
		return api_library_end(status);
	}
	const furrow_status status = furrow_rollback(soil != NULL ? soil->world : NULL);
	if (status == FURROW_OK)
		vehicle_lent_forget(soil->lent);
	return status;
}

size_t furrow_mujoco_count(const struct furrow_mujoco *soil)
{
	return soil != NULL ? vehicle_lent_count(soil->lent) : 0;
}

static enum status tell(const struct furrow_mujoco *soil, size_t index, int *geom, const char **name, struct furrow_contact *contact, size_t contact_size)
{
	struct furrow_contact whole;
	TRY(need(soil));
	if (index >= vehicle_lent_count(soil->lent))
		return fail_with(STATUS_USAGE, "mujoco: there is no soil geom %zu; there are %zu", index, vehicle_lent_count(soil->lent));
	if (contact != NULL)
		TRY(api_library_need_size(contact_size, sizeof whole, sizeof whole, "contact"));
	const int number = vehicle_lent_geom(soil->lent, index, name, NULL, contact);
	if (geom != NULL)
		*geom = number;
	return STATUS_OK;
}

furrow_status furrow_mujoco_geom(const struct furrow_mujoco *soil, size_t index, int *geom, const char **name, struct furrow_contact *contact, size_t contact_size)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, tell(soil, index, geom, name, contact, contact_size));
done:
	return api_library_end(status);
}
