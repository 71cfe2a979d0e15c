/* What furrow view remembers of a drive: the ways of all that can be followed, and what the wheels of one vehicle did in the last seconds. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view.h"

#define APART 0.25 /* m: between two places of a way, at first */

/* Makes room for more by leaving out every second place. */
static void thin(struct view_way *way)
{
	size_t kept = 0;
	for (size_t i = 0; i < way->count; i += 2, kept++) {
		memcpy(way->places[kept], way->places[i], sizeof way->places[kept]);
		way->times[kept] = way->times[i];
	}
	way->count = kept;
	way->apart *= 2;
}

static void take_place(struct view_way *way, const struct drive *drive, size_t number)
{
	double place[3], yaw;
	const double now = drive_time(drive);
	while (way->count > 0 && way->times[way->count - 1] > now)
		way->count--;
	drive_place(drive, number, place, &yaw);
	const double *last = way->count > 0 ? way->places[way->count - 1] : NULL;
	if (last != NULL && hypot(place[0] - last[0], place[1] - last[1]) < way->apart)
		return;
	if (way->count == VIEW_PLACES)
		thin(way);
	memcpy(way->places[way->count], place, sizeof way->places[0]);
	way->times[way->count++] = now;
}

static void take_wheels(struct view_track *track, const struct drive *drive, size_t of)
{
	struct drive_wheel wheels[VIEW_WHEELS];
	const double now = drive_time(drive);
	if (of != track->of)
		track->samples = 0;
	track->of = of;
	while (track->samples > 0 && track->list[track->samples - 1].time > now)
		track->samples--;
	if (track->samples > 0 && now - track->list[track->samples - 1].time < VIEW_SPAN / (VIEW_SAMPLES - 2))
		return;
	size_t old = 0;
	while (old < track->samples && track->list[old].time < now - VIEW_SPAN)
		old++;
	track->samples -= old;
	memmove(track->list, track->list + old, track->samples * sizeof *track->list);
	track->wheels = of != SIZE_MAX ? drive_wheels(drive, of, wheels, VIEW_WHEELS) : 0;
	struct view_sample *sample = &track->list[track->samples++];
	sample->time = now;
	for (size_t i = 0; i < track->wheels; i++) {
		const char *name = strrchr(wheels[i].name, '.');
		snprintf(track->names[i], sizeof track->names[i], "%.20s", name != NULL ? name + 1 : wheels[i].name);
		sample->slip[i] = wheels[i].slip;
		sample->sinkage[i] = wheels[i].sinkage;
	}
}

enum status view_track_take(struct view_track *track, const struct drive *drive, size_t of)
{
	if (track->ways == NULL) {
		track->count = drive_followed_count(drive);
		TRY(mem_zeroed(&track->ways, track->count + 1, sizeof *track->ways, "the ways of a drive"));
		for (size_t i = 0; i < track->count; i++)
			track->ways[i].apart = APART;
	}
	for (size_t i = 0; i < track->count; i++)
		take_place(&track->ways[i], drive, i);
	take_wheels(track, drive, of);
	return STATUS_OK;
}

void view_track_finish(struct view_track *track)
{
	mem_free(track->ways);
}
