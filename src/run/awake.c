/*
 * The ground at large: every `interval` of simulated time it slides on where it is awake, after the stations of the
 * same time. The tiles of a block are pinned while it is gathered and while it is scattered, no longer.
 */
#include <math.h>

#include "run/internal.h"

/* Intervals that are over at `time`: those at multiples of it, from the first. */
static int64_t intervals_by(const struct drive *drive, double time)
{
	double interval = drive->scene->interval, whole = floor(time / interval);
	if (!deform_conserves(drive->scene->model) || !(whole < 0x1p52)) /* none, or more than there are */
		return 0;
	int64_t count = (int64_t)whole;
	while ((double)(count + 1) * interval <= time)
		count++;
	while (count > 0 && (double)count * interval > time)
		count--;
	return count;
}

void drive_intervals_from(struct drive *drive, double time)
{
	drive->intervals = intervals_by(drive, time);
}

enum status drive_wake_all(struct drive *drive)
{
	const struct world *world = &drive->meta->world;
	const struct post_rect all = {0, 0, world_posts(world->width, drive->level), world_posts(world->height, drive->level)};
	return deform_wake(drive->deform, all);
}

static size_t rests_of(const struct drive *drive)
{
	size_t count = 0;
	for (size_t i = 0; i < drive->scene->object_count; i++)
		if (drive->riders[i].in_contact)
			drive->rests[count++] = (struct deform_rest){&drive->riders[i].object->shape, drive->riders[i].last,
								     drive->riders[i].carrier};
	return count;
}

static enum status one_interval(struct drive *drive, size_t *blocks)
{
	struct held_tiles held = {.count = 0};
	enum status status = deform_interval_begin(drive->deform, drive->rests, rests_of(drive), blocks);
	for (size_t i = 0; i < *blocks && status == STATUS_OK; i++) {
		status = drive_hold(drive, deform_interval_reads(drive->deform, i), &held);
		if (status == STATUS_OK)
			status = deform_interval_gather(drive->deform, i, held.tiles, held.count);
		drive_release(drive, &held);
	}
	for (size_t i = 0; i < *blocks && status == STATUS_OK; i++) {
		struct post_rect writes = deform_interval_writes(drive->deform, i);
		status = drive_hold(drive, writes, &held);
		if (status == STATUS_OK)
			status = deform_interval_scatter(drive->deform, i, held.tiles, held.count);
		if (status == STATUS_OK)
			status = drive_mark(drive, writes, &held);
		drive_release(drive, &held);
	}
	if (status == STATUS_OK && *blocks > 0)
		status = deform_interval_end(drive->deform);
	struct page_stats pages;
	int64_t side = (drive->meta->world.cells + DEFORM_BLOCK - 1) / DEFORM_BLOCK;
	page_cache_stats(drive->cache, &pages);
	drive->blocks_visited += *blocks;
	drive->blocks_possible += pages.touched * (uint64_t)(side * side);
	return status;
}

enum status drive_intervals(struct drive *drive, double time, bool at_it)
{
	if (drive->deform == NULL || !deform_conserves(drive->scene->model))
		return STATUS_OK;
	enum status status = STATUS_OK;
	int64_t over = intervals_by(drive, time);
	if (!at_it && over > 0 && (double)over * drive->scene->interval >= time)
		over--;
	while (drive->intervals < over && status == STATUS_OK) {
		size_t blocks;
		status = one_interval(drive, &blocks);
		/* Where nothing is awake nothing wakes by itself. */
		drive->intervals = blocks > 0 ? drive->intervals + 1 : over;
	}
	return status;
}

enum status drive_let_go(struct drive *drive, const struct rider *rider)
{
	const struct deform_sweep rest = {.shape = &rider->object->shape, .from = rider->last, .to = rider->last};
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count = 0;
	if (!rider->in_contact || !deform_conserves(drive->scene->model))
		return STATUS_OK;
	enum status status = deform_windows(drive->deform, &rest, windows, &count);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = deform_wake(drive->deform, windows[i].write);
	return status;
}
