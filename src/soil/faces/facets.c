/* Makes the facets of a body: see facets.h. */
#include "soil/faces/facets_making.h"

#include <assert.h>

#include "soil/shape/body.h"

#define HALVINGS 7 /* of the range in which the least size is that gives few enough facets: within a hundredth of it */

void soil_facets_put(struct facets_making *m, const double at[3], const double vector[3], enum soil_facet_kind kind)
{
	const double area = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
	if (!((float)area > 0))
		return;
	if (m->gather != NULL) {
		m->count += soil_facets_gather_add(m->gather, m->size, at, vector, kind) ? 1 : 0;
		return;
	}
	const size_t i = m->count++;
	struct soil_facets *f = m->into;
	if (f == NULL || i >= f->room)
		return;
	f->x[i] = (float)at[0];
	f->y[i] = (float)at[1];
	f->z[i] = (float)at[2];
	f->nx[i] = (float)(vector[0] / area);
	f->ny[i] = (float)(vector[1] / area);
	f->nz[i] = (float)(vector[2] / area);
	f->area[i] = (float)area;
	f->kind[i] = (uint8_t)kind;
}

void soil_facets_put_rectangle(struct facets_making *m, const double middle[3], const double half[2][3], enum soil_facet_kind kind)
{
	int parts[2];
	for (int k = 0; k < 2; k++)
		parts[k] = facets_parts(2 * sqrt(half[k][0] * half[k][0] + half[k][1] * half[k][1] + half[k][2] * half[k][2]), m->size);
	double vector[3];
	for (int k = 0; k < 3; k++) {
		const int a = (k + 1) % 3, b = (k + 2) % 3;
		vector[k] = 4 * (half[0][a] * half[1][b] - half[0][b] * half[1][a]) / parts[0] / parts[1];
	}
	for (int i = 0; i < parts[0] && !facets_full(m); i++)
		for (int j = 0; j < parts[1]; j++) {
			const double u = (2 * i + 1.0) / parts[0] - 1, v = (2 * j + 1.0) / parts[1] - 1;
			const double at[3] = {middle[0] + u * half[0][0] + v * half[1][0], middle[1] + u * half[0][1] + v * half[1][1],
					      middle[2] + u * half[0][2] + v * half[1][2]};
			soil_facets_put(m, at, vector, kind);
		}
}

static void put_box(struct facets_making *m)
{
	for (int k = 0; k < 3; k++)
		for (int side = -1; side <= 1; side += 2) {
			double middle[3] = {0}, half[2][3] = {{0}};
			const int a = (k + 1) % 3, b = (k + 2) % 3;
			middle[k] = side * m->shape->size[k] / 2;
			half[0][a] = side * m->shape->size[a] / 2;
			half[1][b] = m->shape->size[b] / 2;
			soil_facets_put_rectangle(m, middle, (const double(*)[3])half, k == 2 ? FACET_UNDER : FACET_SIDE);
		}
}

static void put_shape(struct facets_making *m)
{
	const struct soil_shape *s = m->shape;
	const double ball[3] = {s->radius, s->radius, s->radius};
	m->count = 0;
	switch (s->kind) {
	case SOIL_WHEEL:
		soil_facets_put_drum(m, 1, s->radius, s->width);
		break;
	case SOIL_CYLINDER:
		soil_facets_put_drum(m, 2, s->radius, s->length);
		break;
	case SOIL_SPHERE:
	case SOIL_CAPSULE:
		soil_facets_put_ball(m, ball, s->kind == SOIL_CAPSULE ? s->length : 0);
		break;
	case SOIL_ELLIPSOID:
		soil_facets_put_ball(m, s->size, 0);
		break;
	case SOIL_BOX:
		put_box(m);
		break;
	case SOIL_MESH:
		soil_facets_put_mesh(m);
		break;
	case SOIL_SHAPES:
		break;
	}
}

/* Counts the facets of a size. */
static size_t count_of(struct facets_making *m, double size)
{
	m->size = size;
	if (m->gather != NULL)
		soil_facets_gather_clear(m->gather);
	put_shape(m);
	return m->count;
}

/* Finds the size, as near to the one that is asked for as the most facets allow, and counts the facets. */
static size_t choose_size(struct facets_making *m, double asked)
{
	const double size = fmax(asked, FACETS_LEAST * soil_shape_bound(m->shape));
	if (count_of(m, size) <= SOIL_FACETS_MOST)
		return m->count;
	double many = size, few = size;
	do {
		many = few;
		few *= 2;
	} while (count_of(m, few) > SOIL_FACETS_MOST);
	for (int i = 0; i < HALVINGS; i++) {
		const double middle = sqrt(many * few);
		*(count_of(m, middle) > SOIL_FACETS_MOST ? &many : &few) = middle;
	}
	return count_of(m, few);
}

/* Fills in the box around a body, and how far it reaches. */
static void put_bounds(const struct soil_shape *s, struct soil_facets *facets)
{
	const double r = s->radius;
	double high[3] = {r, r, r};
	facets->reach = soil_shape_bound(s);
	if (s->kind == SOIL_WHEEL) {
		high[1] = s->width / 2;
	} else if (s->kind == SOIL_CYLINDER || s->kind == SOIL_CAPSULE) {
		high[2] = s->length / 2 + (s->kind == SOIL_CAPSULE ? r : 0);
	}
	for (int k = 0; k < 3; k++) {
		if (s->kind == SOIL_BOX || s->kind == SOIL_ELLIPSOID)
			high[k] = s->kind == SOIL_BOX ? s->size[k] / 2 : s->size[k];
		facets->low[k] = s->kind == SOIL_MESH ? s->mesh->low[k] : -high[k];
		facets->high[k] = s->kind == SOIL_MESH ? s->mesh->high[k] : high[k];
	}
}

static enum status make_room(struct soil_facets *facets, size_t count)
{
	const size_t lanes = SOIL_FACETS_LANES, room = (count + lanes - 1) / lanes * lanes;
	TRY(mem_zeroed(&facets->memory, room, 7 * sizeof(float) + 1, "a body's facets"));
	float **all[] = {&facets->x, &facets->y, &facets->z, &facets->nx, &facets->ny, &facets->nz, &facets->area};
	for (size_t k = 0; k < sizeof all / sizeof *all; k++)
		*all[k] = (float *)facets->memory + k * room;
	facets->kind = (uint8_t *)(facets->area + room);
	facets->room = room;
	for (size_t i = 0; i < room; i++)
		facets->nz[i] = 1;
	return STATUS_OK;
}

static enum status make(struct facets_making *m, double size, struct soil_facets *facets)
{
	const size_t count = choose_size(m, size);
	TRY(make_room(facets, count > 0 ? count : 1));
	facets->size = m->size;
	facets->gathered = m->gather != NULL;
	m->into = facets;
	m->count = 0;
	if (m->gather != NULL)
		soil_facets_gather_put(m->gather, m);
	else
		put_shape(m);
	assert(m->count == count);
	facets->count = count;
	put_bounds(m->shape, facets);
	return STATUS_OK;
}

enum status soil_facets_of(const struct soil_shape *shape, double size, struct soil_facets *facets)
{
	struct facets_making m = {.shape = shape};
	struct facets_mesh *mesh = NULL;
	enum status status;
	bool many = false;
	assert(size > 0);
	soil_facets_finish(facets);
	if (shape->kind == SOIL_MESH)
		TRY_OR(done, soil_facets_mesh_begin(shape->mesh, size, &mesh, &facets->both, &many));
	m.mesh = mesh;
	if (many)
		TRY_OR(done, soil_facets_gather_create(&m.gather));
	TRY_OR(done, make(&m, size, facets));
done:
	soil_facets_mesh_end(mesh);
	soil_facets_gather_destroy(m.gather);
	if (status != STATUS_OK)
		soil_facets_finish(facets);
	return status;
}

void soil_facets_finish(struct soil_facets *facets)
{
	mem_free(facets->memory);
	*facets = (struct soil_facets){0};
}

size_t soil_facets_bytes(const struct soil_facets *facets)
{
	return facets->room * (7 * sizeof(float) + 1);
}
