/* Shared by figures.c, looks.c and visuals.c: what pictures show of vehicles. */
#ifndef FURROW_VEHICLE_FIGURES_H
#define FURROW_VEHICLE_FIGURES_H

#include "vehicle/internal.h"

#define FIGURE_GROUPS 3    /* geoms of these groups are shown, as MuJoCo's viewer shows them */
#define FIGURE_CLEAR 0.1f  /* of alpha: what has less is not shown; all else is opaque */

/* --- figures.c --- */

/* Adds a figure of a vehicle with no shape yet. `body`: of the model. *out: until the next one is added. */
enum status vehicle_add_figure(struct vehicles *vehicles, size_t vehicle, int body, const char *name, struct figure **out, struct scene_object **drawn, struct world_look **look) FURROW_CHECKED;

/* --- looks.c --- */

float vehicle_alpha_of(const mjModel *model, int geom);
/* Finds the colour of a geom: its own, that of its material times the mean of its texture, or none. */
void vehicle_look_of(const mjModel *model, int geom, struct world_look *look);
/* Returns true if the geom's texture has more than one colour. Pictures show its mean. */
bool vehicle_has_pattern(const mjModel *model, int geom);
/* Gives a look a colour of a file, sRGB. */
void vehicle_paint(struct world_look *look, const float colour[3]);

/* --- visuals.c --- */

/* A mesh file, read once for each scale. */
struct seen_mesh {
	char *path;
	double scale[3];
	struct scene_mesh_part *parts; /* count 0: it cannot be read */
	size_t count;
};

/* Adds figures of the <visual>s of a vehicle's URDF. hidden[i]: set for each body own.body.first + i that has one, whose geoms are not shown. */
enum status vehicle_add_visuals(struct vehicles *vehicles, size_t vehicle, bool *hidden) FURROW_CHECKED;
void vehicle_free_seen(struct vehicles *vehicles);

#endif
