/* Contacts of bodies with the ground: from the tiles into a window, the bodies into the ground, and back. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "bearing/internal.h"
#include "soil/kinematic/kinematic.h"

#define ROUNDS 4 /* in which bodies with loads over the same ground find their heights */

enum status bearing_area(const struct bearing *bearing, const struct deform_contact *contact, struct bearing_area *area)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	*area = (struct bearing_area){{0, 0, 0, 0}, {0, 0, 0, 0}};
	TRY(deform_cut(&bearing->params, contact, windows, &count));
	for (size_t i = 0; i < count; i++) {
		area->read = post_rect_joined(area->read, windows[i].read);
		area->write = post_rect_joined(area->write, windows[i].write);
	}
	return STATUS_OK;
}

bool bearing_covers(const struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, const struct soil_pose *rest)
{
	if (bearing->elastic)
		return deform_covers_sheet(contact);
	const struct post_rect shadow = soil_shadow(contact->shape, rest, rest, bearing->law.spacing), all = area->write;
	const struct post_rect held = post_rect_intersect(post_rect_grown(shadow, bearing->rule.step), bearing->world);
	return post_rect_empty(held) || (held.x0 >= all.x0 && held.y0 >= all.y0 && held.x1 <= all.x1 && held.y1 <= all.y1);
}

struct post_rect bearing_meeting_reads(const struct bearing_contact *contacts, size_t count)
{
	struct post_rect reads = {0, 0, 0, 0};
	for (size_t i = 0; i < count; i++)
		reads = post_rect_joined(reads, contacts[i].area.read);
	return reads;
}

static size_t window_posts(const struct bearing *bearing)
{
	const struct soil_planes *planes = &bearing->window.planes;
	return planes->width * (size_t)(planes->rect.y1 - planes->rect.y0);
}

/* Makes the window, whose posts no contact has touched. All of them are gathered later. */
static enum status open_window(struct bearing *bearing, struct post_rect rect)
{
	TRY(bearing_window_need(bearing, rect));
	memset(bearing->window.planes.contact, 0, window_posts(bearing));
	bearing_roofs_clear(bearing);
	return STATUS_OK;
}

enum status bearing_meeting_begin(struct bearing *bearing, const struct bearing_contact *contacts, size_t count, bool whole)
{
	bearing->whole = whole;
	bearing->under = (struct post_rect){0, 0, 0, 0};
	for (size_t i = 0; i < count; i++) {
		const struct soil_motion motion = bearing_motion_of(contacts[i].contact);
		const struct post_rect known = post_rect_grown(soil_posts_below(&bearing->law, &motion), bearing->law.faces ? SOIL_FACES_KNOW : 0);
		bearing->under = post_rect_joined(bearing->under, post_rect_intersect(known, contacts[i].area.read));
	}
	TRY(open_window(bearing, bearing_meeting_reads(contacts, count)));
	if (!whole)
		bearing_window_clear(bearing); /* posts of no tile are beyond the world */
	return STATUS_OK;
}

void bearing_meeting_gather(struct bearing *bearing, const struct tile_slot *held, size_t count)
{
	bearing_window_gather(bearing, held, count, false, bearing->whole);
}

enum status bearing_meeting_scatter(struct bearing *bearing, const struct bearing_contact *contacts, size_t count, const struct tile_slot *held, size_t held_count)
{
	for (size_t i = 0; i < count; i++)
		for (size_t k = 0; k < held_count; k++)
			if (!post_rect_empty(post_rect_intersect(tile_post_rect(bearing->params.extent, held[k].tile), contacts[i].changed)))
				TRY(resident_host_write(bearing->slots, held[k].slot, bearing->planes));
	const unsigned wide = PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DEPOSITED) | PLANE_BIT(PLANE_DISTURBANCE);
	for (size_t i = 0; i < count; i++) {
		const struct post_rect changed = contacts[i].changed, touched = post_rect_intersect(changed, bearing->under);
		if (!post_rect_empty(changed))
			resident_host_scatter(bearing->slots, held, held_count, &bearing->window.planes, changed, bearing->planes & wide);
		if (!post_rect_empty(changed))
			bearing_marks_scatter(bearing, held, held_count, changed);
		if (!post_rect_empty(touched))
			resident_host_scatter(bearing->slots, held, held_count, &bearing->window.planes, touched, bearing->planes & ~wide);
	}
	return STATUS_OK;
}

/* --- into the ground --- */

static struct soil_laying laying_of(const struct bearing *bearing, const struct soil_motion *motion)
{
	struct soil_laying laying = soil_laying_of(motion->shape, &motion->from, &motion->to, motion->turned, motion->rotated, bearing->law.spacing);
	if (bearing->law.faces)
		soil_laying_ahead(&laying);
	return laying;
}

static int32_t *standing_of(struct bearing *bearing, const struct deform_contact *contact)
{
	return contact->loaded_body > 0 ? &bearing->standing[contact->loaded_body - 1] : NULL;
}

/* Begins those beside the first `count` members that may be over the same ground, and lists them in bearing->others. Adds their number to *all. */
static enum status begin_rests(struct bearing *bearing, size_t count, const struct deform_rest *beside, size_t beside_count, size_t *all)
{
	bearing->rest_count = 0;
	for (size_t i = 0; i < beside_count; i++) {
		struct bearing_member *member = &bearing->members[*all];
		bool overlaps = false;
		if (!bearing_rest_is_near(bearing, &beside[i], &member->motion))
			continue;
		bearing->rests[bearing->rest_count++] = beside[i];
		for (size_t k = 0; k < count && !overlaps; k++)
			overlaps = bearing_members_overlap(bearing, &bearing->members[k].motion, &member->motion);
		if (!overlaps)
			continue;
		bearing->others[(*all)++ - count] = member->work;
		TRY(soil_sink_begin(&bearing->law, NULL, &member->motion, 0, member->work));
	}
	return STATUS_OK;
}

/* Begins the bodies that meet the ground. */
static enum status begin(struct bearing *bearing, const struct bearing_contact *contacts, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		struct bearing_member *member = &bearing->members[i];
		const struct deform_contact *contact = contacts[i].contact;
		const int32_t *standing = standing_of(bearing, contact);
		member->motion = bearing_motion_of(contact);
		member->at = bearing_window_part(&bearing->window, contacts[i].area.read, &member->planes);
		member->laying = laying_of(bearing, &member->motion);
		member->motion.hollows = member->laying.front ? soil_shape_reach(contact->shape, contact->to.pitch, contact->to.roll) : 0;
		member->laid = (struct soil_lay_result){.posts = {0, 0, 0, 0}};
		member->slides = (struct post_rect){0, 0, 0, 0};
		member->write = contacts[i].area.write;
		member->party = i;
		member->widened = false;
		member->feels = contacts[i].feels;
		if (bearing->params.thrown)
			bearing_throw_of(&member->motion, contact->seconds, bearing->params.gravity, &member->throws);
		TRY(soil_sink_begin(&bearing->law, &member->planes, &member->motion, standing != NULL ? *standing : 0, member->work));
	}
	return STATUS_OK;
}

/* Finds heights and forces. The height of a body with a load depends on the others. So heights are found anew while they change. */
static enum status find(struct bearing *bearing, size_t count, size_t all)
{
	bool again = true;
	for (int round = 0; round < ROUNDS && again; round++) {
		again = false;
		for (size_t i = 0; i < count && all > 1; i++)
			TRY(bearing_member_meet(bearing, i, count, all));
		for (size_t i = 0; i < count; i++) {
			struct bearing_member *member = &bearing->members[i];
			const int32_t before = member->imprint.raised;
			soil_sink_find(member->work, &member->imprint);
			again |= member->motion.load > 0 && all > 1 && soil_sink_shares(member->work) && (round == 0 || member->imprint.raised != before);
		}
	}
	return STATUS_OK;
}

/* Decides which body changes a post, where several touch it. */
static enum status claim(struct bearing *bearing, const struct bearing_contact *contacts, size_t count)
{
	const size_t posts = window_posts(bearing);
	bool any = false;
	for (size_t i = 0; i < count && count > 1; i++)
		any |= bearing->members[i].crosses;
	if (!any)
		return STATUS_OK;
	if (posts > bearing->claim_room) {
		mem_free(bearing->claims);
		bearing->claim_room = 0;
		TRY(mem_make(&bearing->claims, posts, sizeof *bearing->claims, "bearing soil"));
		bearing->claim_room = posts;
	}
	memset(bearing->claims, 0, posts * sizeof *bearing->claims);
	for (size_t i = 0; i < count; i++)
		if (bearing->members[i].crosses && !contacts[i].feels)
			soil_sink_claim(bearing->members[i].work, (uint8_t)(i + 1), bearing->claims + bearing->members[i].at);
	return STATUS_OK;
}

/* Prepares the laying of members that are parts of one body: as the first of them, for all. */
static void begin_parties(struct bearing *bearing, size_t count)
{
	struct bearing_member *members = bearing->members;
	for (size_t i = 0; i < count; i++) {
		if (members[i].party == i)
			continue;
		struct bearing_member *first = &members[members[i].party];
		if (!first->widened)
			soil_sink_widen(first->work, &first->laying);
		first->widened = true;
		first->write = post_rect_joined(first->write, members[i].write);
	}
}

static void commit(struct bearing *bearing, const struct bearing_contact *contacts, size_t count, bool alone)
{
	struct bearing_window *window = &bearing->window;
	struct bearing_member *members = bearing->members;
	if (!alone)
		memset(window->owners, 0, window_posts(bearing));
	begin_parties(bearing, count);
	for (size_t i = 0; i < count; i++) {
		struct bearing_member *member = &members[i];
		const struct soil_sink sink = {.laying = &members[member->party].laying, .soils = bearing->laid, .carried = window->carried + member->at, .notes = contacts[i].contact->carried != NULL,
						.throws = bearing->params.thrown ? (int32_t)lround(65536 * member->throws.share) : 0};
		const struct soil_sink_shared shared = {count > 1 && member->crosses ? bearing->claims + member->at : NULL, window->owners + member->at, (uint8_t)(i + 1)};
		if (!member->feels)
			soil_sink_commit(member->work, &sink, alone ? NULL : &shared, &member->imprint);
		if (!member->feels && contacts[i].contact->carried != NULL)
			bearing_carried_take(bearing, member, contacts[i].contact, alone ? 0 : (uint8_t)(i + 1));
	}
	for (size_t i = 0; i < count; i++)
		if (members[i].party != i && !members[i].feels) {
			soil_measured_join(&members[members[i].party].imprint.measured, &members[i].imprint.measured);
			members[i].imprint.measured.carried = 0;
		}
}

/* --- laying and sliding --- */

/* Marks the posts that a party touched. */
static const uint8_t *patch_of(struct bearing *bearing, size_t party)
{
	const size_t posts = window_posts(bearing);
	uint8_t *patch = bearing->window.patch;
	const uint8_t *owners = bearing->window.owners, *contact = bearing->window.planes.contact;
	for (size_t i = 0; i < posts; i++)
		patch[i] = owners[i] > 0 && bearing->members[owners[i] - 1].party == party ? SOIL_LOWERED : contact[i] & SOIL_NEAR;
	return patch;
}

/* Lays what the bodies displaced. Returns false if there is nothing. */
static bool lay(struct bearing *bearing, size_t count, bool alone)
{
	struct bearing_window *window = &bearing->window;
	bool any = false;
	bearing_roofs_close(bearing);
	for (size_t i = 0; i < count; i++) {
		struct bearing_member *member = &bearing->members[i];
		if (member->feels || member->imprint.measured.carried <= 0)
			continue;
		if (!any)
			memset(window->deposits, 0, window_posts(bearing) * sizeof *window->deposits);
		any = true;
		const uint8_t *patch = !alone && (member->laying.around || member->laying.front) ? patch_of(bearing, i) : window->planes.contact;
		soil_lay(&member->laying, &member->imprint.measured, bearing->laid, &window->planes, patch, window->carried, member->write, window->scratch, window->deposits,
			 &member->laid);
	}
	bearing_roofs_open(bearing);
	for (size_t i = 0; i < count && any; i++)
		bearing->members[i].laid.compacted += bearing_roofs_part(bearing, bearing->members[i].laid.posts);
	return any;
}

static struct post_rect reached_by(const struct bearing_member *member)
{
	return post_rect_joined(member->imprint.reached, member->laid.posts);
}

/* Gives members one cluster if soil may slide on the same posts. A cluster slides on the rectangle around all of its members, so rectangles of two never overlap. */
static void put_clusters(struct bearing *bearing, size_t count)
{
	struct bearing_member *members = bearing->members;
	for (size_t i = 0; i < count; i++) {
		members[i].cluster = i;
		if (!members[i].feels && !post_rect_empty(members[i].imprint.reached))
			members[i].slides = soil_slide_posts(members[i].write, reached_by(&members[i]), bearing->around);
		members[i].hull = members[i].slides;
	}
	for (bool grows = true; grows;) {
		grows = false;
		for (size_t i = 0; i < count; i++)
			for (size_t k = i + 1; k < count; k++) {
				const struct post_rect a = members[i].hull, b = members[k].hull;
				if (members[k].cluster == members[i].cluster || post_rect_empty(a) || post_rect_empty(b) ||
				    post_rect_empty(post_rect_intersect(post_rect_grown(a, 1), b)))
					continue;
				const size_t into = members[i].cluster < members[k].cluster ? members[i].cluster : members[k].cluster;
				const size_t from = members[i].cluster < members[k].cluster ? members[k].cluster : members[i].cluster;
				for (size_t m = 0; m < count; m++) {
					members[m].cluster = members[m].cluster == from ? into : members[m].cluster;
					members[m].hull = members[m].cluster == into && !post_rect_empty(members[m].slides) ? post_rect_joined(a, b) : members[m].hull;
				}
				grows = true;
			}
	}
}

/* Lets the soil of one cluster slide. */
static enum status slide(struct bearing *bearing, struct bearing_contact *contacts, size_t count, size_t cluster, bool deposits)
{
	struct bearing_window *window = &bearing->window;
	struct bearing_member *members = bearing->members;
	struct soil_slide_window slide = {.world = bearing->world, .deposits = deposits ? window->deposits : NULL};
	struct post_rect reached = {0, 0, 0, 0};
	struct soil_slid slid = {0};
	for (size_t i = 0; i < count; i++) {
		if (members[i].cluster != cluster || post_rect_empty(members[i].slides))
			continue;
		slide.written = post_rect_joined(slide.written, members[i].write);
		slide.posts = post_rect_joined(slide.posts, members[i].slides);
		slide.loaded |= members[i].motion.load > 0;
		reached = post_rect_joined(reached, reached_by(&members[i]));
	}
	if (post_rect_empty(slide.written))
		return STATUS_OK;
	struct soil_roofs roofs;
	soil_slide_window_below(&bearing->rule, &window->planes, &slide, bearing_roofs(bearing, &roofs), window->scratch, window->words, &slid);
	bool first = true;
	const struct post_rect changed = post_rect_intersect(slide.written, post_rect_grown(post_rect_joined(reached, slide.posts), 1));
	for (size_t i = 0; i < count; i++) {
		if (members[i].cluster != cluster || post_rect_empty(members[i].slides))
			continue;
		/* The first has all: it may be more than what each of them writes. */
		contacts[i].changed = first ? changed : post_rect_intersect(contacts[i].area.write, changed);
		first = false;
		if (bearing->params.disturbance)
			soil_kinematic_disturb(&window->planes, post_rect_intersect(members[i].imprint.reached, contacts[i].area.write));
		bearing_mark(bearing, contacts[i].contact, post_rect_intersect(members[i].imprint.reached, contacts[i].area.write));
	}
	bearing->tally.compacted += (int64_t)slid.compacted;
	bearing->tally.refused += slid.refused;
	return soil_active_add_words(&bearing->active, bearing->world, soil_slide_blocks(slide.written), window->words);
}

/* --- a meeting --- */

/* Tells what a member threw. */
static void tell_thrown(const struct bearing *bearing, const struct bearing_member *member, struct bearing_contact *contact)
{
	const struct soil_planes *planes = &bearing->window.planes;
	const struct soil_pose *to = &member->motion.to;
	const int64_t x = llround(lattice_offset_metres(to->x) / bearing->law.spacing), y = llround(lattice_offset_metres(to->y) / bearing->law.spacing);
	contact->thrown = member->imprint.thrown;
	contact->throws = member->throws;
	contact->thrown_from[0] = to->x;
	contact->thrown_from[1] = to->y;
	contact->thrown_from[2] = to->z + member->imprint.raised;
	contact->thrown_class = 0;
	if (planes->classes != NULL && x >= planes->rect.x0 && y >= planes->rect.y0 && x < planes->rect.x1 && y < planes->rect.y1)
		contact->thrown_class = planes->classes[(size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0)];
}

static void add_tally(struct bearing *bearing, const struct bearing_member *member, enum deform_state state)
{
	bearing->tally.compacted += member->imprint.compacted + member->imprint.thrown + member->laid.compacted;
	bearing->tally.refused += member->imprint.refused + member->laid.refused;
	bearing->tally.confined += member->laid.confined;
	bearing->tally.sunk += state == DEFORM_SUNK;
	bearing->tally.slid += state == DEFORM_SLIDES;
}

enum status bearing_meeting_compute(struct bearing *bearing, struct bearing_contact *contacts, size_t count, const struct deform_rest *beside,
				    size_t beside_count)
{
	size_t all = count;
	TRY(bearing_members_need(bearing, count + beside_count));
	TRY(begin(bearing, contacts, count));
	TRY(begin_rests(bearing, count, beside, beside_count, &all));
	TRY(find(bearing, count, all));
	TRY(claim(bearing, contacts, count));
	for (size_t i = 0; i < count; i++) {
		const struct bearing_member *member = &bearing->members[i];
		contacts[i].changed = (struct post_rect){0, 0, 0, 0};
		bearing_tell(bearing, contacts[i].contact, &member->motion, &member->imprint.forces, &contacts[i].forces);
		bearing->contacts += !contacts[i].feels;
		bearing->feels += contacts[i].feels;
	}
	const bool alone = count == 1 && bearing->rest_count == 0;
	TRY(bearing_carried_begin(bearing, contacts, count));
	commit(bearing, contacts, count, alone);
	TRY(bearing_hold(bearing, bearing->rests, bearing->rest_count));
	const bool deposits = lay(bearing, count, alone);
	for (size_t i = 0; i < count; i++)
		if (contacts[i].contact->carried != NULL && !contacts[i].feels)
			TRY(bearing_carried_after(bearing, &bearing->members[i], contacts[i].contact, count));
	put_clusters(bearing, count);
	for (size_t i = 0; i < count; i++)
		TRY(slide(bearing, contacts, count, i, deposits));
	for (size_t i = 0; i < count; i++) {
		int32_t *standing = standing_of(bearing, contacts[i].contact);
		if (contacts[i].feels)
			continue;
		add_tally(bearing, &bearing->members[i], contacts[i].forces.state);
		if (bearing->params.thrown)
			tell_thrown(bearing, &bearing->members[i], &contacts[i]);
		if (standing != NULL)
			*standing = bearing->members[i].imprint.raised;
	}
	return STATUS_OK;
}

enum status bearing_contact_alone(struct bearing *bearing, struct bearing_contact *contact, const struct tile_slot *held, size_t count)
{
	TRY(bearing_meeting_begin(bearing, contact, 1, true));
	bearing_meeting_gather(bearing, held, count);
	TRY(bearing_meeting_compute(bearing, contact, 1, NULL, 0));
	return bearing_meeting_scatter(bearing, contact, 1, held, count);
}

/* --- probes --- */

struct post_rect bearing_probe_posts(const struct bearing *bearing, const struct soil_motion *motion)
{
	const struct post_rect shadow = soil_shadow(motion->shape, motion->jumped ? &motion->to : &motion->from, &motion->to, bearing->law.spacing);
	const int64_t around = 2 + soil_faces_reach(&bearing->law, motion);
	return post_rect_empty(shadow) ? shadow : post_rect_intersect(post_rect_grown(shadow, around), post_rect_grown(bearing->world, 1));
}

/* Lets member 0 sink into the ground of the window, by a motion. What it displaces is not laid. */
static enum status sink_before(struct bearing *bearing, const struct soil_motion *motion, const struct deform_rest *beside, size_t beside_count)
{
	struct bearing_member *member = &bearing->members[0];
	const struct soil_laying laying = laying_of(bearing, motion);
	const struct soil_sink sink = {.laying = &laying, .soils = bearing->laid};
	size_t all = 1;
	member->motion = *motion;
	TRY(begin_rests(bearing, 1, beside, beside_count, &all));
	TRY(soil_sink_begin(&bearing->law, &bearing->window.planes, &member->motion, 0, member->work));
	TRY(soil_sink_meet(member->work, bearing->others, all - 1));
	soil_sink_find(member->work, &member->imprint);
	soil_sink_commit(member->work, &sink, NULL, &member->imprint);
	return STATUS_OK;
}

enum status bearing_probe(struct bearing *bearing, const struct soil_motion *before, const struct soil_motion *motion, struct post_rect reads,
			  const struct deform_rest *beside, size_t beside_count, const struct tile_slot *held, size_t count, struct soil_probed *out)
{
	*out = (struct soil_probed){.known = false};
	TRY(bearing_members_need(bearing, 1 + beside_count));
	TRY(open_window(bearing, reads));
	struct soil_planes reads_of = bearing->window.planes;
	if (before == NULL)
		reads_of.disturbance = NULL; /* no force depends on it, so it is not read */
	resident_host_gather(bearing->slots, held, count, &reads_of);
	if (before != NULL)
		TRY(sink_before(bearing, before, beside, beside_count));
	size_t all = 1;
	bearing->members[0].motion = *motion;
	TRY(begin_rests(bearing, 1, beside, beside_count, &all));
	return soil_probe_among(&bearing->law, &bearing->window.planes, motion, bearing->others, all - 1, bearing->members[0].work, out);
}
