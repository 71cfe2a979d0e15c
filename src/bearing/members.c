/* The bodies of a meeting: scratch memory and form of each, and which of them may be over the same ground. */
#include <math.h>

#include "base/memory.h"
#include "bearing/internal.h"

struct soil_motion bearing_motion_of(const struct deform_contact *contact)
{
	struct soil_motion motion = {
		.shape = contact->shape, .interface = contact->interface, .from = contact->from, .to = contact->to, .turned = contact->turned, .load = contact->load,
		.stamped = contact->stamped, .hosted = contact->hosted, .jumped = deform_is_contact_only(contact) && !contact->hosted,
	};
	memcpy(motion.rotated, contact->rotated, sizeof motion.rotated);
	memcpy(motion.linear, contact->linear, sizeof motion.linear);
	memcpy(motion.angular, contact->angular, sizeof motion.angular);
	motion.runs = contact->runs;
	motion.seconds = contact->hosted ? 0 : contact->seconds;
	motion.trend = contact->trend;
	return motion;
}

enum status bearing_members_need(struct bearing *bearing, size_t count)
{
	if (count <= bearing->member_room)
		return STATUS_OK;
	TRY(mem_resize(&bearing->members, count, sizeof *bearing->members, "bearing soil"));
	TRY(mem_resize(&bearing->others, count, sizeof *bearing->others, "bearing soil"));
	TRY(mem_resize(&bearing->rests, count, sizeof *bearing->rests, "bearing soil"));
	for (; bearing->member_room < count; bearing->member_room++) {
		struct bearing_member *member = &bearing->members[bearing->member_room];
		*member = (struct bearing_member){.at = 0};
		TRY(soil_work_create(&member->work));
	}
	return STATUS_OK;
}

void bearing_members_finish(struct bearing *bearing)
{
	for (size_t i = 0; i < bearing->member_room; i++)
		soil_work_destroy(bearing->members[i].work);
	mem_free_all(bearing->members, bearing->others, bearing->rests, bearing->claims);
}

/* Returns a height that no place of a body is below, fixed-point units, absolute. */
static int64_t lowest_of(const struct soil_shape *shape, const struct soil_pose *pose)
{
	double axes[3][3], down = 0;
	if (shape->kind != SOIL_MESH)
		return pose->z - lattice_offset(soil_shape_reach(shape, pose->pitch, pose->roll)) - 1;
	soil_axes(pose->yaw, pose->pitch, pose->roll, pose->turn, axes);
	for (int k = 0; k < 3; k++) /* of the box around it */
		down += fmin(axes[k][2] * shape->mesh->low[k], axes[k][2] * shape->mesh->high[k]);
	return pose->z + lattice_offset(down) - 1;
}

/* Tells whether the ground is as high as a place of the body, somewhere on these posts of the window. */
static bool reaches_ground(const struct bearing *bearing, int64_t lowest, struct post_rect posts)
{
	const struct soil_planes *planes = &bearing->window.planes;
	const int64_t zero = (int64_t)bearing->law.reference * ((int64_t)1 << OFFSET_BITS);
	for (int64_t y = posts.y0; y < posts.y1; y++) {
		const size_t row = (size_t)(y - planes->rect.y0) * planes->width - (size_t)planes->rect.x0;
		for (int64_t x = posts.x0; x < posts.x1; x++) {
			const int32_t base = planes->base[row + (size_t)x];
			if (base != BASE_NODATA && zero + (int64_t)base * (1 << (OFFSET_BITS - BASE_BITS)) + planes->deposited[row + (size_t)x] >= lowest)
				return true;
		}
	}
	return false;
}

static struct post_rect shadow_of(const struct bearing *bearing, const struct soil_motion *motion)
{
	return post_rect_grown(soil_shadow(motion->shape, motion->jumped ? &motion->to : &motion->from, &motion->to, bearing->law.spacing), 1);
}

bool bearing_rest_is_near(const struct bearing *bearing, const struct deform_rest *rest, struct soil_motion *motion)
{
	*motion = (struct soil_motion){.shape = rest->shape, .to = rest->pose, .jumped = true};
	if (rest->loaded_body > 0)
		motion->to.z += bearing->standing[rest->loaded_body - 1];
	motion->from = motion->to;
	const struct post_rect over = post_rect_intersect(shadow_of(bearing, motion), bearing->window.planes.rect);
	return !post_rect_empty(over) && reaches_ground(bearing, lowest_of(motion->shape, &motion->to), over);
}

bool bearing_members_overlap(const struct bearing *bearing, const struct soil_motion *a, const struct soil_motion *b)
{
	return !post_rect_empty(post_rect_intersect(shadow_of(bearing, a), shadow_of(bearing, b)));
}

/* Gives two members, and those that are parts of one body with them, one party. */
static void join(struct bearing *bearing, size_t a, size_t b, size_t count)
{
	struct bearing_member *members = bearing->members;
	const size_t p = members[a].party, q = members[b].party, into = p < q ? p : q;
	for (size_t i = 0; i < count; i++)
		members[i].party = members[i].party == p || members[i].party == q ? into : members[i].party;
}

enum status bearing_member_meet(struct bearing *bearing, size_t number, size_t count, size_t all)
{
	struct bearing_member *member = &bearing->members[number];
	size_t met = 0;
	for (size_t i = 0; i < all; i++)
		if (i != number && bearing_members_overlap(bearing, &member->motion, &bearing->members[i].motion))
			bearing->others[met++] = bearing->members[i].work;
	member->crosses = met > 0;
	if (met > 0)
		TRY(soil_sink_meet(member->work, bearing->others, met));
	for (size_t i = 0, k = 0; i < count && !member->feels; i++) {
		const struct bearing_member *other = &bearing->members[i];
		if (i == number || !bearing_members_overlap(bearing, &member->motion, &other->motion))
			continue;
		if (!other->feels && soil_sink_is_part(member->work, k, other->work))
			join(bearing, number, i, count);
		k++;
	}
	return STATUS_OK;
}
