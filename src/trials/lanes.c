/* One drive over the bed: the scene, its steps, and the means of the forces. Each lane has an object, or several behind each other. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/lattice.h"
#include "trials/internal.h"

#define DEGREES (180 / M_PI)

/* Sums over the halves of the way's end. */
struct sums {
	double count[2], sinkage[2], against[2], drawbar, side, fz, torque; /* torque: of a belt its pull */
	double overturning, aligning, against_least, against_most;
	double heap, heap_volume; /* m, m3, at the end */
	double sunk; /* samples in which the soil did not carry the load */
};

/* Where a body starts: those of a lane in the order of their passes. */
static double start_of(const struct rig *rig, size_t body)
{
	return rig->start + (double)(rig->passes - 1 - body % rig->passes) * rig->behind;
}

/* --- the scene --- */

/* `count`: of lanes. */
static int text_of(const struct rig *rig, size_t soil, const struct rig_lane *lanes, size_t count, FILE *out)
{
	const struct rig_found *found = &rig->found;
	const char *name = rig->params->soils[soil];
	const double step = found->spacing / rig->speed, rake = rig->params->rake > 0 ? rig->params->rake : 90;
	fprintf(out, "scene: 1\ntime_step: %.17g\nend_time: %.17g\nspacing: %.17g\n", step, found->way / rig->speed, found->spacing);
	fprintf(out, trials_in_braces(name) ? "soil: %s\n" : "soil: {name: %s}\n", name);
	fprintf(out, "redistribute: {model: scm}\noutput: {forces: %.17g}\nobjects:\n", (1 - 1e-9) / step);
	for (size_t i = 0; i < count * rig->passes; i++) {
		const size_t pass = i % rig->passes;
		const struct rig_lane *lane = &lanes[i / rig->passes];
		const double x = start_of(rig, i), y = rig->start + (double)(i / rig->passes) * rig->pitch;
		fprintf(out, "  - {name: lane_%zu", i / rig->passes + 1);
		if (rig->passes > 1)
			fprintf(out, "_%zu", pass + 1);
		fprintf(out, ", shape: %s, ", rig->shape);
		if (isnan(lane->load))
			fprintf(out, "sink: %.17g, ", lane->depth);
		else
			fprintf(out, "load: %.17g, ", pass + 1 < rig->passes ? lane->lead : lane->load);
		if (lane->angle != 0 || rake != 90)
			fprintf(out, "attitude: [%.17g, %.17g, 0], ", lane->angle * DEGREES, 90 - rake);
		if (!isnan(lane->slip))
			fprintf(out, "slip: %.17g, ", lane->slip);
		fprintf(out, "path: {points: [[%.17g, %.17g], [%.17g, %.17g]], speed: %.17g}}\n", x, y, x + found->way, y, rig->speed);
	}
	return ferror(out);
}

static char *text_for(const struct rig *rig, size_t soil, const struct rig_lane *lanes, size_t count)
{
	char *text = NULL;
	size_t length;
	FILE *stream = open_memstream(&text, &length);
	if (stream == NULL)
		return NULL;
	const int failed = text_of(rig, soil, lanes, count, stream);
	if (fclose(stream) == 0 && failed == 0)
		return text;
	free(text);
	return NULL;
}

/* Where the reason in a message on a scene's text begins, behind its name, line and column. NULL: it is no such message. */
static const char *reason_of(const char *message)
{
	static const char name[] = "scene text:";
	if (strncmp(message, name, strlen(name)) != 0)
		return NULL;
	const char *reason = message + strlen(name);
	for (int i = 0; i < 2; i++) {
		reason += strspn(reason, "0123456789");
		reason += *reason == ':';
	}
	return reason + (*reason == ' ');
}

static enum status open_world(const struct rig *rig, size_t soil, const struct rig_lane *lanes, size_t count, struct furrow_world **world)
{
	char *text = text_for(rig, soil, lanes, count), why[512];
	TRY_MEM(text, "a scene");
	const struct furrow_open open = {.size = sizeof open, .scene = text, .store = rig->bed, .settings = rig->params->settings,
					 .advise = rig->params->advise && !rig->advised};
	const enum status status = trials_told(furrow_world_open(&open, world));
	free(text);
	const char *reason = status == STATUS_OK ? NULL : reason_of(failure_message());
	if (reason == NULL)
		return status;
	snprintf(why, sizeof why, "%s", reason);
	return fail_with(status, "rig: soil %s, in the scene that it makes: %.400s", rig->params->soils[soil], why);
}

/* --- the rows --- */

/* Adds what the soil does to a body at a path sample. */
static void take(const struct rig *rig, const struct rig_lane *lane, size_t body, const struct furrow_contact *contact, struct sums *sums)
{
	/* The body is at a multiple of the lattice. */
	const double x = lattice_offset_metres(lattice_offset(start_of(rig, body) + contact->time * rig->speed));
	const double left = start_of(rig, body) + rig->found.way - x; /* of the way */
	if (!(left <= rig->taken))
		return;
	const double *force = contact->force, *moment = contact->moment, c = cos(lane->angle), s = sin(lane->angle);
	const int half = left <= rig->taken / 2;
	const bool first = sums->count[0] + sums->count[1] == 0;
	sums->count[half]++;
	sums->sinkage[half] += contact->sinkage;
	sums->drawbar += c * force[0] + s * force[1];
	sums->side += c * force[1] - s * force[0];
	sums->fz += force[2];
	/* The soil turns a wheel back, about the axis to the left. */
	sums->torque += rig->found.belt ? contact->pull : s * moment[0] - c * moment[1];
	sums->overturning += c * moment[0] + s * moment[1];
	sums->aligning += moment[2];
	sums->against[half] -= force[0];
	sums->against_least = first ? -force[0] : fmin(sums->against_least, -force[0]);
	sums->against_most = first ? -force[0] : fmax(sums->against_most, -force[0]);
	sums->sunk += contact->state == FURROW_SUNK;
}

/* Measures the soil ahead of a body's origin that lies above the untouched ground, half a lane to each side. */
static enum status take_heap(const struct rig *rig, struct furrow_world *world, size_t body, struct sums *sums)
{
	const double post = rig->found.spacing, x = start_of(rig, body) + rig->found.way, y = rig->start + (double)(body / rig->passes) * rig->pitch;
	const int64_t column = (int64_t)ceil(x / post - 1e-6), row = (int64_t)ceil((y - rig->pitch / 2) / post);
	const uint32_t side = (uint32_t)floor(rig->pitch / post);
	struct furrow_info info = {.size = sizeof info};
	double *posts = mem_alloc((size_t)side * side, sizeof *posts);
	TRY_MEM(posts, "the rig's heap");
	enum status status;
	TRY_OR(done, trials_told(furrow_info(world, &info)));
	TRY_OR(done, trials_told(furrow_read(world, FURROW_OFFSET, info.level, column, row, side, side, posts, side)));
	for (size_t i = 0; i < (size_t)side * side; i++) {
		if (!(posts[i] > 0))
			continue;
		sums->heap = fmax(sums->heap, posts[i]);
		sums->heap_volume += posts[i] * post * post;
	}
done:
	mem_free(posts);
	return status;
}

/* The state of a row that is not sunk. At a depth the body does not sink, so that the force tells. */
static enum rig_state state_of(const struct rig_lane *lane, const struct rig_row *row, const struct sums *sums)
{
	const double change = sums->against[1] / sums->count[1] - sums->against[0] / sums->count[0];
	if (isnan(lane->load))
		return fabs(change) > RIG_DIGS_ABOVE * fabs(row->against) ? RIG_GROWS : RIG_STEADY;
	return fabs(row->deeper) > RIG_DIGS_ABOVE * fabs(row->sinkage) ? RIG_DIGS : RIG_STEADY;
}

static void fill(const struct rig *rig, size_t soil, struct rig_lane *lane, size_t pass, const struct sums *sums)
{
	const double count = sums->count[0] + sums->count[1];
	const double first = sums->sinkage[0] / sums->count[0], second = sums->sinkage[1] / sums->count[1];
	const bool driven = trials_rig_is_driven(rig);
	const size_t angles = rig->params->angle_count > 0 ? rig->params->angle_count : 1;
	struct rig_row *row = &lane->rows[pass];
	*row = (struct rig_row){
		.soil = soil,
		.load = lane->place / angles,
		.angle = lane->place % angles,
		.pass = pass,
		.slip = lane->slip,
		.torque = driven ? sums->torque / count : (double)NAN,
		.sinkage = (sums->sinkage[0] + sums->sinkage[1]) / count,
		.drawbar = sums->drawbar / count,
		.side = sums->side / count,
		.fz = sums->fz / count,
		.efficiency = NAN,
		.overturning = sums->overturning / count,
		.aligning = sums->aligning / count,
		.against = (sums->against[0] + sums->against[1]) / count,
		.against_least = sums->against_least,
		.against_most = sums->against_most,
		.heap = sums->heap,
		.heap_volume = sums->heap_volume,
		.deeper = second - first,
	};
	if (driven && row->torque > 0 && row->against < 0 && row->slip > 0)
		row->efficiency = -row->against * (1 - row->slip) * rig->found.arm / row->torque;
	row->state = sums->sunk > RIG_SUNK_ABOVE * count ? RIG_SUNK : state_of(lane, row, sums);
}

/* --- the drive --- */

/* Bodies come to a path sample in each step. The first step is half as long as the others, so that no sample falls on the end of a step. */
static enum status steps(struct rig *rig, struct furrow_world *world, const struct rig_lane *lanes, struct sums *sums, size_t count)
{
	furrow_body bodies[RIG_LANES_MOST * RIG_PASSES_MOST];
	struct furrow_contact contacts[RIG_LANES_MOST * RIG_PASSES_MOST];
	const size_t all = count * rig->passes;
	const double step = rig->found.spacing / rig->speed;
	const int64_t total = (int64_t)round(rig->found.way / rig->found.spacing), before = rig->done;
	for (size_t i = 0; i < all; i++)
		bodies[i] = (furrow_body)i; /* those of a scene come first */
	for (int64_t k = 0; k < total; k++) {
		if (rig->params->stop != NULL && *rig->params->stop)
			return fail_with(STATUS_INTERRUPTED, "rig: interrupted; run it again to start over");
		TRY(trials_told(furrow_step(world, k == 0 ? step / 2 : step)));
		if ((double)(total - k - 1) * rig->found.spacing <= rig->taken) {
			TRY(trials_told(furrow_get_contacts(world, all, bodies, contacts, sizeof *contacts)));
			for (size_t i = 0; i < all; i++)
				take(rig, &lanes[i / rig->passes], i, &contacts[i], &sums[i]);
		}
		rig->done = before + (int64_t)count * (k + 1) / total;
		if (rig->params->progress != NULL)
			TRY(rig->params->progress(rig->params->user, rig->done, rig->total));
	}
	for (size_t i = 0; i < all; i++)
		TRY(take_heap(rig, world, i, &sums[i]));
	return STATUS_OK;
}

/* Drives lanes that fit one bed. */
static enum status drive(struct rig *rig, size_t soil, const struct rig_lane *lanes, size_t count, struct sums *sums)
{
	struct furrow_world *world = NULL;
	struct failure failure;
	TRY(trials_bed_make(rig, count));
	TRY(open_world(rig, soil, lanes, count, &world));
	rig->advised = true;
	const enum status status = steps(rig, world, lanes, sums, count);
	failure_capture(&failure, status);
	const enum status closed = trials_told(furrow_world_close(world));
	return status == STATUS_OK ? closed : failure_restore(&failure);
}

enum status trials_lanes_drive(struct rig *rig, size_t soil, struct rig_lane *lanes, size_t count)
{
	struct sums sums[RIG_LANES_MOST * RIG_PASSES_MOST];
	for (size_t at = 0; at < count; at += RIG_LANES_MOST) {
		const size_t now = count - at < RIG_LANES_MOST ? count - at : RIG_LANES_MOST;
		memset(sums, 0, sizeof sums);
		TRY(drive(rig, soil, lanes + at, now, sums));
		for (size_t i = 0; i < now * rig->passes; i++)
			fill(rig, soil, &lanes[at + i / rig->passes], i % rig->passes, &sums[i]);
	}
	return STATUS_OK;
}
