/*
 * The truth: the same wheel over the same function in doubles (deform/reference), posts and stations 1/64 m apart, and
 * how far a surface is from that.
 *
 * What else differs between a drive and its truth, and so is in the error too:
 *   - the base: a store holds it in steps of its import error, and between its posts it is bilinear; here it is the
 *     function, at every post of 1/64 m.
 *   - heights of stations: the product sets the wheel `sink` below its own base, bilinear; here below the function.
 *   - the way: from station to station the wheel moves straight with the attitude of the later one, so where stations
 *     are far apart it cuts bends.
 *   - sliding: here all around the wheel slides after each sweep until nothing moves by more than 1e-6 m, or so often
 *     (SWEEP_MOST), and everything to rest at the end. The product slides `iterations` times a sweep and an interval,
 *     so soil comes to rest behind the wheel; it is given ACCURACY_REST intervals after the end.
 *   - a mound depends a little on the order in which soil slid: two ways of coming to rest end at the same slope, not
 *     at the same posts.
 *   - the box filter looks so many posts far: it is another filter at every spacing. Its truth is that of 1/64 m posts.
 * Nothing is nodata, nothing is near the world's edge.
 *
 * The sweeps' undersides do not depend on the ground: they are found once for all models.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accuracy.h"
#include "bench.h"
#include "deform/reference/reference.h"
#include "soil/kinematic/contact.h"

#define SWEEP_MOST 400   /* iterations after a sweep */
#define REST_MOST 20000  /* at the end */
#define TOLERANCE 1e-6   /* m */
#define ROUND 0.32       /* m around the wheel that a sweep changes: where its soil can come to rest at once */
#define KIND "furrow accuracy truth"
#define MARGIN 16        /* posts of the field along its sides that are not compared */

const struct post_rect accuracy_field = {800, 688, 1121, 1009}; /* 12.5 .. 17.5, 10.75 .. 15.75 m */

/* Those that there is a truth of. Soil that bears has closed forms: bench/validation.c. */
static const enum deform_model models[] = {DEFORM_NONE, DEFORM_BOX_FILTER, DEFORM_SUMNER, DEFORM_SLIPPAGE, DEFORM_SHEET};
#define MODELS (sizeof models / sizeof models[0])

static int64_t columns(void)
{
	return accuracy_field.x1 - accuracy_field.x0;
}

static size_t field_posts(void)
{
	return (size_t)(columns() * (accuracy_field.y1 - accuracy_field.y0));
}

/* One sweep as all models see it: the posts around the wheel. */
struct sweep {
	struct deform_contact sweep;
	struct post_rect rect; /* global posts */
	double *under, *rest;
};

static size_t rect_posts(struct post_rect rect)
{
	return (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
}

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = ACCURACY_RADIUS, .width = ACCURACY_WIDTH};

static struct soil_pose pose_at(const struct track *track, int64_t sample)
{
	struct track_point point;
	motion_track_sample(track, sample, &point);
	double ground = accuracy_height(lattice_offset_metres(point.qx), lattice_offset_metres(point.qy));
	return (struct soil_pose){.x = point.qx, .y = point.qy, .z = lattice_offset(ground + ACCURACY_RADIUS - ACCURACY_SINK),
				  .yaw = point.yaw};
}

/* The wheel's plan, and where it came from, with room to spare: elsewhere it is not above the post. */
static bool may_be_above(const struct deform_contact *sweep, double x, double y)
{
	double c = cos(sweep->to.yaw), s = sin(sweep->to.yaw);
	double dx = x - lattice_offset_metres(sweep->to.x), dy = y - lattice_offset_metres(sweep->to.y);
	double way = hypot(lattice_offset_metres(sweep->to.x - sweep->from.x), lattice_offset_metres(sweep->to.y - sweep->from.y));
	return fabs(dx * c + dy * s) < ACCURACY_RADIUS + way + 1e-3 && fabs(dy * c - dx * s) < ACCURACY_WIDTH / 2 + way + 1e-3;
}

static double underside(const struct deform_contact *sweep, double x, double y)
{
	long double z;
	if (!reference_underside(sweep, (long double)x - lattice_offset_metres(sweep->from.x),
				 (long double)y - lattice_offset_metres(sweep->from.y), &z))
		return INFINITY;
	return (double)((long double)lattice_offset_metres(sweep->from.z) + z);
}

static void find_undersides(struct sweep *sweep)
{
	double reach = hypot(ACCURACY_RADIUS, ACCURACY_WIDTH / 2) + ROUND;
	double x = lattice_offset_metres(sweep->sweep.to.x), y = lattice_offset_metres(sweep->sweep.to.y);
	struct post_rect around = {(int64_t)floor((x - reach) / ACCURACY_FINE), (int64_t)floor((y - reach) / ACCURACY_FINE),
				   (int64_t)ceil((x + reach) / ACCURACY_FINE) + 1, (int64_t)ceil((y + reach) / ACCURACY_FINE) + 1};
	sweep->rect = post_rect_intersect(around, accuracy_field);
	if (memcmp(&around, &sweep->rect, sizeof around) != 0)
		bench_must(fail_with(STATUS_FAILED, "bench: the path comes too near to the field's edge; make the field larger"));
	size_t count = rect_posts(around);
	sweep->under = mem_alloc(count, sizeof *sweep->under);
	sweep->rest = mem_alloc(count, sizeof *sweep->rest);
	if (sweep->under == NULL || sweep->rest == NULL)
		bench_must(fail_memory("bench"));
	struct deform_contact end = sweep->sweep;
	end.from = end.to;
	size_t i = 0;
	for (int64_t row = around.y0; row < around.y1; row++)
		for (int64_t column = around.x0; column < around.x1; column++, i++) {
			double px = (double)column * ACCURACY_FINE, py = (double)row * ACCURACY_FINE;
			bool near = may_be_above(&sweep->sweep, px, py);
			sweep->under[i] = near ? underside(&sweep->sweep, px, py) : (double)INFINITY;
			sweep->rest[i] = near ? underside(&end, px, py) : (double)INFINITY;
		}
}

/* A reference ground of that rectangle; its posts brought from the field, or back to it. */
static void bring(const struct reference_ground *field, const struct reference_ground *part, struct post_rect rect, bool back)
{
	double *const whole[] = {field->base, field->offset};
	double *const cut[] = {part->base, part->offset};
	size_t width = (size_t)(rect.x1 - rect.x0);
	for (size_t k = 0; k < sizeof whole / sizeof whole[0]; k++)
		for (int64_t y = rect.y0; y < rect.y1; y++) {
			double *there = whole[k] + (y - accuracy_field.y0) * columns() + rect.x0 - accuracy_field.x0;
			double *here = cut[k] + (size_t)(y - rect.y0) * width;
			memcpy(back ? there : here, back ? here : there, width * sizeof(double));
		}
}

static void box(struct reference_ground *ground, const struct sweep *sweep)
{
	const size_t count = rect_posts(sweep->rect), width = (size_t)ground->width, height = (size_t)ground->height;
	const struct soil_kinematic once = {.radius = 1, .repetitions = 1};
	struct soil_planes planes = {.rect = {0, 0, ground->width, ground->height}, .width = width, .offset = mem_alloc(count, sizeof(int32_t)),
				     .contact = ground->contact};
	void *scratch = mem_alloc(1, soil_smooth_room(width, height, once.radius));
	if (planes.offset == NULL || scratch == NULL)
		bench_must(fail_memory("bench"));
	reference_none(ground, sweep->under, sweep->rest);
	for (size_t i = 0; i < count; i++)
		planes.offset[i] = (int32_t)lattice_offset(ground->offset[i]);
	soil_smooth(&once, &planes, (struct smooth_posts){0, 0, ground->width, ground->height}, scratch);
	for (size_t i = 0; i < count; i++)
		ground->offset[i] = lattice_offset_metres(planes.offset[i]);
	mem_free(planes.offset);
	mem_free(scratch);
}

static struct deform_params params_of(enum deform_model model)
{
	struct deform_params params = {.model = model, .soil_count = 1, .depth = deform_model_row(model)->depth};
	bench_must(soil_named("dry_sand", &params.soils[0]));
	params.soils[0].cohesion = 0;
	params.soils[0].compression = 0.3; /* as when the figures were measured: sumner lays 0.7 of what is pressed */
	return params;
}

static void press(struct reference_ground *ground, const struct deform_params *params, const struct sweep *sweep)
{
	struct reference_laying laying;
	double moved;
	switch (params->model) {
	case DEFORM_NONE:
		reference_none(ground, sweep->under, sweep->rest);
		return;
	case DEFORM_BOX_FILTER:
		box(ground, sweep);
		return;
	case DEFORM_SUMNER:
		reference_sumner(ground, &params->soils[0], sweep->under, sweep->rest);
		break;
	default:
		reference_slippage(ground, sweep->under, sweep->rest);
		break;
	}
	bench_must(reference_spread(ground, params, &sweep->sweep, &laying));
	bench_must(reference_slide(ground, params, SWEEP_MOST, TOLERANCE, &moved));
}

/* One model's drive over the field. A thread's. */
struct work {
	enum deform_model model;
	const struct sweep *sweeps;
	size_t count;
	double *surface;
	double moved; /* by the last iteration at the end */
	struct thread thread;
};

/* A drive over the sheet. */
static void bend(const struct reference_ground *field, struct work *work)
{
	memcpy(work->surface, field->base, field_posts() * sizeof *work->surface);
	for (size_t i = 0; i < work->count; i++)
		accuracy_sheet(work->surface, field->base, &(struct accuracy_press){work->sweeps[i].rect, work->sweeps[i].under}, false);
	const struct sweep *last = &work->sweeps[work->count - 1];
	accuracy_sheet(work->surface, field->base, &(struct accuracy_press){last->rect, last->rest}, true);
}

static void *drive(void *argument)
{
	struct work *work = argument;
	const struct deform_params params = params_of(work->model);
	struct reference_ground field, part;
	bench_must(reference_ground_init(&field, (int)columns(), (int)(accuracy_field.y1 - accuracy_field.y0), ACCURACY_FINE));
	field.left = accuracy_field.x0;
	field.bottom = accuracy_field.y0;
	for (size_t i = 0; i < field_posts(); i++)
		field.base[i] = accuracy_height((double)(field.left + (int64_t)i % columns()) * ACCURACY_FINE,
						(double)(field.bottom + (int64_t)i / columns()) * ACCURACY_FINE);
	if (work->model == DEFORM_SHEET) {
		bend(&field, work);
		reference_ground_finish(&field);
		return NULL;
	}
	for (size_t i = 0; i < work->count; i++) {
		const struct sweep *sweep = &work->sweeps[i];
		bench_must(reference_ground_init(&part, (int)(sweep->rect.x1 - sweep->rect.x0),
						 (int)(sweep->rect.y1 - sweep->rect.y0), ACCURACY_FINE));
		part.left = sweep->rect.x0;
		part.bottom = sweep->rect.y0;
		bring(&field, &part, sweep->rect, false);
		press(&part, &params, sweep);
		bring(&field, &part, sweep->rect, true);
		for (size_t k = 0; i == work->count - 1 && k < rect_posts(sweep->rect); k++)
			field.contact[(part.bottom + (int64_t)k / part.width - field.bottom) * columns() + part.left +
				      (int64_t)k % part.width - field.left] = part.contact[k];
		reference_ground_finish(&part);
	}
	if (deform_conserves(work->model))
		bench_must(reference_slide(&field, &params, REST_MOST, TOLERANCE, &work->moved));
	for (size_t i = 0; i < field_posts(); i++)
		work->surface[i] = field.base[i] + field.offset[i];
	reference_ground_finish(&field);
	return NULL;
}

static bool is_made(const struct accuracy_truth *truth, size_t m)
{
	return truth->surfaces[models[m]] != NULL;
}

static void make(struct accuracy_truth *truth)
{
	struct scene *scene = accuracy_scene(DEFORM_SLIPPAGE, 1, NULL, 0);
	struct track *track = accuracy_track(scene, ACCURACY_FINE);
	size_t count = (size_t)motion_track_samples(track);
	struct sweep *sweeps = mem_calloc(count, sizeof *sweeps);
	struct work works[MODELS];
	if (sweeps == NULL)
		bench_must(fail_memory("bench"));
	double began = clock_seconds();
	for (size_t i = 0; i < count; i++) {
		struct soil_pose to = pose_at(track, (int64_t)i), from = i > 0 ? sweeps[i - 1].sweep.to : to;
		double seconds = i > 0 ? motion_track_sample_time(track, (int64_t)i) - motion_track_sample_time(track, (int64_t)i - 1) : 0;
		double way = lattice_offset_metres(to.x - from.x) * cos(to.yaw) + lattice_offset_metres(to.y - from.y) * sin(to.yaw);
		sweeps[i].sweep = (struct deform_contact){.shape = &wheel, .from = from, .to = to, .seconds = seconds,
							.turned = way / ACCURACY_RADIUS};
		find_undersides(&sweeps[i]);
	}
	fprintf(stderr, "truth: %zu stations, undersides in %.0f s\n", count, clock_seconds() - began);
	for (size_t m = 0; m < MODELS; m++) {
		if (!is_made(truth, m))
			continue;
		works[m] = (struct work){.model = models[m], .sweeps = sweeps, .count = count, .surface = truth->surfaces[models[m]]};
		bench_must(thread_start(&works[m].thread, drive, &works[m], "truth"));
	}
	for (size_t m = 0; m < MODELS; m++) {
		if (!is_made(truth, m))
			continue;
		thread_join(&works[m].thread);
		fprintf(stderr, "truth: %s after %.0f s, last moved by %g m\n", accuracy_model_name(works[m].model),
			clock_seconds() - began, works[m].moved);
	}
	for (size_t i = 0; i < count; i++) {
		mem_free(sweeps[i].under);
		mem_free(sweeps[i].rest);
	}
	mem_free(sweeps);
	motion_track_destroy(track);
	scene_destroy(scene);
}

/* The file: this text to its end of line, then the surfaces as doubles of this machine. */
static const char *header(void)
{
	static char text[1600];
	snprintf(text, sizeof text, KIND " 3: %lld .. %lld x %lld .. %lld at 1/64 m; %d iterations a sweep within %g m, "
				    "%d at the end, until %g m; models none box sumner slippage, sheet %g %g %g; %s\n",
		 (long long)accuracy_field.x0, (long long)accuracy_field.x1, (long long)accuracy_field.y0, (long long)accuracy_field.y1,
		 SWEEP_MOST, ROUND, REST_MOST, TOLERANCE, ACCURACY_TENSION, ACCURACY_STIFFNESS, ACCURACY_YIELD, accuracy_described());
	return text;
}

static bool load(struct accuracy_truth *truth, const char *path)
{
	char text[1600] = "";
	FILE *file = fopen(path, "rb");
	bool whole = file != NULL && fgets(text, sizeof text, file) != NULL && strcmp(text, header()) == 0;
	if (file != NULL && strncmp(text, KIND, strlen(KIND)) != 0)
		bench_must(fail_with(STATUS_INPUT, "%s: is no truth, and would be overwritten; name another file", path));
	for (size_t m = 0; m < MODELS && whole; m++)
		whole = fread(truth->surfaces[models[m]], sizeof(double), field_posts(), file) == field_posts();
	if (file != NULL)
		fclose(file);
	return whole;
}

static void save(const struct accuracy_truth *truth, const char *path)
{
	FILE *file = fopen(path, "wb");
	bool whole = file != NULL && fputs(header(), file) >= 0;
	for (size_t m = 0; m < MODELS && whole; m++)
		whole = fwrite(truth->surfaces[models[m]], sizeof(double), field_posts(), file) == field_posts();
	if (file == NULL || fclose(file) != 0 || !whole)
		bench_must(fail_with(STATUS_FAILED, "%s: cannot be written; name another file", path));
}

void accuracy_truth_open(struct accuracy_truth *truth, const char *path, unsigned wanted)
{
	*truth = (struct accuracy_truth){{NULL}};
	if (!(accuracy_steepest() < tan(params_of(DEFORM_SLIPPAGE).soils[0].friction_angle)))
		bench_must(fail_with(STATUS_FAILED, "bench: undisturbed ground would slide; make it less steep"));
	for (size_t m = 0; m < MODELS; m++) {
		if ((wanted >> models[m] & 1) == 0)
			continue;
		truth->surfaces[models[m]] = mem_alloc(field_posts(), sizeof(double));
		if (truth->surfaces[models[m]] == NULL)
			bench_must(fail_memory("bench"));
	}
	const bool keeps = path != NULL && wanted == ACCURACY_EVERY;
	if (keeps && load(truth, path))
		return;
	make(truth);
	if (keeps)
		save(truth, path);
}

void accuracy_truth_close(struct accuracy_truth *truth)
{
	for (int model = 0; model < DEFORM_MODELS; model++)
		mem_free(truth->surfaces[model]);
}

struct post_rect accuracy_rect(double spacing)
{
	double part = ACCURACY_FINE / spacing;
	return (struct post_rect){(int64_t)floor((double)accuracy_field.x0 * part), (int64_t)floor((double)accuracy_field.y0 * part),
				  (int64_t)ceil((double)accuracy_field.x1 * part) + 1,
				  (int64_t)ceil((double)accuracy_field.y1 * part) + 1};
}

static double height_at(const struct accuracy_surface *surface, double x, double y)
{
	double px = x / surface->spacing - (double)surface->rect.x0, py = y / surface->spacing - (double)surface->rect.y0;
	int64_t cx = (int64_t)floor(px), cy = (int64_t)floor(py), width = surface->rect.x1 - surface->rect.x0;
	double u = px - (double)cx, v = py - (double)cy;
	const double *corner = surface->heights + cy * width + cx;
	return (1 - v) * ((1 - u) * corner[0] + u * corner[1]) + v * ((1 - u) * corner[width] + u * corner[width + 1]);
}

struct accuracy_error accuracy_compare(const double *truth, const struct accuracy_surface *surface)
{
	struct accuracy_error error = {0};
	double squares = 0, net = 0, both = 0;
	int64_t count = 0;
	for (int64_t y = accuracy_field.y0 + MARGIN; y < accuracy_field.y1 - MARGIN; y++)
		for (int64_t x = accuracy_field.x0 + MARGIN; x < accuracy_field.x1 - MARGIN; x++, count++) {
			double there = truth[(y - accuracy_field.y0) * columns() + x - accuracy_field.x0];
			double off = height_at(surface, (double)x * ACCURACY_FINE, (double)y * ACCURACY_FINE) - there;
			error.max = fmax(error.max, fabs(off));
			squares += off * off;
			net += off;
			both += fabs(off);
		}
	error.rms = sqrt(squares / (double)count);
	error.volume = net * ACCURACY_FINE * ACCURACY_FINE;
	error.volume_abs = both * ACCURACY_FINE * ACCURACY_FINE;
	return error;
}
