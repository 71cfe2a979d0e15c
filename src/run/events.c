/* What is due in a step: stations of all objects in the order of time, then of the scene. */
#include <math.h>

#include "run/internal.h"

#define EVENTS_MAX 1000000

static enum status add_event(struct drive *drive, const struct event *event)
{
	if (drive->event_count == EVENTS_MAX)
		return fail_with(STATUS_INPUT, "time_step: a step of %g s brings more than %d stations; make it shorter, or the "
					       "spacing coarser",
				 drive->scene->time_step, EVENTS_MAX);
	if (drive->event_count == drive->event_room) {
		size_t room = drive->event_room != 0 ? 2 * drive->event_room : 64;
		struct event *events = mem_realloc(drive->events, room, sizeof *events);
		if (events == NULL)
			return fail_memory("the stations of a step");
		drive->events = events;
		drive->event_room = room;
	}
	drive->events[drive->event_count++] = *event;
	return STATUS_OK;
}

static enum status no_ground(const struct rider *rider, const struct track_point *point)
{
	return fail_with(STATUS_FAILED, "%s: no ground under it at %.3f, %.3f after %.3f s; move its path, or set "
					"outside: skip",
			 rider->object->name, point->x, point->y, point->time);
}

enum status drive_set_down(struct drive *drive, struct rider *rider, int64_t station, struct event *event)
{
	struct track_point point;
	track_station(rider->track, station, &point);
	event->next_time = station + 1 < track_stations(rider->track) ? track_station_time(rider->track, station + 1) : INFINITY;
	event->pose = (struct deform_pose){
		.x = point.qx,
		.y = point.qy,
		.yaw = point.yaw,
		.pitch = point.pitch,
		.roll = point.roll,
	};
	int64_t ground;
	enum status status = ground_height(drive->ground, event->pose.x, event->pose.y, &ground, &event->contact);
	if (status != STATUS_OK)
		return status;
	if (!event->contact && drive->scene->outside == SCENE_STOP)
		return no_ground(rider, &point);
	if (!event->contact)
		return STATUS_OK;
	double reach = deform_shape_reach(&rider->object->shape, point.pitch, point.roll);
	if (rider->object->path.has_z)
		event->pose.z = lattice_offset(point.z);
	else if (rider->object->load > 0)
		event->pose.z = ground + lattice_offset(reach - deform_sinkage_guess(&rider->object->shape, &drive->scene->soils[0],
										     rider->object->load));
	else
		event->pose.z = ground + lattice_offset(reach - rider->object->sink);
	event->sinkage = lattice_offset_metres(ground - event->pose.z) + reach;
	if (station > 0) {
		struct track_point before;
		track_station(rider->track, station - 1, &before);
		event->distance = hypot(point.x - before.x, point.y - before.y);
		event->seconds = point.time - before.time;
	}
	return STATUS_OK;
}

enum status drive_collect_events(struct drive *drive, double until)
{
	drive->event_count = 0;
	for (;;) {
		struct event event = {.time = INFINITY};
		for (size_t i = 0; i < drive->scene->object_count; i++) {
			struct rider *rider = &drive->riders[i];
			if (rider->next >= track_stations(rider->track))
				continue;
			double time = track_station_time(rider->track, rider->next);
			if (time <= until && time < event.time) {
				event.time = time;
				event.rider = i;
			}
		}
		if (event.time == INFINITY)
			return STATUS_OK;
		struct rider *rider = &drive->riders[event.rider];
		enum status status = drive_set_down(drive, rider, rider->next, &event);
		if (status == STATUS_OK)
			status = add_event(drive, &event);
		if (status != STATUS_OK)
			return status;
		rider->next++;
	}
}
