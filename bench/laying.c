/*
 * Measures the laying of displaced soil on the CPU, one thread: ns a post of the window to add up what a contact displaced, and to lay it.
 * Prints a JSON line for each body, motion and spacing.
 *
 *     bench_laying [ROUNDS]      default 2000
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "soil/laying/laying.h"
#include "soil/shape/body.h"

#define BY 6 /* posts around what is laid, for soil that slides */

struct motion {
	const char *body, *name;
	struct soil_shape shape;
	double way[3]; /* m: forwards, to the left, up; of a tenth of the radius or so */
	double slip;
};

static const struct motion motions[] = {
	{"wheel", "rolls", {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4}, {1, 0, 0}, 0},
	{"wheel", "locked", {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4}, {1, 0, 0}, 1},
	{"wheel", "slides aside", {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4}, {1, 0.2, 0}, 0},
	{"box", "pushes", {.kind = SOIL_BOX, .size = {1, 0.8, 0.5}}, {1, 0, 0}, 0},
	{"sphere", "set down", {.kind = SOIL_SPHERE, .radius = 0.5}, {0, 0, 0}, 0},
};

struct field {
	struct soil_planes planes;
	struct post_rect shadow;
	int32_t *carried, *deposits;
	void *scratch;
};

/* The middle of the shadow is 5 cm deep. */
static void fill(struct field *field, const struct soil_laying *laying, const struct motion *motion, const struct soil_pose *to, double spacing)
{
	double extent[2];
	soil_body_extent(&motion->shape, to, extent);
	const double x = lattice_offset_metres(to->x) / spacing, y = lattice_offset_metres(to->y) / spacing;
	field->shadow = (struct post_rect){(int64_t)floor(x - extent[0] / spacing), (int64_t)floor(y - extent[1] / spacing),
					   (int64_t)ceil(x + extent[0] / spacing) + 1, (int64_t)ceil(y + extent[1] / spacing) + 1};
	struct post_rect rect = soil_laying_posts(laying, &motion->shape, to, spacing, field->shadow);
	rect = (struct post_rect){rect.x0 - BY, rect.y0 - BY, rect.x1 + BY, rect.y1 + BY};
	const size_t width = (size_t)(rect.x1 - rect.x0), posts = width * (size_t)(rect.y1 - rect.y0);
	field->planes = (struct soil_planes){.rect = rect, .width = width};
	field->planes.base = calloc(posts, 4);
	field->planes.offset = calloc(posts, 4);
	field->planes.contact = calloc(posts, 1);
	field->carried = calloc(posts, 4);
	field->deposits = calloc(posts, 4);
	field->scratch = malloc(soil_lay_scratch(width, posts / width));
	const double c = cos(to->yaw), s = sin(to->yaw), half = motion->shape.kind == SOIL_WHEEL ? motion->shape.width / 2 : 0.35;
	for (size_t i = 0; i < posts; i++) {
		const double east = (double)(rect.x0 + (int64_t)(i % width)) * spacing - lattice_offset_metres(to->x);
		const double north = (double)(rect.y0 + (int64_t)(i / width)) * spacing - lattice_offset_metres(to->y);
		const double along = east * c + north * s, aside = north * c - east * s;
		const bool touched = motion->shape.kind == SOIL_SPHERE ? hypot(along, aside) < 0.22 : fabs(along) < 0.22 && fabs(aside) < half;
		field->planes.contact[i] = touched ? SOIL_LOWERED | SOIL_HELD : 0;
		field->planes.offset[i] = touched ? -lattice_offset(0.05) : 0;
		field->carried[i] = touched ? lattice_offset(0.002) : 0;
	}
}

static void measure(const struct field *field, const struct soil_laying *laying, const struct soil_laid *soils, struct soil_measured *measured)
{
	soil_measured_begin(measured);
	for (int64_t y = field->shadow.y0; y < field->shadow.y1; y++) {
		const size_t at = (size_t)(y - field->planes.rect.y0) * field->planes.width + (size_t)(field->shadow.x0 - field->planes.rect.x0);
		const struct soil_row row = {.x = field->shadow.x0, .y = y, .count = (int)(field->shadow.x1 - field->shadow.x0),
					     .contact = field->planes.contact + at, .carried = field->carried + at, .offset = field->planes.offset + at};
		soil_measure_row(measured, laying, soils, &row);
	}
}

static void of_motion(const struct motion *motion, double spacing, int rounds)
{
	const double heading = 0.3, step = fmin(spacing, 0.05), radius = motion->shape.radius > 0 ? motion->shape.radius : 1;
	const struct soil_pose from = {.x = lattice_offset(100.013), .y = lattice_offset(100.029), .yaw = heading};
	struct soil_pose to = from;
	to.x += lattice_offset(step * (motion->way[0] * cos(heading) - motion->way[1] * sin(heading)));
	to.y += lattice_offset(step * (motion->way[0] * sin(heading) + motion->way[1] * cos(heading)));
	const struct soil_laid soils[SOIL_CLASSES] = {soil_laid_of(0.5, 0.5, spacing)};
	const double turned = motion->way[0] * step / radius * (1 - motion->slip);
	struct soil_laying laying = soil_laying_of(&motion->shape, &from, &to, turned, NULL, spacing);
	struct soil_measured measured;
	struct soil_lay_result result;
	struct field field;
	fill(&field, &laying, motion, &to, spacing);
	double *us[3];
	for (int k = 0; k < 3; k++)
		us[k] = malloc((size_t)rounds * sizeof **us);
	for (int i = 0; i < rounds; i++) {
		const double began = clock_seconds();
		laying = soil_laying_of(&motion->shape, &from, &to, turned, NULL, spacing);
		const double told = clock_seconds();
		measure(&field, &laying, soils, &measured);
		const double counted = clock_seconds();
		soil_lay(&laying, &measured, soils, &field.planes, field.planes.contact, NULL, field.planes.rect, field.scratch, field.deposits, &result);
		us[0][i] = (told - began) * 1e6;
		us[1][i] = (counted - told) * 1e6;
		us[2][i] = (clock_seconds() - counted) * 1e6;
	}
	size_t laid = 0;
	const size_t posts = field.planes.width * (size_t)(field.planes.rect.y1 - field.planes.rect.y0);
	for (size_t i = 0; i < posts; i++)
		laid += field.deposits[i] > 0;
	const double of = bench_median(us[0], (size_t)rounds), sums = bench_median(us[1], (size_t)rounds), lays = bench_median(us[2], (size_t)rounds);
	printf("{\"bench\": \"laying\", \"body\": \"%s\", \"motion\": \"%s\", \"spacing\": %g, \"window\": [%zu, %zu], \"posts_laid_on\": %zu, "
	       "\"rule_us\": %.2f, \"measure_us\": %.2f, \"lay_us\": %.2f, \"ns_a_post\": %.2f}\n",
	       motion->body, motion->name, spacing, field.planes.width, posts / field.planes.width, laid, of, sums, lays,
	       (sums + lays) * 1e3 / (double)posts);
	for (int k = 0; k < 3; k++)
		free(us[k]);
	free(field.planes.base);
	free(field.planes.offset);
	free(field.planes.contact);
	free(field.carried);
	free(field.deposits);
	free(field.scratch);
}

int main(int argc, char **argv)
{
	static const double spacings[] = {0.125, 0.04, 0.02, 0.01};
	const int rounds = argc > 1 ? atoi(argv[1]) : 2000;
	if (rounds < 1)
		return 2;
	for (size_t i = 0; i < sizeof motions / sizeof *motions; i++)
		for (int k = 0; k < 4; k++)
			of_motion(&motions[i], spacings[k], rounds);
	return 0;
}
