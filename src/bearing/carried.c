/* Soil aboard bodies: what a contact takes along, and how it settles in a window and between contacts. */
#include <string.h>

#include "base/memory.h"
#include "bearing/internal.h"
#include "soil/carried/around.h"

#define CARRIED_BESIDE 5 /* posts around a body to which its soil falls */

/* Returns what is aboard or has begun to fall off: all of that counts as compacted. */
static int64_t held_by(const struct soil_carried *carried)
{
	return carried->total + carried->fell_total;
}

static size_t posts_of(const struct bearing *bearing)
{
	const struct soil_planes *planes = &bearing->window.planes;
	return planes->width * (size_t)(planes->rect.y1 - planes->rect.y0);
}

enum status bearing_carried_begin(struct bearing *bearing, const struct bearing_contact *contacts, size_t count)
{
	struct bearing_window *window = &bearing->window;
	bool any = false;
	for (size_t i = 0; i < count; i++)
		any |= contacts[i].contact->carried != NULL && !contacts[i].feels;
	if (!any)
		return STATUS_OK;
	if (posts_of(bearing) > window->before_posts) {
		mem_free(window->before);
		window->before_posts = 0;
		TRY(mem_make(&window->before, posts_of(bearing), sizeof *window->before, "soil aboard bodies"));
		window->before_posts = posts_of(bearing);
	}
	memcpy(window->before, window->planes.offset, posts_of(bearing) * sizeof *window->before);
	return STATUS_OK;
}

/* Where the body is after its contact. */
static struct soil_pose standing(const struct bearing_member *member)
{
	struct soil_pose pose = member->motion.to;
	pose.z += member->motion.load > 0 ? member->imprint.raised : 0;
	return pose;
}

void bearing_carried_take(struct bearing *bearing, struct bearing_member *member, const struct deform_contact *contact, uint8_t owner)
{
	struct bearing_window *window = &bearing->window;
	const struct soil_planes *planes = &window->planes;
	const struct soil_pose pose = standing(member);
	const int64_t zero = (int64_t)bearing->law.reference * ((int64_t)1 << OFFSET_BITS);
	struct soil_measured *measured = &member->imprint.measured;
	const struct post_rect patch = post_rect_intersect(measured->patch, planes->rect);
	soil_carried_place(contact->carried, &pose);
	for (int64_t y = patch.y0; y < patch.y1; y++)
		for (int64_t x = patch.x0; x < patch.x1; x++) {
			const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
			const int32_t top = soil_carried_top_at(contact->carried, &pose, x, y), gave = window->carried[at];
			if ((planes->contact[at] & SOIL_LOWERED) == 0 || (owner != 0 && window->owners[at] != owner) || top == CARRIED_OPEN || gave <= 0)
				continue;
			const int64_t above = zero + 4 * (int64_t)planes->base[at] + window->before[at] - pose.z - top;
			const int32_t wanted = (int32_t)(above <= 0 ? 0 : above < gave ? above : gave);
			const int32_t taken = wanted > 0 ? soil_carried_add(contact->carried, &pose, x, y, wanted, planes->classes != NULL ? planes->classes[at] : 0) : 0;
			window->carried[at] -= taken;
			measured->carried -= taken;
			bearing->tally.compacted += taken;
		}
}

/* Tells whether another body may be below what falls from a member. Then soil falls in the next interval, when nothing else moves. */
static bool is_near_others(const struct bearing *bearing, const struct bearing_member *member, size_t count)
{
	const struct post_rect reach = post_rect_grown(soil_shadow(member->motion.shape, &member->motion.to, &member->motion.to, bearing->law.spacing), CARRIED_BESIDE);
	bool near = false;
	for (size_t i = 0; i < count && !near; i++) {
		const struct bearing_member *other = &bearing->members[i];
		near = other != member && !post_rect_empty(post_rect_intersect(reach, soil_shadow(other->motion.shape, &other->motion.to, &other->motion.to, bearing->law.spacing)));
	}
	for (size_t i = 0; i < bearing->rest_count && !near; i++)
		near = !post_rect_empty(post_rect_intersect(reach, soil_shadow(bearing->rests[i].shape, &bearing->rests[i].pose, &bearing->rests[i].pose, bearing->law.spacing)));
	return near;
}

enum status bearing_carried_after(struct bearing *bearing, struct bearing_member *member, const struct deform_contact *contact, size_t count)
{
	const struct soil_pose pose = standing(member);
	const int64_t aboard = held_by(contact->carried);
	soil_carried_place(contact->carried, &pose);
	const struct soil_carried_around around = {.planes = &bearing->window.planes, .reference = bearing->law.reference, .written = member->write, .alone = is_near_others(bearing, member, count)};
	const struct post_rect changed = soil_carried_settle_among(contact->carried, &pose, &bearing->rule, &around);
	bearing->tally.compacted += held_by(contact->carried) - aboard;
	if (post_rect_empty(changed))
		return STATUS_OK;
	member->imprint.reached = post_rect_empty(member->imprint.reached) ? changed : post_rect_around(member->imprint.reached, changed);
	return bearing_wake(bearing, changed);
}

struct post_rect bearing_carried_posts(const struct bearing *bearing, const struct soil_carried *carried, const struct deform_rest *rest)
{
	const struct soil_pose pose = bearing_rest_pose(bearing, rest);
	return post_rect_intersect(soil_carried_reach(carried, &pose), bearing->world);
}

/* Returns the soil aboard a body and aboard all other bodies that its soil may fall onto. Fixed-point units. */
static int64_t aboard(const struct bearing_aboard *how)
{
	int64_t total = held_by(how->body.carried);
	for (size_t i = 0; i < how->other_count; i++)
		total += held_by(how->others[i].carried);
	return total;
}

/* Lists the others as they are. */
static enum status place_others(const struct bearing *bearing, const struct bearing_aboard *how, struct soil_carried_other **out)
{
	*out = NULL;
	if (how->other_count == 0)
		return STATUS_OK;
	TRY(mem_make(out, how->other_count, sizeof **out, "soil aboard bodies"));
	for (size_t i = 0; i < how->other_count; i++) {
		(*out)[i] = (struct soil_carried_other){how->others[i].carried, bearing_rest_pose(bearing, &how->others[i].rest)};
		soil_carried_place(how->others[i].carried, &(*out)[i].pose);
	}
	return STATUS_OK;
}

enum status bearing_carried_settle(struct bearing *bearing, const struct bearing_aboard *how, const struct tile_slot *held, size_t held_count, struct post_rect *changed)
{
	struct soil_carried *carried = how->body.carried;
	const struct soil_pose pose = bearing_rest_pose(bearing, &how->body.rest);
	const struct post_rect rect = bearing_carried_posts(bearing, carried, &how->body.rest);
	const unsigned written = bearing->planes & (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DEPOSITED));
	const int64_t total = aboard(how);
	struct soil_carried_other *others;
	*changed = (struct post_rect){0, 0, 0, 0};
	if (post_rect_empty(rect))
		return STATUS_OK;
	TRY(bearing_window_need(bearing, rect));
	bearing_window_clear(bearing);
	bearing_roofs_clear(bearing);
	bearing_window_gather(bearing, held, held_count, true, true);
	TRY(bearing_hold(bearing, how->rests, how->rest_count));
	TRY(place_others(bearing, how, &others));
	soil_carried_place(carried, &pose);
	const struct soil_carried_around around = {&bearing->window.planes, bearing->law.reference, rect, others, how->other_count, false};
	*changed = how->drops ? soil_carried_drop_among(carried, &pose, &around) : soil_carried_settle_among(carried, &pose, &bearing->rule, &around);
	bearing->tally.compacted += aboard(how) - total;
	mem_free(others);
	if (post_rect_empty(*changed))
		return STATUS_OK;
	for (size_t i = 0; i < held_count; i++)
		if (!post_rect_empty(post_rect_intersect(tile_post_rect(bearing->params.extent, held[i].tile), *changed)))
			TRY(resident_host_write(bearing->slots, held[i].slot, written));
	resident_host_scatter(bearing->slots, held, held_count, &bearing->window.planes, *changed, written);
	return bearing_wake(bearing, *changed);
}
