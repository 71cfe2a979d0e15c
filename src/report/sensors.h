/* Shared by the files of sensors.csv, sensors.json and lidars. */
#ifndef FURROW_REPORT_SENSORS_H
#define FURROW_REPORT_SENSORS_H

#include "report/report.h"

struct cJSON;

/* Writes the name of the column of the kth number of a sensor. A name of a model may have any character. */
void report_sensor_column(const struct vehicle_sensor *sensor, size_t k, char text[400]);
/* Writes DIRECTORY/sensors.json. A scene without rows of sensors and without lidars has none: that of another run is removed. */
enum status report_sensors_json(const struct world *world, const struct vehicles *vehicles, const char *directory) FURROW_CHECKED;
/* Adds what a lidar of the scene is. */
void report_lidar_add(struct cJSON *to, const struct scene *scene, const struct scene_lidar *lidar);

#endif
