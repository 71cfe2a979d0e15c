/* Soil aboard bodies: what a contact takes along, and how it settles in a window and between contacts. */
#include <string.h>

#include "base/memory.h"
#include "bearing/internal.h"

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

enum status bearing_carried_after(struct bearing *bearing, struct bearing_member *member, const struct deform_contact *contact)
{
	const struct soil_pose pose = standing(member);
	const int64_t aboard = held_by(contact->carried);
	soil_carried_place(contact->carried, &pose);
	const struct post_rect changed = soil_carried_settle(contact->carried, &pose, &bearing->rule, &bearing->window.planes, bearing->law.reference, member->write);
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

enum status bearing_carried_settle(struct bearing *bearing, struct soil_carried *carried, const struct deform_rest *rest, bool drops, const struct deform_rest *rests, size_t count,
				   const struct tile_slot *held, size_t held_count, struct post_rect *changed)
{
	const struct soil_pose pose = bearing_rest_pose(bearing, rest);
	const struct post_rect rect = bearing_carried_posts(bearing, carried, rest);
	const unsigned written = bearing->planes & (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DEPOSITED));
	const int64_t aboard = held_by(carried);
	*changed = (struct post_rect){0, 0, 0, 0};
	if (post_rect_empty(rect))
		return STATUS_OK;
	TRY(bearing_window_need(bearing, rect));
	bearing_window_clear(bearing);
	bearing_roofs_clear(bearing);
	bearing_window_gather(bearing, held, held_count, true, true);
	TRY(bearing_hold(bearing, rests, count));
	soil_carried_place(carried, &pose);
	*changed = drops ? soil_carried_drop(carried, &pose, &bearing->window.planes, bearing->law.reference, rect)
			 : soil_carried_settle(carried, &pose, &bearing->rule, &bearing->window.planes, bearing->law.reference, rect);
	bearing->tally.compacted += held_by(carried) - aboard;
	if (post_rect_empty(*changed))
		return STATUS_OK;
	for (size_t i = 0; i < held_count; i++)
		if (!post_rect_empty(post_rect_intersect(tile_post_rect(bearing->params.extent, held[i].tile), *changed)))
			TRY(resident_host_write(bearing->slots, held[i].slot, written));
	resident_host_scatter(bearing->slots, held, held_count, &bearing->window.planes, *changed, written);
	return bearing_wake(bearing, *changed);
}
