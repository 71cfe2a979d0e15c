/* trials, inside: beds, lanes, and the search for a torque's slip. */
#ifndef FURROW_TRIALS_INTERNAL_H
#define FURROW_TRIALS_INTERNAL_H

#include "api/furrow.h"
#include "trials/trials.h"

/* One run of one object: its load and slip, and what was found. */
struct rig_lane {
	size_t place;            /* which load and angle it has: below trials_rig_places */
	double load, lead, slip; /* lead: of those ahead of the last. load is NaN for one at a depth, slip for an object that has none */
	double depth, angle;     /* m; rad, to the left of the way */
	struct rig_row rows[RIG_PASSES_MOST];
};

/* What is the same in all lanes. */
struct rig {
	const struct rig_params *params;
	struct rig_found found;
	char *shape, *bed;        /* YAML in braces; path of the bed */
	double pitch, start;      /* m: from lane to lane; from the bed's edges to the lanes */
	double speed;             /* m/s */
	size_t passes;
	double behind;            /* m: from one object of a lane to the next */
	double taken;             /* m: at the end of the way, where rows are taken */
	double levels;            /* 2^n: posts of the bed's coarsest level are so many times as far apart */
	bool advised;             /* advice on this soil was told */
	int64_t done, total;      /* lanes, for progress */
};

/* bed.c. Makes the folder of the bed, and names it. Nothing of the user's has that name. */
enum status trials_bed_begin(struct rig *rig) FURROW_CHECKED;
/* Makes level ground for so many lanes. */
enum status trials_bed_make(const struct rig *rig, size_t lanes) FURROW_CHECKED;
void trials_bed_remove(struct rig *rig); /* and its folder */

/* rig.c: returns the failure of a call of the library, with its message. STATUS_OK: it was none. */
enum status trials_told(furrow_status status) FURROW_CHECKED;
/* rig.c: true if the object has a slip and what drives it. */
bool trials_rig_is_driven(const struct rig *rig);
/* rig.c: true if a text is a mapping in braces, and no name. */
bool trials_in_braces(const char *text);
/* Returns how many pairs there are of a load, or a depth, and an angle. Those of one load come one after another. */
size_t trials_rig_places(const struct rig_params *params);
/* Returns a lane for one of these pairs. */
struct rig_lane trials_rig_lane(const struct rig_params *params, size_t place, double slip);

/* lanes.c: drives lanes over one soil and fills their rows. */
enum status trials_lanes_drive(struct rig *rig, size_t soil, struct rig_lane *lanes, size_t count) FURROW_CHECKED;
#define RIG_LANES_MOST 16 /* of one bed */

/* torque.c: finds slips at which this soil gives the torques, under each load, and gives the rows. */
enum status trials_torques(struct rig *rig, size_t soil, rig_row_fn give, void *user) FURROW_CHECKED;

#endif
