/*
 * Forces on their way from the GPU. Contacts add to records on the GPU. Batches of records are read to the host, and forces
 * are handed out in the order of the contacts.
 *
 * The n-th contact with a tag adds to record n % RECORDS. Invariants: first <= sent <= next <= first + RECORDS. The records of
 * [first, sent) are in a batch. The records of [sent, next) are still being summed. All other records are zero.
 * Each batch has its own staging buffer, and so its own fence. When no record or no batch is free, the oldest batch is waited
 * for. Its forces are kept until they are taken.
 */
#include <math.h>
#include <string.h>

#include "deform/internal.h"

#define RECORDS DEFORM_FORCES_MOST
#define BATCHES 8

/* A record of scm.frag. */
struct record {
	int64_t force[3], moment[3];
	uint32_t area; /* in deform_area_units */
	int32_t deepest, raised;
	uint32_t saturated; /* and in its two highest bits the state, as lib/found.glsl has it */
	int32_t slope[2];   /* the mean slope of the base under it, east and north, in 2^-16 */
	int64_t pull;
};
#define STATE_BIT 30

struct asked {
	uint64_t tag;
	int64_t z;       /* prescribed, or guessed */
	double arm;      /* of moments, m */
	double area;     /* units of area a post */
	double load;     /* N; 0: none */
	double yaw;
};

struct batch {
	struct gpu_staging *staging;
	uint64_t first, end; /* numbers of contacts */
};

struct forces {
	struct gpu_buffer *records;
	struct asked asked[RECORDS];
	uint64_t first, sent, next;
	struct batch batches[BATCHES]; /* of [first, sent), in order */
	uint32_t oldest, under_way;
	struct deform_forces *ready; /* not taken yet: [taken, there) */
	size_t taken, there, room;
};

static enum status create(struct deform *deform)
{
	struct gpu *gpu = deform->params.gpu;
	deform->forces = mem_calloc(1, sizeof *deform->forces);
	if (deform->forces == NULL)
		return fail_memory("forces");
	enum status status = gpu_buffer_create(gpu, GPU_STORAGE, RECORDS * sizeof(struct record), NULL,
					       &deform->forces->records);
	for (int i = 0; i < BATCHES && status == STATUS_OK; i++)
		status = gpu_staging_create(gpu, RECORDS * sizeof(struct record), &deform->forces->batches[i].staging);
	if (status != STATUS_OK)
		deform_forces_destroy(deform);
	return status;
}

void deform_forces_plan(const char *effect, struct plan *plan)
{
	deform_plan_buffer(plan, effect, 1, RECORDS * sizeof(struct record), "forces");
	deform_plan_buffer(plan, effect, BATCHES, BATCHES * RECORDS * sizeof(struct record), "forces on their way");
}

void deform_forces_destroy(struct deform *deform)
{
	if (deform->forces == NULL)
		return;
	for (int i = 0; i < BATCHES; i++)
		gpu_staging_destroy(deform->forces->batches[i].staging);
	gpu_buffer_destroy(deform->forces->records);
	mem_free(deform->forces->ready);
	mem_free(deform->forces);
	deform->forces = NULL;
}

/* Returns the residual of struct deform_forces. */
static double residual_of(const double force[3], const double slope[2], const struct asked *asked)
{
	const double ahead[2] = {cos(asked->yaw), sin(asked->yaw)};
	const double rise = slope[0] * ahead[0] + slope[1] * ahead[1], weight = asked->load > 0 ? asked->load : force[2];
	return -(force[0] * ahead[0] + force[1] * ahead[1] + (force[2] - weight) * rise) / hypot(1, rise);
}

static struct deform_forces told(const struct deform *deform, const struct asked *asked, const struct record *record)
{
	double post = deform->spacing * deform->spacing, unit = post / DEFORM_UNITS_A_PASCAL;
	struct deform_forces forces = {
		.tag = asked->tag,
		.sinkage = lattice_offset_metres(record->deepest),
		.area = record->area / asked->area * post,
		.z = asked->z + record->raised,
		.saturated = record->saturated & ((1u << STATE_BIT) - 1),
		.state = (enum deform_state)(record->saturated >> STATE_BIT),
	};
	if (record->area == 0 && forces.state != DEFORM_SUNK)
		forces.state = DEFORM_AIR;
	for (int i = 0; i < 2; i++)
		forces.slope[i] = ldexp(record->slope[i], -16);
	for (int i = 0; i < 3; i++) {
		forces.force[i] = (double)record->force[i] * unit;
		forces.moment[i] = (double)record->moment[i] * unit * asked->arm;
	}
	forces.pull = (double)record->pull * unit;
	if (record->area > 0)
		forces.residual = residual_of(forces.force, forces.slope, asked);
	return forces;
}

/* The oldest batch, which is there, to those that can be taken. */
static enum status land(struct deform *deform)
{
	struct forces *forces = deform->forces;
	struct batch *batch = &forces->batches[forces->oldest];
	const struct record *records = gpu_staging_bytes(batch->staging);
	if (forces->taken == forces->there)
		forces->taken = forces->there = 0;
	size_t more = (size_t)(batch->end - batch->first);
	if (forces->there + more > forces->room) {
		size_t room = 2 * (forces->there + more);
		struct deform_forces *ready = mem_realloc(forces->ready, room, sizeof *ready);
		if (ready == NULL)
			return fail_memory("forces");
		forces->ready = ready;
		forces->room = room;
	}
	for (uint64_t n = batch->first; n < batch->end; n++)
		forces->ready[forces->there++] = told(deform, &forces->asked[n % RECORDS], &records[n % RECORDS]);
	forces->first = batch->end;
	forces->oldest = (forces->oldest + 1) % BATCHES;
	forces->under_way--;
	return gpu_check(deform->params.gpu, "forces");
}

static enum status land_oldest(struct deform *deform)
{
	while (!gpu_staging_idle(deform->forces->batches[deform->forces->oldest].staging))
		gpu_finish(deform->params.gpu);
	return land(deform);
}

enum status deform_forces_begin(struct deform *deform)
{
	struct forces *forces = deform->forces;
	if (forces == NULL || forces->sent == forces->next)
		return STATUS_OK;
	if (forces->under_way == BATCHES) {
		enum status status = land_oldest(deform);
		if (status != STATUS_OK)
			return status;
	}
	struct batch *batch = &forces->batches[(forces->oldest + forces->under_way++) % BATCHES];
	batch->first = forces->sent;
	batch->end = forces->next;
	while (forces->sent < forces->next) { /* the ring's end parts them */
		size_t at = forces->sent % RECORDS, count = (size_t)(forces->next - forces->sent);
		count = count < RECORDS - at ? count : RECORDS - at;
		size_t bytes = count * sizeof(struct record), place = at * sizeof(struct record);
		gpu_buffer_read_into(forces->records, place, bytes, batch->staging, place);
		gpu_buffer_clear(forces->records, place, bytes);
		forces->sent += count;
	}
	return gpu_check(deform->params.gpu, "forces");
}

enum status deform_forces_take(struct deform *deform, bool wait, struct deform_forces *out, bool *taken)
{
	struct forces *forces = deform->forces;
	*taken = false;
	if (forces == NULL)
		return STATUS_OK;
	if (forces->taken == forces->there) {
		if (forces->under_way == 0 || (!wait && !gpu_staging_idle(forces->batches[forces->oldest].staging)))
			return STATUS_OK;
		enum status status = land_oldest(deform);
		if (status != STATUS_OK)
			return status;
	}
	*out = forces->ready[forces->taken++];
	*taken = true;
	return STATUS_OK;
}

struct gpu_buffer *deform_forces_records(const struct deform *deform)
{
	return deform->forces->records;
}

enum status deform_forces_reserve(struct deform *deform, size_t count)
{
	enum status status = count > 0 && deform->forces == NULL ? create(deform) : STATUS_OK;
	const struct forces *forces = deform->forces;
	while (count > 0 && status == STATUS_OK && forces->next - forces->first + count > RECORDS)
		status = forces->under_way > 0 ? land_oldest(deform) : deform_forces_begin(deform);
	return status;
}

enum status deform_forces_record(struct deform *deform, const struct deform_contact *contact, bool first_window, double arm,
				 struct gpu_buffer **records, uint32_t *record)
{
	if (deform->forces == NULL) {
		enum status status = create(deform);
		if (status != STATUS_OK)
			return status;
	}
	struct forces *forces = deform->forces;
	if (first_window) {
		enum status status = STATUS_OK;
		if (forces->next - forces->first == RECORDS && forces->under_way == 0)
			status = deform_forces_begin(deform);
		if (status == STATUS_OK && forces->next - forces->first == RECORDS)
			status = land_oldest(deform);
		if (status != STATUS_OK)
			return status;
		forces->asked[forces->next++ % RECORDS] = (struct asked){contact->tag, contact->to.z, arm, deform_area_units(deform, contact), contact->load, contact->to.yaw};
	}
	*records = forces->records;
	*record = (uint32_t)((forces->next - 1) % RECORDS);
	return STATUS_OK;
}
