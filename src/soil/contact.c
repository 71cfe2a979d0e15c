/* A body on the ground, as contacts and probes evaluate the law of the soil. */
#include "soil/contact.h"

enum status soil_work_create(struct soil_work **out)
{
	return mem_zeroed(out, 1, sizeof **out, "bearing soil");
}

void soil_work_destroy(struct soil_work *work)
{
	if (work == NULL)
		return;
	soil_posts_finish(&work->posts);
	soil_faces_finish(&work->faces);
	soil_fine_finish(&work->fine);
	soil_grousers_finish(&work->grousers);
	mem_free_all(work->kept.more, work->met, work->seen, work->abuts, work);
}

size_t soil_work_bytes(const struct soil_work *work)
{
	return sizeof *work + soil_posts_bytes(&work->posts) + soil_faces_bytes(&work->faces) + 5 * work->kept_room * sizeof(float) + work->fine.room + soil_surfaces_bytes(&work->fine.surfaces) +
	       work->grousers.room * sizeof(float) + work->met_room * (sizeof *work->met + sizeof *work->seen + sizeof *work->abuts);
}

static enum status need(struct soil_work *work, struct post_rect below)
{
	const size_t count = (size_t)(below.x1 - below.x0) * (size_t)(below.y1 - below.y0);
	TRY(soil_posts_need(&work->posts, count));
	if (work->kept_room >= work->posts.capacity)
		return STATUS_OK;
	const size_t room = work->posts.capacity;
	float *memory = mem_realloc(work->kept.more, 5 * room, sizeof *memory);
	TRY_MEM(memory, "bearing soil");
	work->kept = (struct soil_kept){memory, memory + room, memory + 2 * room, memory + 3 * room, memory + 4 * room};
	work->kept_room = room;
	return STATUS_OK;
}

/* --- the width of the contact patch --- */

/* The same of a cylinder: between a level wheel and a round plate. up: of its axis. */
static double width_of_round(double up, double width, double radius)
{
	return (1 - up * up) / width + up * up / radius;
}

/* Returns 1 / b, b the width of the contact patch, 1/m. 0: it follows from the area that the body touches. */
static double width_of(const struct soil_motion *motion, const struct soil_body *body)
{
	const struct soil_shape *shape = motion->shape;
	if (shape->kind == SOIL_WHEEL || shape->kind == SOIL_CYLINDER)
		return width_of_round(body->lower.axis[2], shape->kind == SOIL_WHEEL ? shape->width : shape->length, shape->radius);
	return shape->kind == SOIL_BOX ? 1 / fmin(shape->size[0], shape->size[1]) : 0;
}

/* The same of a mesh: a drum has the width of the wheel that it is, and a block that of the box. axis: of a drum, in the world. */
static double width_of_mesh(const struct soil_surface *surface, const double axis[3])
{
	if (surface->drum)
		return width_of_round(axis[2], surface->width, surface->radius);
	return surface->block ? 1 / fmin(surface->sides[0], surface->sides[1]) : 0;
}

/* Returns 1 / b for the posts that the body touches at a height. b is the radius of a round plate of their area. */
static float counted_width(const struct soil_posts *posts, const struct soil_form *form, int32_t raised)
{
	int32_t count = 0;
	for (size_t i = 0; i < posts->count; i++)
		count += (posts->over[i] > 0) & ((float)(posts->ground[i] - raised) * SOIL_UNIT - form->beyond > posts->height[i] + posts->above[i]);
	const float area = (float)(count > 1 ? count : 1) * form->spacing * form->spacing;
	return 1 / sqrtf(area * 0.31830989f);
}

/* The same of a mesh, for the area that it touches. It changes evenly as the mesh moves. */
static float touched_width(const struct soil_posts *posts, const struct soil_form *form, int32_t raised)
{
	float cells = 0;
	for (size_t i = 0; i < posts->count; i++) {
		/* How much of the cell is below the ground, as both are nearly plane. */
		const float x = posts->rise_x[i] - posts->slope_x[i], y = posts->rise_y[i] - posts->slope_y[i], across = sqrtf(x * x + y * y) * form->spacing;
		const float depth = (float)(posts->ground[i] - raised) * SOIL_UNIT - form->beyond - posts->height[i] - posts->above[i] + x * posts->middle_x[i] + y * posts->middle_y[i];
		cells += posts->share[i] * clamped(0.5f + depth / most(across, 1e-6f), 0, 1);
	}
	return 1 / sqrtf(most(cells, 1) * form->spacing * form->spacing * 0.31830989f);
}

/* --- one evaluation after another --- */

/* A mesh of a drum rolls as a cylinder does. */
static enum status begin_mesh(const struct soil_motion *motion, struct soil_work *work, struct soil_contact *b)
{
	TRY(soil_fine_draw(&b->body, &b->form, &work->fine));
	const struct soil_surface *surface = work->fine.surface;
	double own[3][3], axis[3];
	soil_axes(motion->to.yaw, motion->to.pitch, motion->to.roll, 0, own);
	for (int k = 0; k < 3; k++)
		axis[k] = surface->axis[0] * own[0][k] + surface->axis[1] * own[1][k] + surface->axis[2] * own[2][k];
	if (surface->drum)
		soil_form_drum(&b->body, axis, surface->radius, &b->form);
	b->by_width = width_of_mesh(surface, axis);
	b->bulb = surface->drum ? 1 + axis[2] * axis[2] : 1;
	b->round = surface->drum;
	b->across[0] = axis[1];
	b->across[1] = -axis[0];
	return STATUS_OK;
}

enum status soil_contact_begin(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work,
			       double above, struct soil_contact *b)
{
	const struct post_rect below = soil_posts_below(law, motion);
	TRY(need(work, below));
	*b = (struct soil_contact){.law = law, .planes = planes, .motion = motion, .below = below, .posts = &work->posts, .faces = &work->faces, .above = above, .wider = 1, .gathered = INT32_MAX};
	soil_form_of(law, motion, &b->body, &b->form);
	b->by_width = width_of(motion, &b->body);
	b->bulb = motion->shape->kind == SOIL_CYLINDER ? 1 + b->body.lower.axis[2] * b->body.lower.axis[2] : 1;
	if (b->form.kind == FORM_RASTER)
		TRY(begin_mesh(motion, work, b));
	/* With faces a drum counts for a wheel's bars, so only their prints need them. */
	if (motion->shape->kind == SOIL_WHEEL && motion->shape->grousers > 0 && (above > 0 || !(b->form.all_round > 0)))
		TRY(soil_grousers_draw(&b->body, &below, &b->form, &work->grousers));
	return soil_faces_begin(law, planes, &b->body, below, &b->form, b->faces);
}

/* Returns the body with a frame that looks across the axis of its drum, forwards. */
static struct soil_body rolling_frame(const struct soil_contact *b)
{
	struct soil_body body = b->body;
	const double length = hypot(b->across[0], b->across[1]), sign = body.axis[0] * b->across[0] + body.axis[1] * b->across[1] < 0 ? -1 : 1;
	for (int k = 0; k < 2 && b->round && length > 0; k++)
		body.axis[k] = sign * b->across[k] / length;
	return body;
}

static enum status need_met(struct soil_work *work, size_t count)
{
	if (count <= work->met_room)
		return STATUS_OK;
	TRY(mem_resize(&work->met, count, sizeof *work->met, "bearing soil"));
	TRY(mem_resize(&work->seen, count, sizeof *work->seen, "bearing soil"));
	TRY(mem_resize(&work->abuts, count, sizeof *work->abuts, "bearing soil"));
	work->met_room = count;
	return STATUS_OK;
}

enum status soil_contact_meet(struct soil_contact *b, struct soil_work *work, const struct soil_work *const *others, size_t count, int32_t raised)
{
	const struct soil_shape *shape = b->motion->shape;
	const bool rim = shape->kind == SOIL_WHEEL || shape->kind == SOIL_CYLINDER || b->round, box = shape->kind == SOIL_BOX;
	const double by_width = b->by_width * b->wider;
	const struct soil_met self = {&b->body, &b->form, raised};
	const struct soil_body rolls = rolling_frame(b);
	const struct soil_met whole_of = {b->round ? &rolls : &b->body, &b->form, raised};
	TRY(need_met(work, count));
	for (size_t i = 0; i < count; i++)
		work->met[i] = (struct soil_met){&others[i]->contact.body, &others[i]->contact.form, others[i]->raised};
	soil_meet_see(&self, work->met, count, work->seen);
	b->seen = work->seen;
	b->seen_count = count;
	b->shares = false;
	struct soil_whole whole;
	soil_meet_whole(&whole_of, work->met, count, rim, (const double[2]){box ? shape->size[0] : 0, box ? shape->size[1] : 0}, work->abuts, &whole);
	b->wider = whole.wider;
	b->by_width = by_width / b->wider;
	for (int k = 0; k < 2; k++)
		for (int end = 0; end < 2; end++)
			b->form.enters[k][end] = b->form.half[k] + (float)whole.more[k][end];
	b->gathered = INT32_MAX;
	return STATUS_OK;
}

void soil_contact_gather(struct soil_contact *b, int32_t lowest)
{
	if (lowest >= b->gathered)
		return;
	b->gathered = lowest;
	soil_posts_gather(b->law, b->planes, &b->body, &b->form, lowest, b->above, b->by_width, b->posts);
	b->shares = soil_meet_share(&b->form, b->seen, b->seen_count, b->posts) || b->shares;
}

void soil_contact_evaluate(struct soil_contact *b, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept, struct soil_changes *changes)
{
	float by_width = (float)b->by_width;
	if (!(by_width > 0))
		by_width = (b->form.kind == FORM_RASTER ? touched_width(b->posts, &b->form, raised) : counted_width(b->posts, &b->form, raised)) / (float)b->wider;
	/* The bulb of a round plate is as wide as the plate: twice its radius. */
	soil_posts_width(by_width, by_width > 0 ? (b->by_width > 0 ? (float)b->bulb : 2) / by_width : 0, b->posts);
	soil_faces_look(b->planes, &b->body, &b->form, b->posts, raised, b->faces);
	if (b->posts->layered)
		soil_bear_layered(&b->form, b->posts, raised, share, sums, kept, changes);
	else
		soil_bear(&b->form, b->posts, raised, share, sums, kept, changes);
	soil_faces_add(&b->body, &b->form, share, b->faces, sums, changes);
}

void soil_contact_turn(const struct soil_contact *b, const double v[3], double out[3])
{
	const double *axis = b->body.axis, x = v[0], y = v[1];
	out[0] = axis[0] * x - axis[1] * y;
	out[1] = axis[1] * x + axis[0] * y;
	out[2] = v[2];
}

void soil_contact_tell(const struct soil_contact *b, const struct soil_sums *sums, int32_t raised, enum soil_state state, struct soil_forces *forces)
{
	const double post = (double)b->form.spacing * (double)b->form.spacing, unit = post / (double)BEAR_UNITS_A_PASCAL;
	double force[3], moment[3];
	for (int k = 0; k < 3; k++) {
		force[k] = (double)sums->force[k] * unit;
		moment[k] = (double)sums->moment[k] * unit / (double)b->form.by_arm;
	}
	*forces = (struct soil_forces){
		.sinkage = lattice_offset_metres(sums->deepest), .area = (double)sums->area / (double)BEAR_AREA_UNITS * post, .pull = (double)sums->pull * unit,
		.z = b->motion->to.z + raised, .saturated = (uint32_t)sums->saturated, .state = sums->area == 0 && state != SOIL_SUNK ? SOIL_AIR : state,
	};
	soil_contact_turn(b, force, forces->force);
	soil_contact_turn(b, moment, forces->moment);
}
