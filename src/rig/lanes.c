/* One drive over the bed: the scene, its steps, and the means of the forces. Each lane has an object, or several behind each other. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rig/internal.h"
#include "world/world.h"

#define SPEED 0.1    /* m/s: no force of a body on a path depends on it */

/* Sums over the halves of the way's end. */
struct sums {
	double count[2], sinkage[2], drawbar, side, fz, torque; /* torque: of a belt its pull */
	bool sunk;
	double first; /* m: where the row before was taken, so that a place counts once */
};

struct taking {
	const struct rig *rig;
	struct sums *sums;
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
	const double step = found->spacing / SPEED;
	fprintf(out, "scene: 1\ntime_step: %.17g\nend_time: %.17g\nspacing: %.17g\n", step, found->way / SPEED, found->spacing);
	fprintf(out, rig_in_braces(name) ? "soil: %s\n" : "soil: {name: %s}\n", name);
	fprintf(out, "redistribute: {model: scm}\noutput: {forces: %.17g}\nobjects:\n", (1 - 1e-9) / step);
	for (size_t i = 0; i < count * rig->passes; i++) {
		const size_t pass = i % rig->passes;
		const struct rig_lane *lane = &lanes[i / rig->passes];
		const double x = start_of(rig, i), y = rig->start + (double)(i / rig->passes) * rig->pitch;
		fprintf(out, "  - {name: lane_%zu", i / rig->passes + 1);
		if (rig->passes > 1)
			fprintf(out, "_%zu", pass + 1);
		fprintf(out, ", shape: %s, load: %.17g, ", rig->shape, pass + 1 < rig->passes ? lane->lead : lane->load);
		if (!isnan(lane->slip))
			fprintf(out, "slip: %.17g, ", lane->slip);
		fprintf(out, "path: {points: [[%.17g, %.17g], [%.17g, %.17g]], speed: %.17g}}\n", x, y, x + found->way, y, SPEED);
	}
	return ferror(out);
}

static enum status load(const struct rig *rig, size_t soil, const struct rig_lane *lanes, size_t count, struct scene **out)
{
	char *text = NULL;
	size_t length;
	FILE *stream = open_memstream(&text, &length);
	if (stream == NULL)
		return fail_memory("a scene");
	int failed = text_of(rig, soil, lanes, count, stream);
	failed |= fclose(stream);
	enum status status = failed != 0 ? fail_memory("a scene")
					 : scene_load_text(text, NULL, rig->params->settings, rig->params->setting_count, SCENE_COMMAND, out);
	free(text);
	if (status != STATUS_INPUT && status != STATUS_USAGE)
		return status;
	char why[512];
	snprintf(why, sizeof why, "%s", scene_text_reason(failure_message()));
	return fail_with(status, "rig: soil %s, in the scene that it makes: %.400s", rig->params->soils[soil], why);
}

/* --- the rows --- */

static void take(const struct taking *taking, const struct world_row *row)
{
	struct sums *sums = &taking->sums[row->body];
	const double left = start_of(taking->rig, row->body) + taking->rig->found.way - row->position[0]; /* of the way */
	if (left > taking->rig->taken || row->position[0] == sums->first)
		return;
	const int half = left <= taking->rig->taken / 2;
	sums->first = row->position[0];
	sums->count[half]++;
	sums->sinkage[half] += row->force.sinkage;
	sums->drawbar += row->force.force[0];
	sums->side += row->force.force[1];
	sums->fz += row->force.force[2];
	/* The soil turns a wheel back, about the axis to the left. */
	sums->torque += taking->rig->found.belt ? row->force.pull : -row->force.moment[1];
	sums->sunk |= row->force.state == DEFORM_SUNK;
}

static void fill(const struct rig *rig, size_t soil, struct rig_lane *lane, size_t pass, const struct sums *sums)
{
	const double count = sums->count[0] + sums->count[1];
	const double first = sums->sinkage[0] / sums->count[0], second = sums->sinkage[1] / sums->count[1];
	const bool driven = rig_is_driven(rig);
	struct rig_row *row = &lane->rows[pass];
	*row = (struct rig_row){
		.soil = soil,
		.pass = pass,
		.slip = lane->slip,
		.torque = driven ? sums->torque / count : (double)NAN,
		.sinkage = (sums->sinkage[0] + sums->sinkage[1]) / count,
		.drawbar = sums->drawbar / count,
		.side = sums->side / count,
		.fz = sums->fz / count,
		.efficiency = NAN,
		.deeper = second - first,
	};
	for (size_t i = 0; i < rig->params->load_count; i++)
		if (rig->params->loads[i] == lane->load)
			row->load = i;
	if (driven && row->torque > 0 && row->drawbar > 0 && row->slip > 0)
		row->efficiency = row->drawbar * (1 - row->slip) * rig->found.arm / row->torque;
	if (sums->sunk)
		row->state = RIG_SUNK;
	else if (fabs(row->deeper) > RIG_DIGS_ABOVE * fabs(row->sinkage))
		row->state = RIG_DIGS;
}

/* --- the drive --- */

static enum status steps(struct rig *rig, struct world *world, const struct taking *taking, size_t count)
{
	const int64_t total = world_step_count(world), before = rig->done;
	enum status status = world_begin(world);
	while (world_steps_done(world) < total && status == STATUS_OK) {
		if (world_stopped(world))
			return fail_with(STATUS_INTERRUPTED, "rig: interrupted; run it again to start over");
		status = world_step(world);
		size_t row_count;
		const struct world_row *rows = world_rows(world, &row_count);
		for (size_t i = 0; i < row_count; i++)
			take(taking, &rows[i]);
		world_rows_clear(world);
		rig->done = before + (int64_t)count * world_steps_done(world) / total;
		if (status == STATUS_OK && rig->params->progress != NULL)
			status = rig->params->progress(rig->params->user, rig->done, rig->total);
	}
	return status;
}

static enum status drive(struct rig *rig, const struct scene *scene, struct sums *sums, size_t count)
{
	struct world *world = NULL;
	const struct taking taking = {rig, sums};
	const struct world_params params = {.scene = scene, .store = rig->bed, .rows = true, .stop = rig->params->stop};
	enum status status = world_open(&params, &world);
	if (status == STATUS_OK && !rig->advised && rig->params->tell != NULL)
		world_advise(world, rig->params->tell, rig->params->user);
	rig->advised = true;
	if (status == STATUS_OK)
		status = world_start(world);
	if (status == STATUS_OK)
		status = world_start_pages(world, NULL, NULL);
	if (status == STATUS_OK)
		status = world_warm(world);
	if (status == STATUS_OK) {
		world_seal(world);
		status = steps(rig, world, &taking, count);
	}
	struct failure failure;
	failure_capture(&failure, status);
	world_stop(world);
	world_finish(world, status);
	return status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}

enum status rig_lanes_drive(struct rig *rig, size_t soil, struct rig_lane *lanes, size_t count)
{
	struct scene *scene = NULL;
	struct sums sums[RIG_LANES_MOST * RIG_PASSES_MOST];
	for (size_t at = 0; at < count; at += RIG_LANES_MOST) {
		const size_t now = count - at < RIG_LANES_MOST ? count - at : RIG_LANES_MOST;
		memset(sums, 0, sizeof sums);
		enum status status = rig_bed_make(rig, now);
		if (status == STATUS_OK)
			status = load(rig, soil, lanes + at, now, &scene);
		if (status != STATUS_OK)
			return status;
		status = drive(rig, scene, sums, now);
		scene_destroy(scene);
		if (status != STATUS_OK)
			return status;
		for (size_t i = 0; i < now * rig->passes; i++)
			fill(rig, soil, &lanes[at + i / rig->passes], i % rig->passes, &sums[i]);
	}
	return STATUS_OK;
}
