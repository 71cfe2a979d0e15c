/* Vehicles in a build without MuJoCo: a scene that has them is refused. No other function is called then. */
#include <math.h>

#include "vehicle/vehicle.h"

enum status vehicle_load(const struct scene *scene, struct vehicles **out)
{
	*out = NULL;
	if (scene->vehicle_count == 0)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "%s: vehicles: this build has no MuJoCo; run tools/packages.sh, which brings it, and build again with -Dvehicle=enabled",
			 scene->file);
}

void vehicle_destroy(struct vehicles *vehicles)
{
	(void)vehicles;
}

size_t vehicle_attached(const struct vehicles *vehicles)
{
	(void)vehicles;
	return 0;
}

const struct soil_shape *const *vehicle_aboard_shapes(const struct vehicles *vehicles, size_t *count)
{
	(void)vehicles;
	*count = 0;
	return NULL;
}

struct world_aboard vehicle_geom_aboard(const struct vehicles *vehicles, size_t vehicle, size_t geom, bool *carries)
{
	(void)vehicles, (void)vehicle, (void)geom;
	*carries = false;
	return (struct world_aboard){0, 0, 0};
}

enum status vehicle_geom_capacity(const struct vehicles *vehicles, size_t vehicle, size_t geom, double *capacity)
{
	(void)vehicles, (void)vehicle, (void)geom;
	*capacity = 0;
	return STATUS_OK;
}

enum status vehicle_draw(struct vehicles *vehicles, uint64_t effects)
{
	return STATUS_OK;
}

struct world_figures vehicle_figures(const struct vehicles *vehicles)
{
	(void)vehicles;
	return (struct world_figures){.count = 0};
}

static enum status none(void)
{
	return fail_with(STATUS_FAILED, "vehicles: this build has no MuJoCo; run tools/packages.sh, which brings it, and build again with -Dvehicle=enabled");
}

enum status vehicle_check_rasters(struct vehicles *vehicles, const struct world *world)
{
	(void)vehicles, (void)world;
	return STATUS_OK;
}

enum status vehicle_join(struct vehicles *vehicles, struct world *world)
{
	(void)vehicles, (void)world;
	return none();
}

enum status vehicle_begin(struct vehicles *vehicles)
{
	(void)vehicles;
	return none();
}

enum status vehicle_step(struct vehicles *vehicles)
{
	(void)vehicles;
	return none();
}

const char *vehicle_stopped(const struct vehicles *vehicles)
{
	(void)vehicles;
	return NULL;
}

bool vehicle_lie(const struct vehicles *vehicles, size_t vehicle, size_t nth, struct vehicle_lie *lie)
{
	(void)vehicles, (void)vehicle, (void)nth, (void)lie;
	return false;
}

bool vehicle_rows_due(struct vehicles *vehicles)
{
	(void)vehicles;
	return false;
}

size_t vehicle_sensor_count(const struct vehicles *vehicles, size_t vehicle)
{
	(void)vehicles, (void)vehicle;
	return 0;
}

void vehicle_sensor(const struct vehicles *vehicles, size_t vehicle, size_t sensor, struct vehicle_sensor *out)
{
	(void)vehicles, (void)vehicle, (void)sensor;
	*out = (struct vehicle_sensor){.type = "", .unit = "", .kind = ""};
}

bool vehicle_sensors_due(struct vehicles *vehicles)
{
	(void)vehicles;
	return false;
}

enum status vehicle_sense(struct vehicles *vehicles)
{
	(void)vehicles;
	return none();
}

const double *vehicle_sensed(const struct vehicles *vehicles, size_t vehicle, size_t sensor)
{
	(void)vehicles, (void)vehicle, (void)sensor;
	return NULL;
}

enum status vehicle_rays(struct vehicles *vehicles, size_t vehicle, const char *body, struct vehicle_ray *rays, size_t count)
{
	(void)vehicles, (void)vehicle, (void)body;
	for (size_t i = 0; i < count; i++)
		rays[i].distance = INFINITY;
	return STATUS_OK;
}

void vehicle_frame(const struct vehicles *vehicles, size_t vehicle, const char *body, double at[3], double axes[9])
{
	(void)vehicles, (void)vehicle, (void)body, (void)at, (void)axes;
}

void vehicle_row(struct vehicles *vehicles, size_t vehicle, struct vehicle_row *row)
{
	(void)vehicles, (void)vehicle, (void)row;
}

size_t vehicle_count(const struct vehicles *vehicles)
{
	(void)vehicles;
	return 0;
}

void vehicle_info(const struct vehicles *vehicles, size_t vehicle, struct vehicle_info *info)
{
	(void)vehicles, (void)vehicle;
	*info = (struct vehicle_info){.name = ""};
}

size_t vehicle_trail(const struct vehicles *vehicles, size_t vehicle, double (*places)[2])
{
	(void)vehicles, (void)vehicle, (void)places;
	return 0;
}

void vehicle_geom(const struct vehicles *vehicles, size_t vehicle, size_t geom, double spacing, struct vehicle_geom *out)
{
	(void)vehicles, (void)vehicle, (void)geom, (void)spacing;
	*out = (struct vehicle_geom){.name = ""};
}

const char *vehicle_joint_name(const struct vehicles *vehicles, size_t vehicle, size_t joint)
{
	(void)vehicles, (void)vehicle, (void)joint;
	return "";
}

const char *vehicle_actuator_name(const struct vehicles *vehicles, size_t vehicle, size_t actuator)
{
	(void)vehicles, (void)vehicle, (void)actuator;
	return "";
}

const char *vehicle_actuator_key(const struct vehicles *vehicles, size_t vehicle, size_t actuator)
{
	(void)vehicles, (void)vehicle, (void)actuator;
	return NULL;
}

size_t vehicle_drive_count(const struct vehicles *vehicles, size_t vehicle)
{
	(void)vehicles, (void)vehicle;
	return 0;
}

void vehicle_drive(const struct vehicles *vehicles, size_t vehicle, size_t drive, struct vehicle_drive *out)
{
	(void)vehicles, (void)vehicle, (void)drive;
	*out = (struct vehicle_drive){.name = ""};
}

enum status vehicle_outline(const struct scene *scene, size_t vehicle, struct vehicle_outline *out)
{
	(void)scene, (void)vehicle, (void)out;
	return none();
}

enum status vehicle_find_shares(struct vehicles *vehicles)
{
	(void)vehicles;
	return STATUS_OK;
}

void vehicle_state(const struct vehicles *vehicles, size_t vehicle, struct furrow_state *state)
{
	(void)vehicles, (void)vehicle;
	*state = (struct furrow_state){.pose = {.position = {0}}};
}

void vehicle_joints(const struct vehicles *vehicles, size_t vehicle, double *values, double *rates)
{
	(void)vehicles, (void)vehicle, (void)values, (void)rates;
}

void vehicle_actuators(const struct vehicles *vehicles, size_t vehicle, double *controls, double *forces)
{
	(void)vehicles, (void)vehicle, (void)controls, (void)forces;
}

size_t vehicle_bodies(const struct vehicles *vehicles, size_t vehicle)
{
	(void)vehicles, (void)vehicle;
	return 0;
}

const char *vehicle_model_body_name(const struct vehicles *vehicles, size_t vehicle, size_t body)
{
	(void)vehicles, (void)vehicle, (void)body;
	return "";
}

void vehicle_set_force(struct vehicles *vehicles, size_t vehicle, size_t body, const double force[3], const double torque[3])
{
	(void)vehicles, (void)vehicle, (void)body, (void)force, (void)torque;
}

void vehicle_set_controls(struct vehicles *vehicles, size_t vehicle, const double *controls)
{
	(void)vehicles, (void)vehicle, (void)controls;
}

const char *vehicle_body_name(const struct vehicles *vehicles, int32_t number)
{
	(void)vehicles, (void)number;
	return NULL;
}

bool vehicle_body(const struct vehicles *vehicles, int32_t number, struct furrow_state *state, struct furrow_contact *contact)
{
	(void)vehicles, (void)number;
	(void)state, (void)contact;
	return false;
}

enum status vehicle_step_back(struct vehicles *vehicles)
{
	(void)vehicles;
	return none();
}

enum status vehicle_rollback(struct vehicles *vehicles)
{
	(void)vehicles;
	return none();
}

bool vehicle_send(struct vehicles *vehicles, size_t vehicle, double x, double y)
{
	(void)vehicles, (void)vehicle, (void)x, (void)y;
	return false;
}

bool vehicle_target(const struct vehicles *vehicles, size_t vehicle, double place[2])
{
	(void)vehicles, (void)vehicle, (void)place;
	return false;
}

void vehicle_mark_ways(struct vehicles *vehicles)
{
	(void)vehicles;
}

void vehicle_mark_ways_back(struct vehicles *vehicles)
{
	(void)vehicles;
}

bool vehicle_wheel(const struct vehicles *vehicles, size_t vehicle, size_t geom, const char **name, double *slip, double *sinkage)
{
	(void)vehicles, (void)vehicle, (void)geom, (void)name, (void)slip, (void)sinkage;
	return false;
}

const char *vehicle_engine(void)
{
	return NULL;
}

const struct scene *vehicle_scene(const struct vehicles *vehicles, const struct scene *scene)
{
	(void)vehicles;
	return scene;
}

void vehicle_part_joint(const struct vehicles *vehicles, size_t vehicle, size_t joint, struct vehicle_joint *out)
{
	(void)vehicles, (void)vehicle, (void)joint;
	*out = (struct vehicle_joint){.name = ""};
}

void vehicle_part_actuator(const struct vehicles *vehicles, size_t vehicle, size_t actuator, struct vehicle_actuator *out)
{
	(void)vehicles, (void)vehicle, (void)actuator;
	*out = (struct vehicle_actuator){.name = ""};
}

const char *vehicle_part_keyframe(const struct vehicles *vehicles, size_t vehicle, size_t keyframe)
{
	(void)vehicles, (void)vehicle, (void)keyframe;
	return NULL;
}

void vehicle_part_size(const struct vehicles *vehicles, size_t vehicle, struct vehicle_size *out)
{
	(void)vehicles, (void)vehicle;
	*out = (struct vehicle_size){.root = ""};
}

/* --- a model that a host lends --- */

int vehicle_engine_number(void)
{
	return 0;
}

const void *vehicle_engine_place(void)
{
	return NULL;
}

bool vehicle_lent_ended(const struct vehicle_lent *lent)
{
	(void)lent;
	return false;
}

double vehicle_lent_seconds(const struct vehicle_lent *lent)
{
	(void)lent;
	return 0;
}

enum status vehicle_lend(const struct vehicle_lending *lending, struct world *world, struct vehicle_lent **out)
{
	(void)lending, (void)world;
	*out = NULL;
	return none();
}

void vehicle_lent_destroy(struct vehicle_lent *lent)
{
	(void)lent;
}

enum status vehicle_lent_begin(struct vehicle_lent *lent, const void *data, double seconds, bool again, double *forces)
{
	(void)lent, (void)data, (void)seconds, (void)again, (void)forces;
	return none();
}

bool vehicle_lent_limit(struct vehicle_lent *lent, const double *qvel, double *forces)
{
	(void)lent, (void)qvel, (void)forces;
	return false;
}

void vehicle_lent_forces(struct vehicle_lent *lent, const double *qvel, double *forces)
{
	(void)lent, (void)qvel, (void)forces;
}

void vehicle_lent_end(struct vehicle_lent *lent, const double *qvel)
{
	(void)lent, (void)qvel;
}

enum status vehicle_lent_touch(struct vehicle_lent *lent, const void *data, bool *moved)
{
	(void)lent, (void)data;
	*moved = false;
	return none();
}

void vehicle_lent_forget(struct vehicle_lent *lent)
{
	(void)lent;
}

size_t vehicle_lent_count(const struct vehicle_lent *lent)
{
	(void)lent;
	return 0;
}

int vehicle_lent_geom(const struct vehicle_lent *lent, size_t index, const char **name, struct furrow_state *state, struct furrow_contact *contact)
{
	(void)lent, (void)index, (void)name, (void)state, (void)contact;
	return -1;
}
