/* What the files of deform share. */
#ifndef FURROW_DEFORM_INTERNAL_H
#define FURROW_DEFORM_INTERNAL_H

#include "deform/deform.h"

#define SIDE DEFORM_WINDOW_POSTS

/* The scratch of one window; planes only as the parameters call for them. */
struct layer {
	struct gpu_target *displaced; /* offsets[1] and contacts */
	struct gpu_target *filtered[2]; /* offsets[0], offsets[1] */
	struct gpu_target *dirtied;   /* dirts[1] */
	int result;                   /* which of offsets holds it */
};

struct deform {
	struct deform_params params;
	double spacing;
	int64_t reach;  /* posts beyond the footprint that change */
	int64_t border; /* posts beyond those that are read */
	uint32_t layers; /* that the textures have */
	struct gpu_texture *bases, *offsets[2], *contacts, *dirts[2];
	struct layer scratch[DEFORM_WINDOWS_MAX];
	struct gpu_program *displace[3]; /* by shape; made when first needed */
	struct gpu_program *box, *dirt;
	struct gpu_buffer *refusals;
};

/* A sweep that is no motion: its end pose alone presses. */
bool deform_is_contact_only(const struct deform_sweep *sweep);

/* scratch.c: textures and targets for `layers` windows. */
enum status deform_need_layers(struct deform *deform, uint32_t layers) FURROW_CHECKED;
void deform_drop_layers(struct deform *deform);

/* stages.c: the passes over a gathered window. */
enum status deform_run_stages(struct deform *deform, const struct deform_sweep *sweep,
			      const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

#endif
