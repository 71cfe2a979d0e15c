/*
 * A height field or a skin of the model that follows the ground, so that MuJoCo's viewers show ruts. The model is one for many mjData: the first that is made writes it.
 *
 * A viewer loads a height field once, and again when it is told to. It takes the vertices of a skin for each picture. So a skin follows in any viewer.
 */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plugin.h"

#define RATE 30.0 /* 1/s of simulated time: it is brought up to date so often */

struct plugin_field {
	const mjModel *model;
	int field, rows, columns;   /* of a skin: its number; 1; how many vertices it has */
	bool is_skin;
	double corner[2], apart[2]; /* m, local: of its first point; between points */
	double zero, high;          /* m, local: of what it has as 0; how much higher it has 1 */
	double time;                /* s, of the world, when it was brought up to date last */
	uint64_t revision;
	double *places;             /* room for all points */
	double *vertices;           /* of a skin: x and y of each in the terrain; */
	int *chosen;                /* room for all */
	struct furrow_point *points;
	struct furrow_rect *rects;
	size_t room;
	struct plugin_field *before; /* in the list of all */
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct plugin_field *all_fields;

static bool claim(struct plugin_field *field)
{
	bool first = true;
	pthread_mutex_lock(&lock);
	for (const struct plugin_field *one = all_fields; one != NULL; one = one->before)
		first = first && !(one->model == field->model && one->is_skin == field->is_skin && one->field == field->field);
	if (first) {
		field->before = all_fields;
		all_fields = field;
	}
	pthread_mutex_unlock(&lock);
	return first;
}

void plugin_free_field(struct plugin_field *field)
{
	if (field == NULL)
		return;
	pthread_mutex_lock(&lock);
	for (struct plugin_field **at = &all_fields; *at != NULL; at = &(*at)->before)
		if (*at == field) {
			*at = field->before;
			break;
		}
	pthread_mutex_unlock(&lock);
	free(field->places);
	free(field->vertices);
	free(field->chosen);
	free(field->points);
	free(field->rects);
	free(field);
}

static int geom_of(const mjModel *model, int field)
{
	for (int i = 0; i < model->ngeom; i++)
		if (model->geom_type[i] == mjGEOM_HFIELD && model->geom_dataid[i] == field)
			return i;
	return -1;
}

static const char *make_field(const mjModel *model, int instance, struct plugin_soil *soil, const double origin[3])
{
	const char *name = mj_getPluginConfig(model, instance, "hfield");
	if (name == NULL || name[0] == '\0')
		return NULL;
	const int number = mj_name2id(model, mjOBJ_HFIELD, name), geom = number >= 0 ? geom_of(model, number) : -1;
	if (geom < 0)
		return "hfield names no height field of the model that a geom shows; give an hfield in asset, and a geom of type hfield";
	const mjtNum *at = model->geom_pos + 3 * geom, *turn = model->geom_quat + 4 * geom, *size = model->hfield_size + 4 * number;
	if (model->geom_bodyid[geom] != 0 || fabs(turn[0]) < 1 - 1e-9)
		return "the geom of its hfield is turned, or belongs to a body that is not the world; let it lie level in worldbody";
	if (model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0)
		return "the geom of its hfield collides, so bodies would stand on it and on the soil; give it contype=\"0\" conaffinity=\"0\"";
	struct plugin_field *field = calloc(1, sizeof *field);
	if (field == NULL)
		return "no memory for its hfield";
	*field = (struct plugin_field){.model = model, .field = number, .rows = model->hfield_nrow[number], .columns = model->hfield_ncol[number],
				       .zero = origin[2] + at[2], .high = size[2]};
	const size_t count = (size_t)field->rows * (size_t)field->columns;
	field->places = malloc(2 * count * sizeof *field->places);
	field->points = malloc(count * sizeof *field->points);
	for (int k = 0; k < 2; k++) {
		field->corner[k] = origin[k] + at[k] - size[k];
		field->apart[k] = 2 * size[k] / ((k == 0 ? field->columns : field->rows) - 1);
	}
	if (field->places == NULL || field->points == NULL || field->rows < 2 || field->columns < 2 || !claim(field)) {
		plugin_free_field(field);
		return NULL;
	}
	soil->field = field;
	return NULL;
}

/* Tells whether the vertices of a skin are where the model says: its one bone is the world. */
static bool is_fixed(const mjModel *model, int skin)
{
	const int bone = model->skin_boneadr[skin];
	const float *at = model->skin_bonebindpos + 3 * bone, *turn = model->skin_bonebindquat + 4 * bone;
	return model->skin_bonenum[skin] == 1 && model->skin_bonebodyid[bone] == 0 && at[0] == 0 && at[1] == 0 && at[2] == 0 && fabsf(turn[0]) > 1 - 1e-6f;
}

static const char *make_skin(const mjModel *model, int instance, struct plugin_soil *soil, const double origin[3])
{
	const char *name = mj_getPluginConfig(model, instance, "skin");
	if (name == NULL || name[0] == '\0')
		return NULL;
	const int number = mj_name2id(model, mjOBJ_SKIN, name);
	if (number < 0)
		return "its key skin names no skin of the model; give one in deformable, whose file furrow.mujoco.write_skin makes";
	if (!is_fixed(model, number))
		return "its skin hangs on a body that is not the world; give one whose file furrow.mujoco.write_skin makes";
	struct plugin_field *field = calloc(1, sizeof *field);
	if (field == NULL)
		return "no memory for its skin";
	*field = (struct plugin_field){.model = model, .field = number, .is_skin = true, .rows = 1, .columns = model->skin_vertnum[number], .zero = origin[2], .high = 1};
	const size_t count = (size_t)field->columns;
	const float *vertex = model->skin_vert + 3 * model->skin_vertadr[number];
	field->places = malloc(2 * count * sizeof *field->places);
	field->vertices = malloc(2 * count * sizeof *field->vertices);
	field->chosen = malloc(count * sizeof *field->chosen);
	field->points = malloc(count * sizeof *field->points);
	if (field->places == NULL || field->vertices == NULL || field->chosen == NULL || field->points == NULL || !claim(field)) {
		plugin_free_field(field);
		return NULL;
	}
	for (size_t i = 0; i < 2 * count; i++)
		field->vertices[i] = origin[i % 2] + (double)vertex[3 * (i / 2) + i % 2];
	soil->skin = field;
	return NULL;
}

const char *plugin_make_fields(const mjModel *model, int instance, struct plugin_soil *soil, const double origin[3])
{
	const char *wrong = make_field(model, instance, soil, origin);
	if (wrong == NULL)
		wrong = make_skin(model, instance, soil, origin);
	if (wrong == NULL)
		plugin_follow(model, soil, true);
	return wrong;
}

/* Reads points of rows and columns from first until before end. */
static void read_points(const mjModel *model, const struct plugin_soil *soil, struct plugin_field *field, const int first[2], const int end[2])
{
	float *to = model->hfield_data + model->hfield_adr[field->field];
	size_t count = 0;
	for (int r = first[1]; r < end[1]; r++)
		for (int c = first[0]; c < end[0]; c++, count++) {
			field->places[2 * count] = field->corner[0] + c * field->apart[0];
			field->places[2 * count + 1] = field->corner[1] + r * field->apart[1];
		}
	if (count == 0)
		return;
	plugin_must(furrow_points(soil->world, count, field->places, field->points));
	count = 0;
	for (int r = first[1]; r < end[1]; r++)
		for (int c = first[0]; c < end[0]; c++, count++)
			if (isfinite(field->points[count].height))
				to[r * field->columns + c] = (float)((field->points[count].height - field->zero) / field->high);
}

/* Finds which points lie in a rectangle of posts, and a post beside it. */
static void range_of(const struct plugin_field *field, const struct furrow_rect *rect, double spacing, int first[2], int end[2])
{
	const int most[2] = {field->columns, field->rows};
	const int64_t from[2] = {rect->column, rect->row}, count[2] = {rect->columns, rect->rows};
	for (int k = 0; k < 2; k++) {
		const double low = ceil((((double)from[k] - 1) * spacing - field->corner[k]) / field->apart[k]);
		const double high = floor((((double)(from[k] + count[k]) + 1) * spacing - field->corner[k]) / field->apart[k]) + 1;
		first[k] = low > 0 ? low < most[k] ? (int)low : most[k] : 0;
		end[k] = high > 0 ? high < most[k] ? (int)high : most[k] : 0;
	}
}

/* Reads the vertices of a skin that lie in one of the first `count` rectangles of posts, or a post beside it. all: each vertex. */
static void read_vertices(const mjModel *model, const struct plugin_soil *soil, struct plugin_field *field, bool all, size_t count, double spacing)
{
	float *to = model->skin_vert + 3 * model->skin_vertadr[field->field];
	size_t chosen = 0;
	for (int i = 0; i < field->columns; i++) {
		const double *at = field->vertices + 2 * i, x = at[0] / spacing, y = at[1] / spacing;
		bool in = all;
		for (size_t r = 0; r < count && !in; r++) {
			const struct furrow_rect *rect = &field->rects[r];
			in = x >= (double)rect->column - 1 && x <= (double)(rect->column + rect->columns) + 1 && y >= (double)rect->row - 1 && y <= (double)(rect->row + rect->rows) + 1;
		}
		if (!in)
			continue;
		memcpy(field->places + 2 * chosen, at, 2 * sizeof *at);
		field->chosen[chosen++] = i;
	}
	if (chosen == 0)
		return;
	plugin_must(furrow_points(soil->world, chosen, field->places, field->points));
	for (size_t i = 0; i < chosen; i++)
		if (isfinite(field->points[i].height))
			to[3 * field->chosen[i] + 2] = (float)(field->points[i].height - field->zero);
}

/* Fills the rectangles that changed since. Returns how many. */
static size_t find_changes(const struct plugin_soil *soil, struct plugin_field *field)
{
	size_t count = field->room;
	furrow_status status;
	while ((status = furrow_changes(soil->world, field->revision, field->rects, &count, NULL)) == FURROW_USAGE && count > field->room) {
		free(field->rects);
		field->room = 2 * count;
		field->rects = calloc(field->room, sizeof *field->rects);
		if (field->rects == NULL)
			plugin_fail("no memory for its height field or skin");
		count = field->room;
	}
	plugin_must(status);
	return count;
}

static void follow(const mjModel *model, const struct plugin_soil *soil, struct plugin_field *field, bool all)
{
	struct furrow_info info = {.size = sizeof info};
	const double time = furrow_time(soil->world);
	all = all || time < field->time; /* the world went back */
	if (!all && time < field->time + 1 / RATE)
		return;
	field->time = time;
	plugin_must(furrow_info(soil->world, &info));
	const size_t count = all ? 0 : find_changes(soil, field);
	field->revision = info.revision;
	if (field->is_skin) {
		read_vertices(model, soil, field, all, count, info.spacing);
		return;
	}
	if (all)
		read_points(model, soil, field, (const int[]){0, 0}, (const int[]){field->columns, field->rows});
	for (size_t i = 0; i < count; i++) {
		int first[2], end[2];
		range_of(field, &field->rects[i], info.spacing, first, end);
		read_points(model, soil, field, first, end);
	}
}

void plugin_follow(const mjModel *model, const struct plugin_soil *soil, bool all)
{
	if (soil->field != NULL)
		follow(model, soil, soil->field, all);
	if (soil->skin != NULL)
		follow(model, soil, soil->skin, all);
}
