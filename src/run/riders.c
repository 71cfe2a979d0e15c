/* The objects on their ways: each gets its path as stations, in local metres, and the record a place for it. */
#include <math.h>

#include "dem/dem.h"
#include "run/internal.h"

/* The path's points in local metres. */
static enum status local_points(const struct drive *drive, const struct scene_path *path, double (*points)[2])
{
	const struct scene *scene = drive->scene;
	for (size_t i = 0; i < path->count; i++) {
		points[i][0] = path->points[i].x;
		points[i][1] = path->points[i].y;
		if (scene->coordinates == SCENE_SRS) {
			if (drive->meta->srs[0] == '\0')
				return fail_with(STATUS_INPUT, "coordinates: %s, but the store has no reference system; use local",
						 scene->srs);
			enum status status =
				dem_transform(scene->srs, drive->meta->srs, 1, &points[i][0], &points[i][1]);
			if (status != STATUS_OK)
				return status;
		}
		if (scene->coordinates != SCENE_LOCAL) {
			points[i][0] -= drive->meta->origin[0];
			points[i][1] -= drive->meta->origin[1];
		}
	}
	return STATUS_OK;
}

enum status drive_mount(struct drive *drive)
{
	const struct scene *scene = drive->scene;
	drive->riders = mem_calloc(scene->object_count + 1, sizeof *drive->riders);
	drive->rests = mem_calloc(scene->object_count, sizeof *drive->rests);
	drive->record = mem_calloc(1, record_bytes(scene->object_count));
	if (drive->riders == NULL || drive->rests == NULL || drive->record == NULL)
		return fail_memory("the objects");
	uint32_t carriers = 0;
	for (size_t i = 0; i < scene->object_count; i++) {
		struct rider *rider = &drive->riders[i];
		rider->object = &scene->objects[i];
		rider->carrier = rider->object->load > 0 ? ++carriers : 0;
		const struct deform_shape *shape = &rider->object->shape;
		const struct scene_path *path = &rider->object->path;
		enum status status = deform_shape_check(shape, drive->spacing);
		double(*points)[2] = mem_alloc(path->count, sizeof *points);
		if (status == STATUS_OK && points == NULL)
			status = fail_memory("a path");
		if (status == STATUS_OK)
			status = local_points(drive, path, points);
		double turn_reach = shape->kind == DEFORM_WHEEL ? shape->radius : deform_shape_bound(shape);
		if (status == STATUS_OK)
			status = track_create(path, (const double(*)[2])points, drive->spacing, turn_reach, &rider->track);
		mem_free(points);
		if (status != STATUS_OK)
			return status;
	}
	return STATUS_OK;
}

void drive_unmount(struct drive *drive)
{
	for (size_t i = 0; drive->riders != NULL && i < drive->scene->object_count; i++)
		track_destroy(drive->riders[i].track);
	mem_free(drive->riders);
	mem_free(drive->rests);
	mem_free(drive->record);
}
