/*
 * What accuracy costs in time: what the parts of bench_accuracy share. Metres and seconds throughout.
 *
 *   accuracy_scene.c    the ground, the path, the store, the scene's text
 *   accuracy_sheet.c    the truth of the model sheet
 *   accuracy_truth.c    the same drive in doubles at 1/64 m; how far a surface is from it
 *   accuracy_drive.c    the drive by the product
 *   accuracy_formats.c  the drive through deform.h, slots kept in another texture format: accuracy_rig.c
 *   accuracy_rows.c     a row of the output: measured, printed, doubted
 *   accuracy.c          the studies
 */
#ifndef FURROW_ACCURACY_H
#define FURROW_ACCURACY_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "deform/deform.h"
#include "motion/motion.h"
#include "scene/scene.h"

/* --- the scene --- */
#define ACCURACY_WORLD 32.0            /* along a side */
#define ACCURACY_SPEED 2.0             /* m/s */
#define ACCURACY_RADIUS 0.5            /* of the wheel */
#define ACCURACY_WIDTH 0.3
#define ACCURACY_SINK 0.1
#define ACCURACY_OWN (1.0 / 16)        /* spacing that the store has where no study says another */
#define ACCURACY_IMPORT_ERROR 0.001    /* what import gives heights in floats: its default */
#define ACCURACY_REST 2000              /* intervals that the ground may go on sliding once the wheel stands */

/* Of the model sheet: its length is 0.1 m, and half of the wheel's depth is beyond its yield. N/m, Pa/m, m */
#define ACCURACY_TENSION 500.0
#define ACCURACY_STIFFNESS 50000.0
#define ACCURACY_YIELD 0.05

double accuracy_height(double x, double y);
/* The steepest the ground is, as a tangent: a bound. */
double accuracy_steepest(void);
/* All that decides the ground, the path and the wheel, as text: what a cached truth must be of. */
const char *accuracy_described(void);
/* The store of that spacing, made when first asked for with the step that import would choose; static storage. */
const char *accuracy_store(double spacing, double max_error);
/* With these settings over the scene: `laps` times along the path. */
struct scene *accuracy_scene(enum deform_model model, int laps, const struct scene_setting *settings, size_t count);
struct track *accuracy_track(const struct scene *scene, double spacing);
/* When the wheel stands: the first tenth of a second after its last station, a step's end at every time step. */
double accuracy_ends(const struct track *track);
const char *accuracy_model_name(enum deform_model model);

/* --- the truth --- */
#define ACCURACY_FINE (1.0 / 64)
/* Posts of the field, of that spacing: what is compared lies a margin within. */
extern const struct post_rect accuracy_field;
struct accuracy_truth {
	double *surfaces[DEFORM_MODELS]; /* of the field */
};
#define ACCURACY_EVERY (~0U)
/* From the file if that has it, else made, and written there if `path` is not NULL. wanted: a bit for each model whose truth is made; unless it is
 * ACCURACY_EVERY, they are not kept. */
void accuracy_truth_open(struct accuracy_truth *truth, const char *path, unsigned wanted);
void accuracy_truth_close(struct accuracy_truth *truth);

/* A body over the field: its lower envelope at posts of a rectangle, m; INFINITY: it is not above the post. */
struct accuracy_press {
	struct post_rect rect;
	const double *heights;
};
/* Presses an elastic sheet over the field, whose own surface sinks where it yields. last: then it is bent by the body, and does not yield. */
void accuracy_sheet(double *surface, const double *base, const struct accuracy_press *press, bool last);

/* Posts of a level that hold the field's. */
struct accuracy_surface {
	struct post_rect rect;
	double spacing;
	double *heights; /* row by row from the south; mem_free */
};
struct post_rect accuracy_rect(double spacing);
struct accuracy_error {
	double max, rms;   /* m */
	double volume;     /* m3: what lies higher than the truth less what lies lower */
	double volume_abs; /* m3: both */
};
struct accuracy_error accuracy_compare(const double *truth, const struct accuracy_surface *surface);

/* --- what one measurement gives --- */
struct accuracy_figures {
	struct accuracy_error error;
	double ms_step;       /* mean over the drive's steps, the rest not counted */
	double p99, worst;    /* of single steps, ms; NaN: those were not timed */
	int64_t steps;
	double time_step;
	int64_t slot_bytes;   /* planes of the tiles that were touched, base included */
	int64_t base_bytes, plane_bytes; /* of the store's rows */
	int64_t awake;        /* blocks at the end: 0, it came to rest */
	double drift;         /* m3: of offsets + compacted, of models that conserve; 0 is what is asked for */
	uint64_t hash;        /* of the surface */
	uint64_t rows;        /* of objects.csv; 0: there is none */
	struct accuracy_surface surface; /* a variant's, with a truth: the caller's; else NULL */
	char gl[128];
};

struct accuracy_drive {
	enum deform_model model;
	double spacing, max_error; /* of the store */
	int divided;               /* worked on at so many levels below */
	const struct scene_setting *settings;
	size_t setting_count;
	double time_step, interval; /* what the settings say */
	int laps;
	bool durable_full;
};
/* With `truth`: to rest, and compared; NULL: the drive alone. */
void accuracy_drive(const struct accuracy_drive *drive, const struct accuracy_truth *truth,
		    struct accuracy_figures *figures);

enum accuracy_format { KEPT_R8, KEPT_R16, KEPT_R16F, KEPT_R32F, KEPT_R32I, KEPT_FORMATS };
const char *accuracy_format_name(enum accuracy_format format);
struct accuracy_variant {
	enum deform_model model;
	double spacing, max_error;
	enum accuracy_format base, offset;
	int passes; /* over the path */
};
size_t accuracy_format_bytes(enum accuracy_format format); /* a post */
void accuracy_variant(const struct accuracy_variant *variant, const struct accuracy_truth *truth,
		      struct accuracy_figures *figures);

#endif
