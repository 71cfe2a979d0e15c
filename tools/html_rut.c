/*
 * The profile lies across the way of the first body that moved, at half the length of that way. Its samples are as far apart as the posts
 * of the working level. It extends beyond all ways that it crosses. Then it is cut to the changed part and a margin.
 */
#include "html_rut.h"

#include <math.h>
#include <string.h>

#include "store/store.h"

#define ALONG 1.0      /* m of way, or four posts, that give its direction */
#define REACH 20.0     /* m to either side: ways further away are others */
#define MARGIN 1.0     /* m, or 16 posts, beyond the outermost way of an object */
#define WIDE 3.0       /* the same where objects may be wider, and vehicles have wheels beside their way */
#define HALF_MOST 2000 /* samples to either side */
#define PART 64        /* samples that are read at once */
#define CHANGED 0.01    /* mm: less is no rut */

static enum status none(struct html_rut *rut, const char *format, ...) FURROW_PRINTF(2, 3);

static enum status none(struct html_rut *rut, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	vsnprintf(rut->why, sizeof rut->why, format, args);
	va_end(args);
	rut->count = 0;
	return STATUS_OK;
}

/* Gives the point of a way at `at` metres from its start. */
static void point_of(const struct html_body *body, double at, double point[2])
{
	size_t i = 1;
	while (i + 1 < body->count && body->way[i] < at)
		i++;
	const double length = body->way[i] - body->way[i - 1], share = length > 0 ? fmin(fmax((at - body->way[i - 1]) / length, 0), 1) : 0;
	point[0] = body->x[i - 1] + share * (body->x[i] - body->x[i - 1]);
	point[1] = body->y[i - 1] + share * (body->y[i] - body->y[i - 1]);
}

/* Finds where the profile lies. Returns false if the body moved less than two posts. */
static bool find_middle(const struct html_body *body, double spacing, struct html_rut *rut)
{
	double before[2], behind[2];
	const double length = body->count > 1 ? body->way[body->count - 1] : 0, half = fmin(fmax(ALONG, 4 * spacing), length) / 2;
	if (length < 2 * spacing)
		return false;
	point_of(body, length / 2, rut->middle);
	point_of(body, length / 2 - half, before);
	point_of(body, length / 2 + half, behind);
	const double along[2] = {behind[0] - before[0], behind[1] - before[1]}, far = hypot(along[0], along[1]);
	if (far == 0)
		return false;
	rut->left[0] = -along[1] / far;
	rut->left[1] = along[0] / far;
	rut->body = body->name;
	return true;
}

/* Returns the distance from the profile's middle to the outermost way that it crosses. */
static double outermost(const struct html_bodies *bodies, const struct html_rut *rut)
{
	double most = 0;
	for (size_t k = 0; k < bodies->count; k++) {
		const struct html_body *body = &bodies->list[k];
		for (size_t i = 0; i + 1 < body->count; i++) {
			const double x[2] = {body->x[i] - rut->middle[0], body->x[i + 1] - rut->middle[0]},
				     y[2] = {body->y[i] - rut->middle[1], body->y[i + 1] - rut->middle[1]};
			const double ahead = x[0] * rut->left[1] - y[0] * rut->left[0], then = x[1] * rut->left[1] - y[1] * rut->left[0];
			const double aside = fabs(x[0] * rut->left[0] + y[0] * rut->left[1]);
			if ((ahead <= 0) != (then <= 0) && aside <= REACH)
				most = fmax(most, aside);
		}
	}
	return most;
}

/* Interpolates between four posts. NaN if one of them is NaN. */
static double between(const double *values, int64_t wide, double x, double y)
{
	const double *at = values + (int64_t)floor(y) * wide + (int64_t)floor(x);
	const double u = x - floor(x), v = y - floor(y);
	return (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[wide] + u * at[wide + 1]);
}

/* Reads the posts around samples from .. to - 1, and interpolates. */
static enum status sample_some(struct store_reader *reader, int level, double spacing, size_t from, size_t to, double *room, struct html_rut *rut)
{
	double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
	for (size_t i = from; i < to; i++)
		for (int k = 0; k < 2; k++) {
			const double at = (rut->middle[k] + rut->across[i] * rut->left[k]) / spacing;
			low[k] = fmin(low[k], at);
			high[k] = fmax(high[k], at);
		}
	const struct post_rect rect = {(int64_t)floor(low[0]), (int64_t)floor(low[1]), (int64_t)floor(high[0]) + 2, (int64_t)floor(high[1]) + 2};
	TRY(store_read_posts(reader, STORE_OFFSET, level, rect, room));
	for (size_t i = from; i < to; i++)
		rut->change[i] = 1e3 * between(room, rect.x1 - rect.x0, (rut->middle[0] + rut->across[i] * rut->left[0]) / spacing - (double)rect.x0,
					       (rut->middle[1] + rut->across[i] * rut->left[1]) / spacing - (double)rect.y0);
	return STATUS_OK;
}

/* A store reads whole tiles, so the samples are read in parts. */
static enum status sample(struct store_reader *reader, const struct extent *extent, int level, struct html_rut *rut)
{
	const double spacing = extent_spacing(extent, level);
	double *room = mem_alloc((size_t)(PART + 3) * (PART + 3), sizeof *room);
	TRY_MEM(room, "a rut profile");
	for (size_t i = 0; i < rut->count; i++)
		rut->across[i] = ((double)i - (double)(rut->count / 2)) * spacing;
	enum status status = STATUS_OK;
	for (size_t from = 0; from < rut->count; from += PART)
		TRY_OR(done, sample_some(reader, level, spacing, from, from + PART < rut->count ? from + PART : rut->count, room, rut));
done:
	mem_free(room);
	return status;
}

/* Cuts the profile to what changed, and a margin. Sums it. */
static void cut(struct html_rut *rut, double spacing)
{
	size_t first = rut->count, last = 0;
	rut->deepest = rut->highest = rut->below = rut->above = 0;
	for (size_t i = 0; i < rut->count; i++) {
		const double change = rut->change[i];
		if (isnan(change) || fabs(change) < CHANGED)
			continue;
		first = first == rut->count ? i : first;
		last = i;
		rut->deepest = fmin(rut->deepest, change);
		rut->highest = fmax(rut->highest, change);
		rut->below -= fmin(change, 0) * spacing / 1e3;
		rut->above += fmax(change, 0) * spacing / 1e3;
	}
	if (first == rut->count) {
		(void)none(rut, "No rut profile: the ground across the way of %.80s, at its middle, is as it was", rut->body);
		return;
	}
	const size_t margin = (last - first) / 5 + 4;
	first = first > margin ? first - margin : 0;
	last = last + margin < rut->count ? last + margin : rut->count - 1;
	rut->count = last - first + 1;
	memmove(rut->across, rut->across + first, rut->count * sizeof *rut->across);
	memmove(rut->change, rut->change + first, rut->count * sizeof *rut->change);
	rut->half = fmax(fabs(rut->across[0]), fabs(rut->across[rut->count - 1]));
}

static enum status read_store(const struct html_run *run, struct store *store, const char *path, double spacing, struct html_rut *rut)
{
	struct store_run last;
	struct store_reader *reader = NULL;
	int level;
	const char *hash = html_string(run, "scene.hash");
	TRY(store_last_run(store, &last));
	if (last.scene_hash == NULL || hash == NULL || strcmp(last.scene_hash, hash) != 0 || (double)last.step != html_number(run, "steps"))
		return none(rut, "No rut profile: %.300s was changed after this drive: by another drive, a reset or a restore", path);
	if (!store_has_working_level(store, &level) || extent_spacing(&store_meta(store)->extent, level) != spacing)
		return none(rut, "No rut profile: %.300s has no ruts at this spacing", path);
	const struct extent *extent = &store_meta(store)->extent;
	for (int k = 0; k < 2; k++)
		if (!(rut->middle[k] >= 0 && rut->middle[k] <= (double)(k == 0 ? extent->width : extent->height) * extent->spacing))
			return none(rut, "No rut profile: the middle of the way of %.80s lies off the terrain", rut->body);
	TRY(store_reader_create(store, &reader));
	enum status status = sample(reader, extent, level, rut);
	store_reader_destroy(reader);
	TRY(status);
	cut(rut, spacing);
	return STATUS_OK;
}

/* A store that cannot be read does not make the report fail: another program may be writing it. */
static enum status from_store(const struct html_run *run, const char *path, double spacing, struct html_rut *rut)
{
	struct store *store = NULL;
	enum status status;
	TRY_OR(done, store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	TRY_OR(done, read_store(run, store, path, spacing, rut));
done:
	store_close(store);
	return status == STATUS_INPUT || status == STATUS_FAILED ? none(rut, "No rut profile: %.450s", failure_message()) : status;
}

enum status html_rut_read(const struct html_run *run, struct html_rut *out)
{
	const double spacing = html_number(run, "spacing");
	const char *path = html_string(run, "store.file");
	/* of vehicles, the soil geoms make the ruts */
	const struct html_bodies *bodies = run->objects.there ? &run->objects : html_ways(run);
	*out = (struct html_rut){.count = 0};
	if (!(spacing > 0) || path == NULL)
		return none(out, "No rut profile: run.json does not name the store; an older furrow made it");
	if (!bodies->there)
		return none(out, "No rut profile: no file of the folder tells where the drive went; set output.vehicles in the scene");
	if (!html_is_file(path))
		return none(out, "No rut profile: %.300s is not there any more", path);
	size_t k = 0;
	while (k < bodies->count && !find_middle(&bodies->list[k], spacing, out))
		k++;
	if (k == bodies->count)
		return none(out, "No rut profile: nothing moved by two posts (%g m)", 2 * spacing);
	const double half = ceil((outermost(bodies, out) + fmax(bodies == &run->objects ? MARGIN : WIDE, 16 * spacing)) / spacing);
	out->count = 2 * (size_t)fmin(half, HALF_MOST) + 1;
	out->across = mem_alloc(out->count, sizeof *out->across);
	out->change = mem_alloc(out->count, sizeof *out->change);
	TRY_MEM(out->across != NULL && out->change != NULL, "a rut profile");
	return from_store(run, path, spacing, out);
}

void html_rut_finish(struct html_rut *rut)
{
	mem_free_all(rut->across, rut->change);
	*rut = (struct html_rut){.count = 0};
}
