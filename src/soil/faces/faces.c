/* Lists the facets of a body that push. */
#include "soil/faces/faces.h"

#include "soil/faces/ahead.h"
#include "soil/faces/footing.h"
#include "soil/faces/push.h"
#include "soil/faces/slid.h"
#include "soil/faces/trend.h"
#include "soil/laying/laying.h"
#include "soil/shape/body.h"

#define ROUGH (2 / 3.0)    /* friction angle along a surface of which none is given, over that of the soil: steel on sand, 0.5 to 0.8 (Potyondy 1961) */
#define FACET_POSTS 1.0    /* posts: the longest side of a facet */
#define FACET_PARTS 24     /* of the body's size: and so many parts of it, at least */

void soil_faces_finish(struct soil_faces *faces)
{
	mem_free_all(faces->memory, faces->planes);
	soil_facets_cache_finish(&faces->cache);
	*faces = (struct soil_faces){0};
}

enum { ARRAYS = 0
#define FACES_COUNT(name) + 1
	FACES_EACH(FACES_COUNT)
#undef FACES_COUNT
};

enum { PLANES_OF = 0
#define FACES_COUNT(name) + 1
	FACES_PLANES_EACH(FACES_COUNT)
#undef FACES_COUNT
};

size_t soil_faces_bytes(const struct soil_faces *faces)
{
	return (ARRAYS * faces->room + PLANES_OF * faces->posts) * sizeof(float) + soil_facets_cache_bytes(&faces->cache);
}

static enum status need(struct soil_faces *faces, size_t count)
{
	if (count <= faces->room)
		return STATUS_OK;
	const size_t room = count + count / 2;
	TRY(mem_resize(&faces->memory, ARRAYS * room, sizeof *faces->memory, "faces of a body"));
	faces->room = room;
	float *memory = faces->memory;
#define FACES_PLACE(name) faces->name = memory, memory += room;
	FACES_EACH(FACES_PLACE)
#undef FACES_PLACE
	return STATUS_OK;
}

static enum status need_posts(struct soil_faces *faces, size_t posts)
{
	if (posts > faces->posts) {
		TRY(mem_resize(&faces->planes, PLANES_OF * posts, sizeof *faces->planes, "faces of a body"));
		faces->posts = posts;
	}
	float *memory = faces->planes;
#define FACES_PLACE(name) faces->name = memory, memory += posts;
	FACES_PLANES_EACH(FACES_PLACE)
#undef FACES_PLACE
	return STATUS_OK;
}

/* Returns the most that a place of the body slides of its way. */
static float slides_most(const struct soil_form *form, double bound)
{
	const struct soil_recent *m = &form->recent;
	const float turns = sqrtf(dot3(m->turning, m->turning));
	return slid_at(form, 0, 0) + turns * (float)bound;
}

/* Gives the turn of the body's own axes into the frame: rows are forward, left, up. A rim is the same however it turns. */
static void axes_of(const struct soil_body *body, float axes[3][3])
{
	const struct soil_pose *to = &body->motion->to;
	double own[3][3];
	soil_axes(to->yaw, body->motion->shape->kind == SOIL_WHEEL ? 0 : to->pitch, to->roll, 0, own);
	for (int k = 0; k < 3; k++) {
		axes[k][0] = (float)(body->axis[0] * own[k][0] + body->axis[1] * own[k][1]);
		axes[k][1] = (float)(body->axis[0] * own[k][1] - body->axis[1] * own[k][0]);
		axes[k][2] = (float)own[k][2];
	}
}

/* Finds the soil below the body's middle. */
static struct soil_numbers soil_below(const struct soil_law *law, const struct soil_planes *planes, const struct soil_body *body)
{
	const struct post_rect *rect = &planes->rect;
	const int64_t x = (int64_t)llround(body->centre[0] / law->spacing), y = (int64_t)llround(body->centre[1] / law->spacing);
	const int64_t column = x < rect->x0 ? 0 : x >= rect->x1 ? rect->x1 - rect->x0 - 1 : x - rect->x0, row = y < rect->y0 ? 0 : y >= rect->y1 ? rect->y1 - rect->y0 - 1 : y - rect->y0;
	return soil_numbers_at(law, planes, (size_t)row * planes->width + (size_t)column);
}

static void put_soil(const struct soil_law *law, const struct soil_numbers *soil, const struct soil_trend *trend, struct soil_faces *faces)
{
	faces->xi = (float)soil_face_strength(soil);
	faces->cohesion = (float)soil_face_cohesion(soil);
	faces->unit_weight = (float)soil->unit_weight;
	faces->inertia = law->inertia > 0 && soil->density > 0 ? (float)(law->inertia * soil->density) : 0;
	faces->wedge_length = (float)tan(M_PI / 4 + soil->friction_angle / 2);
	faces->by_modulus = (float)fmin(1 / soil->janosi_shear, 1e30);
	const double plan = hypot(trend->whole.way[0], trend->whole.way[1]);
	for (int k = 0; k < 2; k++)
		faces->d[k] = plan > 1e-9 ? (float)(trend->whole.way[k] / plan) : 0;
}

/* Returns how many posts ahead of a body its own heap has ended. As far as a contact reads. */
static double beyond_of(const struct soil_shape *shape, double spacing)
{
	return M_SQRT2 * soil_laying_band(shape, spacing);
}

/* Returns how many posts around a body its faces read: as far as its own heap reaches, and one. */
static int64_t around_of(const struct soil_law *law, const struct soil_shape *shape)
{
	return 1 + (int64_t)ceil(beyond_of(shape, law->spacing));
}

/* Returns the posts at which facets, and the heap ahead, are looked up. d: where the body slides, east and north. */
static struct post_rect looked_at(struct post_rect below, const float d[2], int64_t ahead)
{
	const struct post_rect near = post_rect_grown(below, 2);
	return (struct post_rect){
		near.x0 - (int64_t)ceilf((float)ahead * most(-d[0], 0)), near.y0 - (int64_t)ceilf((float)ahead * most(-d[1], 0)),
		near.x1 + (int64_t)ceilf((float)ahead * most(d[0], 0)), near.y1 + (int64_t)ceilf((float)ahead * most(d[1], 0)),
	};
}

/* Returns the recent motion at the end of a body's motion, and puts it into the form. */
static struct soil_trend put_trend(const struct soil_law *law, const struct soil_body *body, struct soil_form *form)
{
	const struct soil_trend trend = soil_trend_after(law, body->motion);
	soil_trend_put(law, body, &trend, form);
	return trend;
}

int64_t soil_faces_reach(const struct soil_law *law, const struct soil_motion *motion)
{
	struct soil_body body;
	struct soil_form form;
	if (!law->faces || law->ground_normals)
		return 0;
	soil_form_of(law, motion, &body, &form);
	put_trend(law, &body, &form);
	/* Whether a mesh is a drum, which rolls, is known only when it is drawn. */
	return form.kind == FORM_RASTER || slides_most(&form, soil_shape_bound(motion->shape)) > SLID_LEAST ? around_of(law, motion->shape) : 0;
}

enum status soil_faces_begin(const struct soil_law *law, const struct soil_planes *planes, const struct soil_body *body, struct post_rect below, struct soil_form *form,
			     struct soil_faces *faces)
{
	const struct soil_shape *shape = body->motion->shape;
	const double bound = soil_shape_bound(shape);
	faces->count = 0;
	if (!(form->all_round > 0))
		return STATUS_OK;
	const struct soil_trend trend = put_trend(law, body, form);
	form->slides = slides_most(form, bound) > SLID_LEAST ? 1 : 0;
	if (planes == NULL || !(form->slides > 0))
		return STATUS_OK;
	const struct soil_numbers soil = soil_below(law, planes, body);
	if (soil_is_hard(&soil)) { /* nothing is pushed aside: what slides on it rubs */
		form->slides = 0;
		return STATUS_OK;
	}
	put_soil(law, &soil, &trend, faces);
	faces->beyond = (float)(beyond_of(shape, law->spacing) * law->spacing);
	const int64_t around = around_of(law, shape);
	const struct post_rect reads = post_rect_intersect(post_rect_grown(below, around), planes->rect);
	faces->rect = post_rect_intersect(looked_at(below, faces->d, around), reads);
	if (faces->rect.x1 - faces->rect.x0 < 2 || faces->rect.y1 - faces->rect.y0 < 2)
		return STATUS_OK;
	const struct soil_facets *facets;
	TRY(soil_facets_kept(&faces->cache, &body->smooth, fmin(FACET_POSTS * law->spacing, 2 * bound / FACET_PARTS), &facets));
	TRY(need(faces, facets->count));
	TRY(need_posts(faces, (size_t)(faces->rect.x1 - faces->rect.x0) * (size_t)(faces->rect.y1 - faces->rect.y0)));
	float axes[3][3];
	axes_of(body, axes);
	const struct soil_interface *interface = &body->motion->interface;
	/* The shoes of a belt grip: soil slides on soil. */
	const double rough = shape->belt ? soil.friction_angle : ROUGH * soil.friction_angle;
	const double along = fmin(interface->has_friction ? interface->friction_angle : rough, soil.friction_angle);
	soil_wedge_of(soil.friction_angle, along, &faces->wedge);
	const double plan = hypot(trend.whole.way[0], trend.whole.way[1]), way = hypot(plan, trend.whole.way[2]);
	soil_footing_of(&soil, soil_face_cohesion(&soil), tan(along), way > 0 ? plan / way : 0, &faces->footing);
	const double within = (double)(float)tan(soil.friction_angle);
	soil_push(body, form, facets, (const float(*)[3])axes, (float)(tan(along) + (double)form->bars * (within - tan(along))), faces);
	if (faces->count == 0)
		return STATUS_OK;
	soil_ahead_read(planes, law->reference, &body->motion->to, post_rect_grown(below, SOIL_FACES_KNOW), faces);
	soil_ahead_find(planes, &reads, form->spacing, faces);
	soil_ahead_body(body, form, faces);
	return STATUS_OK;
}
