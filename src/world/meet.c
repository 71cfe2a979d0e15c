/*
 * Contacts with soil that bears, which wait until all bodies of a time are there. Then those whose windows share posts meet the ground together.
 *
 * Invariants: (1) Tiles are pinned only while a group is computed. (2) All that wait have one time, or belong to one step of hosts. (3) A body's contacts
 * keep their order: its second one is in the second round. (4) The order of bodies does not show: groups and what is in them depend on places alone.
 */
#define _GNU_SOURCE /* qsort_r */
#include <stdlib.h>
#include <string.h>

#include "world/internal.h"

#define MORE_MOST 4.0  /* a window may have so many times the posts of its contacts */

struct waiting_contact {
	struct event event;
	struct deform_contact contact;
	struct bearing_area area;
	size_t round, group;
	bool feels;
};

/* A group that is being computed. */
struct group {
	const size_t *order;              /* `count` contacts */
	size_t count;
	struct bearing_contact *contacts;
	struct bearing *hand;
	struct held_tiles held;
	struct deform_rest *rests;        /* bodies beside it */
	size_t rest_count, rest_room;
	bool whole;                       /* all its tiles are pinned at once */
};

struct meetings {
	struct waiting_contact *list;
	size_t count, room, rounds;
	uint64_t turn;                   /* how often they were computed */
	struct key_map blocks;           /* of a block: the first contact of this round whose window has posts in it */
	size_t *order;                   /* of a round, by group */
	struct bearing_contact *contacts; /* in that order */
	struct group *groups;            /* that are computed at once */
	size_t group_room;
};

enum status world_meetings_create(struct world *world)
{
	world->near.stale = true;
	if (world->bearing == NULL || !world_feels(world))
		return STATUS_OK;
	world->meetings = mem_calloc(1, sizeof *world->meetings);
	TRY_MEM(world->meetings, "contacts that wait");
	world->meetings->turn = 1;
	return STATUS_OK;
}

void world_meetings_free(struct world *world)
{
	struct meetings *m = world->meetings;
	if (m == NULL)
		return;
	key_map_finish(&m->blocks);
	mem_free(m->list);
	mem_free(m->order);
	mem_free(m->contacts);
	for (size_t i = 0; i < m->group_room; i++)
		mem_free(m->groups[i].rests);
	mem_free(m->groups);
	mem_free(m);
	world->meetings = NULL;
}

void world_meetings_forget(struct world *world)
{
	if (world->meetings != NULL)
		world->meetings->count = world->meetings->rounds = 0;
}

static enum status grow(struct meetings *m)
{
	const size_t room = m->room != 0 ? 2 * m->room : 16;
	struct waiting_contact *list = mem_realloc(m->list, room, sizeof *list);
	m->list = list != NULL ? list : m->list;
	size_t *order = mem_realloc(m->order, room, sizeof *order);
	m->order = order != NULL ? order : m->order;
	struct bearing_contact *contacts = mem_realloc(m->contacts, room, sizeof *contacts);
	m->contacts = contacts != NULL ? contacts : m->contacts;
	TRY_MEM(list != NULL && order != NULL && contacts != NULL, "contacts that wait");
	m->room = room;
	return STATUS_OK;
}

enum status world_meetings_add(struct world *world, const struct event *event, const struct deform_contact *contact, const struct bearing_area *area, bool feels)
{
	struct meetings *m = world->meetings;
	struct body *body = world_body_at(world, event->body);
	TRY(m->count == m->room ? grow(m) : STATUS_OK);
	/* The rounds of a body count while anything waits. */
	const size_t round = m->count > 0 && body->met_turn == m->turn ? body->met : 0;
	m->list[m->count++] = (struct waiting_contact){*event, *contact, *area, round, 0, feels};
	body->met_turn = m->turn;
	body->met = round + 1;
	m->rounds = round + 1 > m->rounds ? round + 1 : m->rounds;
	return STATUS_OK;
}

/* --- groups --- */

/* Returns the first contact of a group. */
static size_t first_of(const struct waiting_contact *list, size_t i)
{
	while (list[i].group != i)
		i = list[i].group;
	return i;
}

static void join(struct waiting_contact *list, size_t a, size_t b)
{
	const size_t p = first_of(list, a), q = first_of(list, b);
	list[p > q ? p : q].group = p > q ? q : p;
}

/* Joins contacts of one round whose windows share a block of posts. order: their indices. */
static enum status put_groups(struct meetings *m, size_t count)
{
	key_map_clear(&m->blocks);
	for (size_t n = 0; n < count; n++)
		m->list[m->order[n]].group = m->order[n];
	for (size_t n = 0; n < count && count > 1; n++) {
		const size_t i = m->order[n];
		const struct post_rect blocks = world_blocks_of(m->list[i].area.read);
		for (int64_t y = blocks.y0; y < blocks.y1; y++)
			for (int64_t x = blocks.x0; x < blocks.x1; x++) {
				const uint64_t key = world_block_key(x, y);
				const struct key_pair *pair = key_map_find(&m->blocks, key);
				if (pair != NULL)
					join(m->list, (size_t)pair->a, i);
				else
					TRY(key_map_put(&m->blocks, key, (double)i, 0));
			}
	}
	for (size_t n = 0; n < count; n++)
		m->list[m->order[n]].group = first_of(m->list, m->order[n]);
	return STATUS_OK;
}

static int compare(double a, double b)
{
	return a < b ? -1 : a > b;
}

/* Orders contacts by groups, and within them by place, shape and motion: the number of a body comes last. */
static int by_place(const void *a, const void *b, void *user)
{
	const struct waiting_contact *list = user, *p = &list[*(const size_t *)a], *q = &list[*(const size_t *)b];
	const struct soil_pose *u = &p->contact.to, *v = &q->contact.to;
	if (p->group != q->group)
		return p->group < q->group ? -1 : 1;
	const double first[] = {(double)u->x, (double)u->y, (double)u->z, u->yaw, u->pitch, u->roll, u->turn, p->contact.shape->kind, p->contact.shape->radius,
				p->contact.shape->width, p->contact.shape->length, p->contact.shape->size[0], p->contact.shape->tyre.stiffness, p->contact.shape->tyre.pressure, p->contact.load, p->contact.turned};
	const double second[] = {(double)v->x, (double)v->y, (double)v->z, v->yaw, v->pitch, v->roll, v->turn, q->contact.shape->kind, q->contact.shape->radius,
				 q->contact.shape->width, q->contact.shape->length, q->contact.shape->size[0], q->contact.shape->tyre.stiffness, q->contact.shape->tyre.pressure, q->contact.load, q->contact.turned};
	for (size_t k = 0; k < sizeof first / sizeof *first; k++) {
		const int order = compare(first[k], second[k]);
		if (order != 0)
			return order;
	}
	return p->event.body < q->event.body ? -1 : p->event.body > q->event.body;
}

/* --- computing --- */

static double posts_in(struct post_rect rect)
{
	return post_rect_empty(rect) ? 0 : (double)(rect.x1 - rect.x0) * (double)(rect.y1 - rect.y0);
}

/* Tells whether a group may be computed in one window. Otherwise its contacts are computed one after another, each beside the others. It does not depend
 * on tiles and slots. */
static bool fits(const struct bearing_contact *contacts, size_t count)
{
	const struct post_rect all = bearing_meeting_reads(contacts, count);
	double each = 0;
	for (size_t i = 0; i < count; i++)
		each += posts_in(contacts[i].area.read);
	return count == 1 || (count <= BEARING_TOGETHER && posts_in(all) <= MORE_MOST * each && all.x1 - all.x0 <= DEFORM_WHOLE_POSTS &&
			      all.y1 - all.y0 <= DEFORM_WHOLE_POSTS);
}

static enum status need_rests(struct group *group, size_t count)
{
	if (count <= group->rest_room)
		return STATUS_OK;
	struct deform_rest *rests = mem_realloc(group->rests, 2 * count, sizeof *rests);
	TRY_MEM(rests, "bodies near each other");
	group->rests = rests;
	group->rest_room = 2 * count;
	return STATUS_OK;
}

/* Lists the bodies beside a group. */
static enum status list_beside(struct world *world, struct group *group)
{
	const struct meetings *m = world->meetings;
	struct near_table *near = &world->near;
	struct post_rect area = {0, 0, 0, 0};
	group->rest_count = 0;
	if (near->stale)
		TRY(world_near_make(world));
	for (size_t i = 0; i < group->count; i++)
		area = post_rect_joined(area, group->contacts[i].area.write);
	world_near_find(world, area);
	TRY(need_rests(group, near->found_count));
	for (size_t i = 0; i < near->found_count; i++) {
		bool is_member = false;
		for (size_t k = 0; k < group->count && !is_member; k++)
			is_member = m->list[group->order[k]].event.body == near->found[i].body;
		if (!is_member)
			group->rests[group->rest_count++] = near->found[i].rest;
	}
	return STATUS_OK;
}

/* Tells changes of one contact. */
static enum status tell(struct world *world, const struct waiting_contact *waiting, const struct bearing_contact *done, const struct held_tiles *held)
{
	const struct deform_window window = {.read = waiting->area.read, .write = waiting->area.write};
	if (waiting->feels || post_rect_empty(done->changed))
		return STATUS_OK;
	enum status status;
	TRY_OR(done, world_tell_contact(world, &waiting->event, &waiting->contact, &window, 1));
	TRY_OR(done, world_mark(world, done->changed, held));
done:
	world_happened_relaxes(world);
	return status;
}

static void count_windows(struct world *world, const struct waiting_contact *waiting, const struct bearing_contact *done)
{
	/* What a body does not touch it does not change. */
	const size_t computed = world->params.everywhere || !post_rect_empty(done->changed);
	if (waiting->feels)
		return;
	world_count_windows(world_body_at(world, waiting->event.body), &waiting->contact, computed);
	world->counts.windows.due++;
	world->counts.windows.computed += computed;
}

/* Puts back what the held tiles have of what changed. */
static enum status put_back(struct world *world, const struct group *group, const struct held_tiles *held)
{
	TRY(bearing_meeting_scatter(group->hand, group->contacts, group->count, held->tiles, held->count));
	for (size_t i = 0; i < group->count; i++)
		TRY(tell(world, &world->meetings->list[group->order[i]], &group->contacts[i], held));
	return STATUS_OK;
}

static enum status one_tile(struct world *world, const struct group *group, struct tile tile, bool gathers)
{
	struct held_tiles held;
	enum status status = STATUS_OK;
	TRY(world_hold_tile(world, tile, &held));
	if (gathers)
		bearing_meeting_gather(group->hand, held.tiles, held.count);
	else
		status = put_back(world, group, &held);
	world_release(world, &held);
	return status;
}

/* Goes over the tiles of a window one by one: it may have more of them than there are slots. */
static enum status each_tile(struct world *world, const struct group *group, bool gathers)
{
	const struct post_rect reads = bearing_meeting_reads(group->contacts, group->count);
	struct tile first, last;
	if (!tile_range_of(&world->resident.meta->extent, world->resident.level, reads, &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			TRY(one_tile(world, group, (struct tile){world->resident.level, x, y}, gathers));
	return STATUS_OK;
}

/* Pins the tiles of a group, or gathers it if they are too many. */
static enum status begin(struct world *world, struct group *group)
{
	const struct post_rect reads = bearing_meeting_reads(group->contacts, group->count);
	TRY(list_beside(world, group));
	TRY(bearing_meeting_begin(group->hand, group->contacts, group->count, group->whole));
	return group->whole ? world_hold(world, reads, &group->held) : each_tile(world, group, true);
}

/* Computes a group. Any thread of the crew. */
static enum status compute(void *user, size_t member, size_t number)
{
	struct group *group = (struct group *)user + number;
	(void)member;
	if (group->whole)
		bearing_meeting_gather(group->hand, group->held.tiles, group->held.count);
	return bearing_meeting_compute(group->hand, group->contacts, group->count, group->rests, group->rest_count);
}

static enum status end(struct world *world, struct group *group)
{
	const struct meetings *m = world->meetings;
	TRY(group->whole ? put_back(world, group, &group->held) : each_tile(world, group, false));
	for (size_t i = 0; i < group->count; i++) {
		const struct waiting_contact *waiting = &m->list[group->order[i]];
		world_forces_felt(world->forces, waiting->event.body, &waiting->event, &group->contacts[i].forces);
		world_thrown_take(world, waiting->event.time, &group->contacts[i]);
		world_falls_take(world, world_body_at(world, waiting->event.body), &waiting->contact.to, waiting->event.time);
		count_windows(world, waiting, &group->contacts[i]);
	}
	return STATUS_OK;
}

/* Computes groups that share no post. */
static enum status compute_groups(struct world *world, size_t count)
{
	struct group *groups = world->meetings->groups;
	enum status status;
	for (size_t i = 0; i < count; i++)
		groups[i].held.count = 0;
	for (size_t i = 0; i < count; i++)
		TRY_OR(done, begin(world, &groups[i]));
	TRY_OR(done, world_crew_run(world, count, compute, groups));
	TRY_OR(done, bearing_hands_join(world->bearing));
	for (size_t i = 0; i < count; i++) {
		TRY_OR(done, end(world, &groups[i]));
		world_release(world, &groups[i].held); /* the next may need its slots */
	}
done:
	for (size_t i = 0; i < count; i++)
		world_release(world, &groups[i].held);
	return status;
}

/* --- rounds --- */

static enum status need_groups(struct world *world, size_t count)
{
	struct meetings *m = world->meetings;
	if (count <= m->group_room)
		return STATUS_OK;
	struct group *groups = mem_realloc(m->groups, count, sizeof *groups);
	TRY_MEM(groups, "contacts that wait");
	m->groups = groups;
	for (; m->group_room < count; m->group_room++) {
		groups[m->group_room].rests = NULL;
		groups[m->group_room].rest_room = 0;
	}
	return STATUS_OK;
}

/* Takes the contacts from order[first] to before order[last] as one group. */
static void put_group(struct world *world, size_t number, size_t first, size_t last)
{
	struct meetings *m = world->meetings;
	struct group *group = &m->groups[number];
	group->order = &m->order[first];
	group->count = last - first;
	group->contacts = &m->contacts[first];
	group->hand = bearing_hand(world->bearing, number);
	group->whole = group->count == 1 || world_tiles_in(world, bearing_meeting_reads(group->contacts, group->count)) <= world->counts.windows.tiles;
}

/* Returns where the group ends that begins at order[first]. */
static size_t group_end(const struct meetings *m, size_t first, size_t count)
{
	size_t last = first + 1;
	while (last < count && m->list[m->order[last]].group == m->list[m->order[first]].group)
		last++;
	return last;
}

/* A group that does not fit one window: its contacts are computed one after another, each beside the others. */
static enum status one_by_one(struct world *world, size_t first, size_t last)
{
	for (size_t i = first; i < last; i++) {
		put_group(world, 0, i, i + 1);
		TRY(compute_groups(world, 1));
	}
	return STATUS_OK;
}

static enum status compute_round(struct world *world, size_t round)
{
	struct meetings *m = world->meetings;
	size_t count = 0;
	double posts = 0;
	for (size_t i = 0; i < m->count; i++)
		if (m->list[i].round == round)
			m->order[count++] = i;
	TRY(put_groups(m, count));
	if (count > 1)
		qsort_r(m->order, count, sizeof *m->order, by_place, m->list);
	for (size_t i = 0; i < count; i++) {
		const struct waiting_contact *waiting = &m->list[m->order[i]];
		m->contacts[i] = (struct bearing_contact){.contact = &waiting->contact, .area = waiting->area, .feels = waiting->feels};
		posts += posts_in(waiting->area.read);
	}
	const size_t hands = world_hands_for(world, posts), most = world->facts.limits.slots / 2;
	TRY(need_groups(world, hands));
	for (size_t first = 0; first < count;) {
		size_t groups = 0, tiles = 0;
		while (first < count && groups < hands) {
			const size_t last = group_end(m, first, count), more = world_tiles_in(world, bearing_meeting_reads(&m->contacts[first], last - first));
			if (groups > 0 && tiles + more > most)
				break;
			if (fits(&m->contacts[first], last - first)) {
				put_group(world, groups++, first, last);
				tiles += more;
			} else if (groups == 0) {
				TRY(one_by_one(world, first, last));
			} else {
				break;
			}
			first = last;
		}
		if (groups > 0)
			TRY(compute_groups(world, groups));
	}
	return STATUS_OK;
}

enum status world_meetings_flush(struct world *world)
{
	struct meetings *m = world->meetings;
	if (m == NULL || m->count == 0)
		return STATUS_OK;
	m->turn++;
	enum status status = STATUS_OK;
	for (size_t round = 0; round < m->rounds; round++)
		TRY_OR(done, compute_round(world, round));
done:
	world_meetings_forget(world);
	return status;
}
