/*
 * Soil in flight: contacts throw grains (src/bearing/throws.h), which fly until they meet the ground, and land there as deposited soil.
 *
 * Grains are looked at every WORLD_THROWN_TICKS-th of a second of simulated time, whatever the steps are. Of a grain that is below the ground then, the last place
 * above it is found by halving. A ridge that is thinner than the way of a tick may be flown through.
 *
 * Each tick is looked at once, whether grains fly or not. So it does not show if others flew when a grain left.
 *
 * Invariants: (1) What was thrown is what landed, was lost, and is in flight, to the unit. (2) In the tally soil in flight counts as compacted. So does what was lost:
 * beyond the world's edge, in a hole, or where no post was free. So offsets + compacted = 0 holds at any time, and in every store. (3) All grains of a tick are
 * looked at before the first one lands. So their order does not show.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world/internal.h"

#define TICK_BITS (THROWN_BITS - 6) /* a tick is 2^-6 s */
_Static_assert(1 << (THROWN_BITS - TICK_BITS) == WORLD_THROWN_TICKS, "ticks");
#define HALVINGS 12       /* a place of landing is known to a tick's way / 2^12 */
#define INTERPOLATES 14   /* bits of a place in its cell */
#define DEEP (INT64_C(64) << OFFSET_BITS) /* m x 2^20: so far below where it left a grain over a hole is lost */
#define LAND_POSTS 4096   /* landings that together need more posts are put down in parts */

struct thrown {
	struct bearing_grain *list; /* room for WORLD_THROWN_MOST */
	size_t count;
	int64_t ticks;           /* those that are over */
	struct record_thrown sums;
	struct bearing_landing *landings; /* as many */
	int32_t gravity;         /* 2^-20 m/s2 */
	/* Of many ranks: each has grains of its own, and its own share of the sums. */
	size_t most;             /* grains at once, since world_grains_most_here() was called last */
	struct {
		struct record_thrown sums; /* of all other ranks, after step `step`; -1: not known yet */
		struct bearing_grain *list;
		size_t count;
		int64_t step;
	} others;
};

size_t world_grains_most(const struct world *world)
{
	return scene_throws(world->scene) && world_feels(world) ? WORLD_THROWN_MOST : 0;
}

enum status world_thrown_make(struct world *world)
{
	if (world_grains_most(world) == 0)
		return STATUS_OK;
	struct thrown *thrown;
	TRY(mem_zeroed(&thrown, 1, sizeof *thrown, "thrown soil"));
	world->thrown = thrown;
	thrown->gravity = (int32_t)lround(world->scene->gravity * 0x1p20);
	thrown->others.step = -1;
	TRY(mem_make(&thrown->list, WORLD_THROWN_MOST, sizeof *thrown->list, "thrown soil"));
	if (world->ranks != NULL)
		TRY(mem_make(&thrown->others.list, WORLD_THROWN_MOST, sizeof *thrown->list, "thrown soil"));
	return mem_make(&thrown->landings, WORLD_THROWN_MOST, sizeof *thrown->landings, "thrown soil");
}

void world_thrown_free(struct thrown *thrown)
{
	if (thrown != NULL)
		mem_free_all(thrown->list, thrown->landings, thrown->others.list, thrown);
}

bool world_thrown_flies(const struct world *world)
{
	return world->thrown != NULL && world->thrown->count > 0;
}

uint64_t world_grains_bytes(const struct world *world)
{
	const size_t grain = 2 * sizeof(struct bearing_grain) + sizeof(struct bearing_landing); /* flying, and in the record */
	return world_grains_most(world) > 0 ? sizeof(struct thrown) + world_grains_most(world) * grain : 0;
}

void world_thrown_plan(const struct world *world, struct plan *plan)
{
	if (world_grains_most(world) > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_ONCE, .effect = scene_effect_row(EFFECT_THROWN)->name, .object = -1, .amount = 1, .bytes = world_grains_bytes(world)},
			 "grains in flight");
}

/* --- contacts throw --- */

void world_thrown_add(struct world *world, const struct bearing_grain *grains, size_t count)
{
	struct thrown *thrown = world->thrown;
	thrown->most = thrown->count + count > thrown->most ? thrown->count + count : thrown->most;
	for (size_t i = 0; i < count; i++)
		if (thrown->count < WORLD_THROWN_MOST)
			thrown->list[thrown->count++] = grains[i];
		else
			thrown->list[thrown->count - 1].volume += grains[i].volume;
}

void world_thrown_take(struct world *world, double time, const struct bearing_contact *contact)
{
	struct bearing_grain grains[THROWN_GRAINS];
	if (world->thrown == NULL || contact->feels || contact->thrown == 0)
		return;
	const int soil = contact->thrown_class < SOIL_CLASSES ? contact->thrown_class : SOIL_CLASSES - 1;
	const int64_t now = llround(time * 0x1p20);
	const int count = bearing_throw_grains(&contact->throws, contact->thrown_from, fmax(contact->forces.sinkage, 0), now, contact->thrown, grains);
	world->thrown->sums.thrown[soil] += contact->thrown;
	world_thrown_add(world, grains, (size_t)count);
}

void world_thrown_count(struct world *world, const int64_t classes[SOIL_CLASSES])
{
	for (int i = 0; i < SOIL_CLASSES; i++)
		world->thrown->sums.thrown[i] += classes[i];
}

/* --- flight --- */

enum where { IN_AIR, IN_GROUND, OVER_HOLE, BEYOND };

/* The tile that was looked at last: it is pinned. */
struct look {
	struct world *world;
	struct held_tiles held;
	struct host_slot slot;
	struct tile tile;
	int64_t zero;           /* 2^-20 m: height of the reference */
	int64_t cells_x, cells_y; /* of the world */
	double cells;           /* 2^-INTERPOLATES cells in 2^-20 m */
	bool catches;           /* grains may come down on bodies */
};

static enum status look_at_tile(struct look *look, int64_t x, int64_t y)
{
	struct world *world = look->world;
	const int64_t cells = world->resident.meta->extent.cells;
	const struct tile tile = {world->resident.level, (uint32_t)(x / cells), (uint32_t)(y / cells)};
	if (look->held.count > 0 && tile.x == look->tile.x && tile.y == look->tile.y)
		return STATUS_OK;
	world_release(world, &look->held);
	TRY(world_hold_tile(world, tile, &look->held));
	resident_host_get(world->resident.host, look->held.tiles[0].slot, &look->slot);
	look->tile = tile;
	return STATUS_OK;
}

static enum status look_at(struct look *look, const int64_t place[3], enum where *where)
{
	const int64_t cells = look->world->resident.meta->extent.cells, mask = (1 << INTERPOLATES) - 1;
	/* By products: a function of the library for each rounding would cost as much as all else. */
	const int64_t fine_x = (int64_t)((double)place[0] * look->cells), fine_y = (int64_t)((double)place[1] * look->cells);
	const int64_t x = fine_x >> INTERPOLATES, y = fine_y >> INTERPOLATES;
	const uint32_t east = (uint32_t)(fine_x & mask), north = (uint32_t)(fine_y & mask);
	*where = BEYOND;
	if (place[0] < 0 || place[1] < 0 || x >= look->cells_x || y >= look->cells_y)
		return STATUS_OK;
	TRY(look_at_tile(look, x, y));
	const size_t side = (size_t)cells + 1, at = (size_t)(y % cells) * side + (size_t)(x % cells);
	const int32_t *base = look->slot.base + at, *offset = look->slot.planes[PLANE_OFFSET];
	const int32_t under = lattice_interpolate(base[0], base[1], base[side], base[side + 1], east, north, INTERPOLATES);
	*where = OVER_HOLE;
	if (under == BASE_NODATA)
		return STATUS_OK;
	int64_t ground = look->zero + 4 * (int64_t)under;
	if (offset != NULL)
		ground += lattice_interpolate(offset[at], offset[at + 1], offset[at + side], offset[at + side + 1], east, north, INTERPOLATES);
	*where = place[2] > ground ? IN_AIR : IN_GROUND;
	return STATUS_OK;
}

/* Finds the last place above the ground before `until`, at which the grain is below. */
static enum status find_landing(struct look *look, const struct bearing_grain *grain, int64_t until, struct bearing_landing *landing)
{
	int64_t low = grain->flown, high = until, place[3];
	enum where where;
	for (int i = 0; i < HALVINGS && high - low > 1; i++) {
		const int64_t middle = low + (high - low) / 2;
		bearing_grain_at(grain, look->world->thrown->gravity, middle, place);
		TRY(look_at(look, place, &where));
		*(where == IN_GROUND ? &high : &low) = middle;
	}
	bearing_grain_at(grain, look->world->thrown->gravity, low, place);
	*landing = (struct bearing_landing){place[0], place[1], grain->volume};
	return STATUS_OK;
}

/* Lets a grain fly until a time. *stays: it is still in flight. */
static enum status fly(struct look *look, struct bearing_grain *grain, int64_t until, size_t *landed, bool *stays)
{
	struct thrown *thrown = look->world->thrown;
	const int64_t flown = until - grain->since;
	int64_t place[3];
	enum where where = BEYOND;
	*stays = flown <= grain->flown;
	if (*stays)
		return STATUS_OK;
	if (look->catches && flown <= GRAIN_LONGEST) {
		int64_t before[3];
		bearing_grain_at(grain, thrown->gravity, grain->flown, before);
		bearing_grain_at(grain, thrown->gravity, flown, place);
		if (world_falls_caught(look->world, before, place, grain->volume)) {
			thrown->sums.landed += grain->volume;
			return STATUS_OK;
		}
	}
	if (flown <= GRAIN_LONGEST) {
		bearing_grain_at(grain, thrown->gravity, flown, place);
		TRY(look_at(look, place, &where));
		*stays = where == IN_AIR || (where == OVER_HOLE && place[2] > grain->from[2] - DEEP);
	}
	if (*stays)
		grain->flown = (int32_t)flown;
	else if (where == IN_GROUND)
		TRY(find_landing(look, grain, flown, &thrown->landings[(*landed)++]));
	else
		thrown->sums.lost += grain->volume;
	return STATUS_OK;
}

/* --- landing --- */

/* Orders landings by blocks of posts, so that those near each other are put down together. */
static int by_place(const void *a, const void *b)
{
	const struct bearing_landing *p = a, *q = b;
	const int64_t first[] = {p->y >> 20, p->x >> 20, p->y, p->x, p->volume}, second[] = {q->y >> 20, q->x >> 20, q->y, q->x, q->volume};
	for (int k = 0; k < 5; k++)
		if (first[k] != second[k])
			return first[k] < second[k] ? -1 : 1;
	return 0;
}

static enum status land(struct world *world, const struct bearing_landing *landings, size_t count, size_t rests)
{
	const struct post_rect posts = bearing_thrown_posts(world->bearing, landings, count);
	struct record_thrown *sums = &world->thrown->sums;
	struct held_tiles held;
	struct post_rect changed;
	int64_t lost, all = 0;
	enum status status;
	for (size_t i = 0; i < count; i++)
		all += landings[i].volume;
	TRY(world_hold(world, posts, &held));
	TRY_OR(done, bearing_thrown_land(world->bearing, landings, count, world->relaxation.rests, rests, held.tiles, held.count, &changed, &lost));
	sums->lost += lost;
	sums->landed += all - lost;
	if (!post_rect_empty(changed))
		TRY_OR(done, world_mark(world, changed, &held));
done:
	world_release(world, &held);
	return status;
}

static enum status land_all(struct world *world, size_t count, size_t rests)
{
	const struct bearing_landing *landings = world->thrown->landings;
	qsort(world->thrown->landings, count, sizeof *landings, by_place);
	for (size_t first = 0, last; first < count; first = last) {
		struct post_rect posts = {0, 0, 0, 0};
		for (last = first; last < count; last++) {
			posts = post_rect_joined(posts, bearing_thrown_posts(world->bearing, landings + last, 1));
			if (last > first && (posts.x1 - posts.x0) * (posts.y1 - posts.y0) > LAND_POSTS)
				break;
		}
		TRY(land(world, landings + first, last - first, rests));
	}
	return STATUS_OK;
}

/* --- ticks --- */

/* Returns the class of which most was thrown so far: grains have none, and what bodies carry has. */
static int most_thrown(const struct thrown *thrown)
{
	int most = 0;
	for (int i = 1; i < SOIL_CLASSES; i++)
		most = thrown->sums.thrown[i] > thrown->sums.thrown[most] ? i : most;
	return most;
}

static enum status tick(struct world *world, int64_t until, size_t rests)
{
	struct thrown *thrown = world->thrown;
	const struct extent *extent = &world->resident.meta->extent;
	struct look look = {
		.world = world, .zero = (int64_t)world->surface.reference * ((int64_t)1 << OFFSET_BITS),
		.cells = (1 << INTERPOLATES) / (world->resident.spacing * 0x1p20),
		.catches = world_carries(world), .cells_x = extent_posts(extent->width, world->resident.level) - 1, .cells_y = extent_posts(extent->height, world->resident.level) - 1,
	};
	size_t landed = 0, stay = 0;
	enum status status;
	for (size_t i = 0; i < thrown->count; i++) {
		bool stays;
		TRY_OR(done, fly(&look, &thrown->list[i], until, &landed, &stays));
		if (stays)
			thrown->list[stay++] = thrown->list[i];
	}
	thrown->count = stay;
	status = STATUS_OK;
done:
	world_release(world, &look.held);
	TRY(status);
	if (look.catches)
		world_falls_aboard(world, most_thrown(thrown));
	return landed > 0 ? land_all(world, landed, rests) : STATUS_OK;
}

/* Returns the last tick before `time`, or at it. */
static int64_t tick_before(double time, bool at_it)
{
	const double ticks = time * WORLD_THROWN_TICKS, whole = floor(ticks);
	return (int64_t)whole - (!at_it && !(whole < ticks));
}

void world_thrown_from(struct world *world, double time)
{
	if (world->thrown != NULL)
		world->thrown->ticks = tick_before(time, true);
}

enum status world_thrown_until(struct world *world, double time, bool at_it)
{
	struct thrown *thrown = world->thrown;
	const int64_t last = tick_before(time, at_it);
	const size_t rests = thrown->ticks < last && thrown->count > 0 ? world_rests(world) : 0;
	while (thrown->ticks < last && thrown->count > 0) {
		TRY(tick(world, (thrown->ticks + 1) << TICK_BITS, rests));
		thrown->ticks++;
	}
	thrown->ticks = thrown->ticks > last ? thrown->ticks : last;
	return STATUS_OK;
}

/* --- the record, and checkpoints --- */

static void add_sums(struct record_thrown *to, const struct record_thrown *from)
{
	for (int i = 0; i < SOIL_CLASSES; i++)
		to->thrown[i] += from->thrown[i];
	to->landed += from->landed;
	to->lost += from->lost;
}

void world_thrown_record(const struct world *world, struct record *record)
{
	const struct thrown *thrown = world->thrown;
	if (thrown == NULL)
		return;
	struct bearing_grain *grains = world_record_grains(record, world->scene->object_count);
	const size_t room = record->thrown.room, left = WORLD_THROWN_MOST - thrown->count, others = thrown->others.count < left ? thrown->others.count : left;
	record->thrown = thrown->sums;
	add_sums(&record->thrown, &thrown->others.sums);
	record->thrown.room = room;
	record->thrown.count = thrown->count + others;
	if (thrown->count > 0)
		memcpy(grains, thrown->list, thrown->count * sizeof *thrown->list);
	if (others > 0)
		memcpy(grains + thrown->count, thrown->others.list, others * sizeof *grains);
}

static int64_t volume_of(const struct bearing_grain *grains, size_t count)
{
	int64_t volume = 0;
	for (size_t i = 0; i < count; i++)
		volume += grains[i].volume;
	return volume;
}

static int64_t all_thrown(const struct record_thrown *sums)
{
	int64_t all = 0;
	for (int i = 0; i < SOIL_CLASSES; i++)
		all += sums->thrown[i];
	return all;
}

enum status world_thrown_resume(struct world *world)
{
	struct record *record = world->record;
	struct thrown *thrown = world->thrown;
	const struct bearing_grain *grains = world_record_grains(record, world->scene->object_count);
	const int64_t now = llround(record->time * 0x1p20);
	if (thrown == NULL)
		return STATUS_OK;
	for (size_t i = 0; i < record->thrown.count; i++)
		if (grains[i].since > now || grains[i].flown > now - grains[i].since)
			return world_record_damaged(world->facts.path, "soil in flight that has flown beyond its time");
	if (all_thrown(&record->thrown) != record->thrown.landed + record->thrown.lost + volume_of(grains, record->thrown.count))
		return world_record_damaged(world->facts.path, "thrown soil whose sum is wrong");
	if (world->ranks != NULL && world->ranks->rank > 0) /* the first rank has all at the start */
		return STATUS_OK;
	thrown->sums = record->thrown;
	thrown->count = record->thrown.count;
	if (thrown->count > 0)
		memcpy(thrown->list, grains, thrown->count * sizeof *grains);
	return STATUS_OK;
}

struct thrown_saved {
	struct record_thrown sums;
	int64_t ticks;
	size_t count;
	struct bearing_grain grains[];
};

enum status world_thrown_save(const struct world *world, struct thrown_saved **out)
{
	const struct thrown *thrown = world->thrown;
	*out = NULL;
	if (thrown == NULL)
		return STATUS_OK;
	TRY(mem_make(out, 1, sizeof **out + thrown->count * sizeof *thrown->list, "a checkpoint"));
	(*out)->sums = thrown->sums;
	(*out)->ticks = thrown->ticks;
	(*out)->count = thrown->count;
	if (thrown->count > 0)
		memcpy((*out)->grains, thrown->list, thrown->count * sizeof *thrown->list);
	return STATUS_OK;
}

void world_thrown_restore(struct world *world, const struct thrown_saved *saved)
{
	struct thrown *thrown = world->thrown;
	if (thrown == NULL)
		return;
	thrown->sums = saved->sums;
	thrown->ticks = saved->ticks;
	thrown->count = saved->count;
	if (thrown->count > 0)
		memcpy(thrown->list, saved->grains, thrown->count * sizeof *thrown->list);
}

/* --- other ranks --- */

_Static_assert(GRAIN_NUMBERS == WORLD_GRAIN_NUMBERS && SOIL_CLASSES + 2 == WORLD_THROWN_SUMS, "messages");

size_t world_grains_here(const struct world *world)
{
	return world->thrown != NULL ? world->thrown->count : 0;
}

struct post_rect world_grain_area(const struct world *world, size_t number, double until)
{
	const struct thrown *thrown = world->thrown;
	const struct bearing_grain *grain = &thrown->list[number];
	const int64_t flies = llround(until * 0x1p20) - grain->since, intervals = world_intervals_due(world, until);
	int64_t from[3], to[3];
	bearing_grain_at(grain, thrown->gravity, grain->flown, from);
	bearing_grain_at(grain, thrown->gravity, flies < grain->flown ? grain->flown : flies < GRAIN_LONGEST ? flies : GRAIN_LONGEST, to);
	const struct bearing_landing ends[] = {{.x = from[0], .y = from[1]}, {.x = to[0], .y = to[1]}};
	const struct post_rect area = bearing_thrown_posts(world->bearing, ends, 2);
	return post_rect_empty(area) || intervals <= 0 ? area : world_slides_from(world, area, intervals);
}

void world_grain_pack(const struct world *world, size_t number, struct world_grain_moved *moved)
{
	bearing_grain_save(&world->thrown->list[number], moved->numbers);
}

enum status world_grain_unpack(struct world *world, const struct world_grain_moved *moved)
{
	struct bearing_grain grain;
	if (world->thrown == NULL || !bearing_grain_load(moved->numbers, &grain))
		return fail_with(STATUS_FAILED, "ranks: soil in flight that came is damaged; start all ranks with the same version of furrow");
	world_thrown_add(world, &grain, 1);
	return STATUS_OK;
}

void world_grains_keep(struct world *world, const bool *stays)
{
	struct thrown *thrown = world->thrown;
	size_t count = 0;
	for (size_t i = 0; i < thrown->count; i++)
		if (stays[i])
			thrown->list[count++] = thrown->list[i];
	thrown->count = count;
}

size_t world_grains_most_here(struct world *world)
{
	if (world->thrown == NULL)
		return 0;
	const size_t most = world->thrown->most > world->thrown->count ? world->thrown->most : world->thrown->count;
	world->thrown->most = world->thrown->count;
	return most;
}

void world_thrown_share(const struct world *world, int64_t sums[WORLD_THROWN_SUMS])
{
	const struct record_thrown *from = &world->thrown->sums;
	memcpy(sums, from->thrown, sizeof from->thrown);
	sums[SOIL_CLASSES] = from->landed;
	sums[SOIL_CLASSES + 1] = from->lost;
}

void world_thrown_others_begin(struct world *world)
{
	if (world->thrown == NULL)
		return;
	world->thrown->others.sums = (struct record_thrown){.room = 0};
	world->thrown->others.count = 0;
	world->thrown->others.step = world->step;
}

void world_thrown_others_sums(struct world *world, const int64_t sums[WORLD_THROWN_SUMS])
{
	struct record_thrown from = {.landed = sums[SOIL_CLASSES], .lost = sums[SOIL_CLASSES + 1]};
	memcpy(from.thrown, sums, sizeof from.thrown);
	add_sums(&world->thrown->others.sums, &from);
}

enum status world_thrown_others_grain(struct world *world, const struct world_grain_moved *moved)
{
	struct thrown *thrown = world->thrown;
	struct bearing_grain grain;
	if (!bearing_grain_load(moved->numbers, &grain))
		return fail_with(STATUS_FAILED, "ranks: soil in flight that was told is damaged; start all ranks with the same version of furrow");
	if (thrown->others.count < WORLD_THROWN_MOST) /* fleet refuses more */
		thrown->others.list[thrown->others.count++] = grain;
	return STATUS_OK;
}

/* --- what is told --- */

bool world_thrown_figures(const struct world *world, struct world_thrown_figures *figures)
{
	const struct thrown *thrown = world->thrown;
	if (thrown == NULL || (world->ranks != NULL && thrown->others.step != world->step))
		return false;
	const double unit = lattice_offset_metres(1) * world->resident.spacing * world->resident.spacing;
	struct record_thrown sums = thrown->sums;
	add_sums(&sums, &thrown->others.sums);
	*figures = (struct world_thrown_figures){
		.grains = thrown->count + thrown->others.count, .thrown = all_thrown(&sums), .landed = sums.landed, .lost = sums.lost,
		.flying = volume_of(thrown->list, thrown->count) + volume_of(thrown->others.list, thrown->others.count),
	};
	for (int i = 0; i < world->scene->soil_count; i++) {
		const struct soil_numbers *soil = &world->scene->soils[i];
		const double density = !isnan(soil->unit_weight) ? soil->unit_weight / world->scene->gravity : !isnan(soil->density) ? soil->density : SOIL_USUAL_DENSITY;
		figures->mass += (double)sums.thrown[i] * unit * density;
	}
	return true;
}

size_t world_grains(const struct world *world, size_t room, struct world_grain *grains)
{
	const struct thrown *thrown = world->thrown;
	const int64_t now = llround(world->time * 0x1p20);
	const double unit = lattice_offset_metres(1) * world->resident.spacing * world->resident.spacing;
	for (size_t i = 0; thrown != NULL && i < thrown->count && i < room; i++) {
		const struct bearing_grain *grain = &thrown->list[i];
		const int64_t flown = now - grain->since;
		int64_t place[3];
		bearing_grain_at(grain, thrown->gravity, flown < 0 ? 0 : flown < GRAIN_LONGEST ? flown : GRAIN_LONGEST, place);
		grains[i] = (struct world_grain){.radius = cbrt((double)grain->volume * unit * 0.75 / M_PI),
						  .number = (uint32_t)grain->velocity[0] ^ (uint32_t)grain->velocity[1] << 7 ^ (uint32_t)grain->from[0]};
		for (int k = 0; k < 3; k++)
			grains[i].at[k] = lattice_offset_metres(place[k]);
	}
	return thrown != NULL ? thrown->count : 0;
}
