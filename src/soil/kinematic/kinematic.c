/* A contact of a kinematic model over a window. See kinematic.h. */
#include "soil/kinematic/kinematic.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "soil/kinematic/contact.h"
#include "soil/kinematic/under.h"

#define ALIGNED(bytes) (((bytes) + 63) / 64 * 64)

void soil_kinematic_sumner(struct soil_kinematic *kinematic, const struct soil_numbers *soils, int count)
{
	kinematic->carries = true;
	memset(kinematic->kept, 0, sizeof kinematic->kept);
	for (int i = 0; i < count; i++)
		kinematic->kept[i] = (uint32_t)floor(ldexp(1 - soils[i].compression, 31));
}

void soil_kinematic_slippage(struct soil_kinematic *kinematic)
{
	kinematic->carries = true;
	for (int i = 0; i < SOIL_CLASSES; i++)
		kinematic->kept[i] = 1u << 31;
}

static size_t room(const struct soil_kinematic *kinematic, const struct soil_shape *shape, size_t width, size_t height)
{
	const size_t envelope = ALIGNED(soil_under_stride((int64_t)width) * height * sizeof(int32_t));
	const size_t corners = shape->kind == SOIL_MESH ? shape->mesh->vertex_count * sizeof(struct facet_corner) : 0;
	const size_t smooth = kinematic->radius > 0 ? soil_smooth_room(width, height, kinematic->radius) : 0;
	const size_t contact = 2 * envelope + corners;
	return 64 + (contact > smooth ? contact : smooth);
}

size_t soil_kinematic_room(const struct soil_kinematic *kinematic, const struct soil_kinematic_contact *contact, size_t width, size_t height)
{
	return room(kinematic, contact->shape, width, height);
}

/* The posts of the planes below a body, and its lower envelopes there. */
struct below {
	struct post_rect posts;
	size_t stride;
	int32_t *under, *rest;
};

static void begin(const struct under_motion *motion, void *scratch, struct below *below)
{
	const struct post_rect posts = motion->posts;
	*below = (struct below){.posts = posts, .stride = soil_under_stride(posts.x1 - posts.x0)};
	if (post_rect_empty(posts))
		return;
	char *memory = (char *)(((uintptr_t)scratch + 63) / 64 * 64);
	const size_t bytes = ALIGNED(below->stride * (size_t)(posts.y1 - posts.y0) * sizeof(int32_t));
	below->under = (int32_t *)(void *)memory;
	below->rest = (int32_t *)(void *)(memory + bytes);
	soil_under(motion, (struct facet_corner *)(void *)(memory + 2 * bytes), below->under, below->rest);
}

/* Returns a row of the posts below the body. */
static struct contact_row row_of(const struct soil_kinematic *kinematic, const struct soil_planes *planes, const struct below *below, int64_t height,
				 int64_t y)
{
	const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(below->posts.x0 - planes->rect.x0);
	const size_t envelope = (size_t)(y - below->posts.y0) * below->stride;
	return (struct contact_row){
		.count = (int32_t)(below->posts.x1 - below->posts.x0),
		.base = planes->base + at, .under = below->under + envelope, .rest = below->rest + envelope,
		.offset = planes->offset + at, .contact = planes->contact + at, .classes = planes->classes != NULL ? planes->classes + at : NULL,
		.zero = height - (int64_t)kinematic->reference * (1 << OFFSET_BITS),
	};
}

/* Posts that the body is not above have the contact of their base alone. */
static void clear(const struct soil_planes *planes, struct post_rect posts, int32_t *carried)
{
	const size_t count = (size_t)(posts.x1 - posts.x0);
	for (int64_t y = posts.y0; y < posts.y1 && posts.x0 < posts.x1; y++) {
		const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(posts.x0 - planes->rect.x0);
		const int32_t *base = planes->base + at;
		uint8_t *contact = planes->contact + at;
		for (size_t i = 0; i < count; i++)
			contact[i] = base[i] == BASE_NODATA ? SOIL_NO_GROUND : 0;
		if (carried != NULL)
			memset(carried + at, 0, count * sizeof *carried);
	}
}

/* Clears what lies around some posts. */
static void clear_around(const struct soil_planes *planes, struct post_rect posts, int32_t *carried)
{
	const struct post_rect all = planes->rect;
	if (post_rect_empty(posts)) {
		clear(planes, all, carried);
		return;
	}
	clear(planes, (struct post_rect){all.x0, all.y0, all.x1, posts.y0}, carried);
	clear(planes, (struct post_rect){all.x0, posts.y0, posts.x0, posts.y1}, carried);
	clear(planes, (struct post_rect){posts.x1, posts.y0, all.x1, posts.y1}, carried);
	clear(planes, (struct post_rect){all.x0, posts.y1, all.x1, all.y1}, carried);
}

/* Returns the posts that smoothing can change, from the planes' first post. */
static struct smooth_posts trail_of(const struct soil_planes *planes, struct post_rect below, int64_t radius)
{
	const struct post_rect posts = post_rect_intersect(post_rect_grown(below, radius), planes->rect);
	return (struct smooth_posts){(int32_t)(posts.x0 - planes->rect.x0), (int32_t)(posts.y0 - planes->rect.y0), (int32_t)(posts.x1 - planes->rect.x0),
				     (int32_t)(posts.y1 - planes->rect.y0)};
}

void soil_kinematic_disturb(const struct soil_planes *planes, struct post_rect posts)
{
	for (int64_t y = posts.y0; y < posts.y1; y++) {
		const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(posts.x0 - planes->rect.x0);
		soil_disturb_row((int32_t)(posts.x1 - posts.x0), planes->contact + at, planes->offset + at, planes->disturbance + at);
	}
}

void soil_kinematic_mark(const struct soil_planes *planes, const struct soil_marks *marks, struct post_rect posts, const struct soil_mark *mark)
{
	const int32_t count = (int32_t)(posts.x1 - posts.x0);
	for (int64_t y = posts.y0; y < posts.y1 && count > 0; y++) {
		const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(posts.x0 - planes->rect.x0);
		if (marks->healed != NULL)
			soil_heal_row(count, planes->contact + at, planes->offset + at, mark->now, mark->heals, marks->healed + at);
		if (marks->risen != NULL)
			soil_mark_row(count, planes->contact + at, mark->risen, marks->risen + at);
		if (marks->grown != NULL)
			soil_mark_row(count, planes->contact + at, mark->grown, marks->grown + at);
	}
}

static int64_t clamp(int64_t v, int64_t low, int64_t high)
{
	return v < low ? low : v > high ? high : v;
}

void soil_kinematic_run(const struct soil_kinematic *kinematic, const struct soil_kinematic_contact *contact, struct soil_planes *planes,
			struct post_rect written, int32_t *carried, void *scratch, struct soil_kinematic_tally *tally)
{
	const bool moves = !soil_only_set_down(&contact->from, &contact->to);
	const struct soil_pose *from = moves ? &contact->from : &contact->to;
	const struct post_rect shadow = soil_shadow(contact->shape, from, &contact->to, kinematic->spacing);
	const struct under_motion motion = {.shape = contact->shape, .from = from, .to = &contact->to, .turned = contact->turned, .spacing = kinematic->spacing,
					    .posts = post_rect_intersect(shadow, planes->rect)};
	const struct post_rect posts = motion.posts;
	const int64_t width = posts.x1 - posts.x0;
	struct below below;
	clear_around(planes, posts, kinematic->carries ? carried : NULL);
	begin(&motion, scratch, &below);
	if (post_rect_empty(posts))
		return;
	for (int64_t y = posts.y0; y < posts.y1; y++) {
		const bool counts = y >= written.y0 && y < written.y1;
		struct contact_row row = row_of(kinematic, planes, &below, contact->to.z, y);
		row.near = (int32_t)fmin(ldexp(2 * kinematic->spacing, OFFSET_BITS), 1 << 30);
		row.written[0] = counts ? (int32_t)clamp(written.x0 - posts.x0, 0, width) : 0;
		row.written[1] = counts ? (int32_t)clamp(written.x1 - posts.x0, 0, width) : 0;
		row.carried = kinematic->carries ? carried + (row.offset - planes->offset) : NULL;
		soil_contact_row(&row, kinematic->kept, tally);
	}
	/* A contact without motion leaves no post, so there is nothing to smooth. */
	if (kinematic->radius > 0 && moves)
		soil_smooth(kinematic, planes, trail_of(planes, posts, kinematic->radius), scratch);
	if (planes->disturbance != NULL && !kinematic->carries)
		soil_kinematic_disturb(planes, posts);
}

void soil_kinematic_hold(const struct soil_kinematic *kinematic, const struct soil_shape *shape, const struct soil_pose *pose,
			 struct soil_planes *planes, void *scratch)
{
	const struct under_motion motion = {.shape = shape, .from = pose, .to = pose, .spacing = kinematic->spacing,
					    .posts = post_rect_intersect(soil_shadow(shape, pose, pose, kinematic->spacing), planes->rect)};
	struct below below;
	begin(&motion, scratch, &below);
	for (int64_t y = motion.posts.y0; y < motion.posts.y1 && !post_rect_empty(motion.posts); y++) {
		const struct contact_row row = row_of(kinematic, planes, &below, pose->z, y);
		soil_hold_row(&row);
	}
}

struct soil_pose soil_upside_down(const struct soil_pose *pose)
{
	struct soil_pose turned = *pose;
	turned.pitch = -pose->pitch;
	turned.roll = -pose->roll;
	turned.turn = M_PI - pose->turn;
	return turned;
}

enum status soil_kinematic_mirror(const struct soil_mesh *mesh, struct soil_mesh *mirrored)
{
	*mirrored = *mesh;
	TRY(mem_make(&mirrored->vertices, mesh->vertex_count, sizeof *mirrored->vertices, "a mesh upside down"));
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		mirrored->vertices[i][0] = mesh->vertices[i][0];
		mirrored->vertices[i][1] = mesh->vertices[i][1];
		mirrored->vertices[i][2] = -mesh->vertices[i][2];
	}
	mirrored->low[2] = -mesh->high[2];
	mirrored->high[2] = -mesh->low[2];
	return STATUS_OK;
}

/* Gives how far the upper envelope is below the centre at the posts of `below`: the lower envelope of the body upside down. Mirrored in its own x and y axes
 * every shape but a mesh is itself. */
static void find_tops(const struct soil_shape *shape, const struct soil_mesh *mirrored, const struct under_motion *motion, void *scratch, struct below *tops)
{
	struct soil_shape upside_down = *shape;
	const struct soil_pose pose = soil_upside_down(motion->to);
	struct under_motion turned = *motion;
	upside_down.mesh = mirrored;
	turned.shape = &upside_down;
	turned.from = turned.to = &pose;
	begin(&turned, scratch, tops);
}

bool soil_kinematic_roof(const struct soil_kinematic *kinematic, const struct soil_shape *shape, const struct soil_mesh *mirrored, const struct soil_pose *pose,
			 struct soil_planes *planes, int32_t *highest, void *scratch)
{
	const struct under_motion motion = {.shape = shape, .from = pose, .to = pose, .spacing = kinematic->spacing,
					    .posts = post_rect_intersect(soil_shadow(shape, pose, pose, kinematic->spacing), planes->rect)};
	struct below below, tops = {.rest = NULL};
	bool inside = false, any = false;
	begin(&motion, scratch, &below);
	for (int64_t y = motion.posts.y0; y < motion.posts.y1 && !post_rect_empty(motion.posts); y++) {
		const struct contact_row row = row_of(kinematic, planes, &below, pose->z, y);
		soil_hold_row(&row);
		inside = inside || soil_is_inside_row(&row);
	}
	if (inside && (shape->kind != SOIL_MESH || mirrored != NULL))
		find_tops(shape, mirrored, &motion, (char *)scratch + room(kinematic, shape, (size_t)(motion.posts.x1 - motion.posts.x0), (size_t)(motion.posts.y1 - motion.posts.y0)), &tops);
	for (int64_t y = motion.posts.y0; y < motion.posts.y1 && !post_rect_empty(motion.posts); y++) {
		const struct contact_row row = row_of(kinematic, planes, &below, pose->z, y);
		const int32_t *top = tops.rest != NULL ? tops.rest + (size_t)(y - tops.posts.y0) * tops.stride : NULL;
		any |= soil_roof_row(&row, top, highest + (row.offset - planes->offset));
	}
	return any;
}
