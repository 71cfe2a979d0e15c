/* What a host asks of one vehicle: where it is to go, and what its wheels do. */
#include "drive/internal.h"

/* Returns false if the number is of an object, or of nothing. *vehicle: of the vehicles. */
static bool is_vehicle(const struct drive *drive, size_t number, size_t *vehicle)
{
	const size_t objects = drive->scene->object_count;
	*vehicle = number - objects;
	return number >= objects && *vehicle < vehicle_count(drive->vehicles);
}

bool drive_send(struct drive *drive, size_t number, double x, double y)
{
	size_t vehicle;
	return is_vehicle(drive, number, &vehicle) && vehicle_send(drive->vehicles, vehicle, x, y);
}

bool drive_target(const struct drive *drive, size_t number, double place[2])
{
	size_t vehicle;
	return is_vehicle(drive, number, &vehicle) && vehicle_target(drive->vehicles, vehicle, place);
}

size_t drive_wheels(const struct drive *drive, size_t number, struct drive_wheel *wheels, size_t most)
{
	struct vehicle_info info;
	size_t vehicle, count = 0;
	if (!is_vehicle(drive, number, &vehicle))
		return 0;
	vehicle_info(drive->vehicles, vehicle, &info);
	for (size_t g = 0; g < info.geom_count && count < most; g++) {
		struct drive_wheel *wheel = &wheels[count];
		count += vehicle_wheel(drive->vehicles, vehicle, g, &wheel->name, &wheel->slip, &wheel->sinkage);
	}
	return count;
}

double drive_time(const struct drive *drive)
{
	return world_time(drive->world);
}
