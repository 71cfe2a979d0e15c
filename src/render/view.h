/* What the files view*.c share. Only the world's thread touches it. */
#ifndef FURROW_RENDER_VIEW_H
#define FURROW_RENDER_VIEW_H

#include "render/render.h"
#include "base/key_map.h"
#include "base/key_set.h"
#include "terrain/terrain.h"

/* What the picture of one time needs: tiles, in the order of need. */
struct view_look {
	double time; /* simulated, s */
	double made; /* when it was looked at; simulated, s */
	bool guessed; /* ranges were missing */
	uint64_t done; /* ranges that had been brought by then */
	size_t count;
	uint64_t keys[2 * TERRAIN_DRAWS_MAX];
};

#define VIEW_LOOKS 4 /* times looked ahead to */
#define VIEW_MISSING 1024

struct view_errors; /* view_errors.c */

struct view_contact {
	bool known;       /* no offset it leaves is below `low` or above `high`; else they are as far as objects reach */
	double low, high; /* 0 or less, 0 or more; metres */
};

struct view {
	struct world *world;
	bool watched;             /* somebody looks at every picture */
	bool at_steps;            /* pictures are of every scene.view.images-th step alone; else a picture may come after any step */
	uint64_t frames;          /* drawn */
	struct render *render;
	struct key_set deformed;  /* tiles that had offset tiles at or below them before the drive; 11 to 21 bytes each */
	struct offset_bounds bounds; /* what this drive's contacts may have left, of each tile that they changed */
	struct view_contact contact; /* what this one may leave */
	struct key_set expected;  /* the same of tiles that will be deformed; empty but while looking ahead */
	struct key_cache ranges;  /* of bases; a: NaN where nothing is */
	double reach;             /* metres that what is not known of a press may be off what was there */
	struct view_errors *errors; /* NULL: detail goes by the radii */
	size_t budget;            /* slots one picture may need */
	size_t room;              /* slots this picture and those ahead may need together */
	bool exact;               /* ranges that are not on the CPU are read; else look_ahead's thread is asked for them, and others stand in */
	bool guessed;             /* the last selection went by such others */
	struct ground_range_key *missing; /* ranges to ask for, VIEW_MISSING at most */
	size_t missing_count;
	bool coarse;              /* the last selection was cut to the budget: for figures alone */
	bool told;
	bool free;                /* a host has the camera: */
	struct render_camera camera;
	bool lacks;               /* the last picture wanted tiles that had not come */
	struct terrain_selection *selection;
	struct view_look *now;    /* the last picture */
	struct view_look *ahead;  /* VIEW_LOOKS of them, each replaced in turn */
	unsigned turn;
	struct key_set seen;      /* while wishes are put together */
	uint64_t naps;            /* pictures that waited for their tiles; */
	double nap_ms;            /* how long, without what waits for the store are counted as elsewhere */
	uint64_t starved;         /* frames drawn coarser than asked for, for any reason */
	uint64_t coarsened;       /* of those: the budget was the reason */
	double triangles;         /* summed over frames */
	struct render_tiles tiles; /* the same */
	double overdraw;          /* the same, over frames of which it is known: */
	uint64_t overdraw_frames;
	enum status failed;       /* of a source callback */
};

/* view_camera.c */
/* Where the view is not exact the camera may be off in height: what is not on the CPU is not waited for. */
void render_view_place_camera(struct view *view, double time, struct render_camera *camera);

/* view_objects.c: tells the picture where the objects are now. `settled`: how high loads stand is waited for, and the
 * picture is the same whenever that comes; otherwise it is as it was last known. */
enum status render_view_set_objects(struct view *view, bool settled) FURROW_CHECKED;

/* view_ranges.c: ranges of tiles, exact or as those of the tiles above them. */
/* Adds a range to those that are missing, if it must not be read now: true, and something must stand in for it. */
bool render_view_lacks_range(struct view *view, enum ground_range_kind kind, struct tile tile);
/* Whether the range of this tile can be had without reading it. */
bool render_view_has_range(struct view *view, enum ground_range_kind kind, struct tile tile);
/* Hands the missing ranges to the look-ahead. */
void render_view_ask_ranges(struct view *view);
/* Adds the ranges of ground that bodies will press, and that was deformed before the drive. */
void render_view_expect_contacts(struct view *view);

/* view_source.c */
void render_view_find_room(struct view *view);
/* Lowest (a) and highest (b) base in metres; a NaN: all is nodata. Where the view is not exact it may be that of a tile above. */
enum status render_view_base_range(struct view *view, struct tile tile, struct key_pair *range) FURROW_CHECKED;
/* Adds a tile and all above it. */
enum status render_view_add_chain(const struct view *view, struct key_set *set, struct tile tile) FURROW_CHECKED;
/* Selects what `camera` sees, cut to the budget. With `everything`, as if nothing were resident:
 * the selection's wanted tiles are the whole picture. Marks nothing used. */
enum status render_view_select(struct view *view, const struct render_camera *camera, bool everything) FURROW_CHECKED;
/* What was selected is used now; without `stand_ins` only what the complete picture needs. */
void render_view_mark_used(struct view *view, bool stand_ins);

/* view_offsets.c: how far off its base a tile's surface may be. */
bool render_view_is_deformed(const struct view *view, struct tile tile); /* it has offsets at or below it */
double render_view_find_reach(const struct world *world);
/* Of the drive's start, 0 or less and 0 or more; metres. Exact where the view is: else it may be that of a tile above. */
enum status render_view_stored_offsets(struct view *view, struct tile tile, double *low, double *high) FURROW_CHECKED;
/* render_view_contact's. */
enum status render_view_offsets_contact(struct view *view, const struct contact_area *area) FURROW_CHECKED;
/* A tile of the working level is changed, by what presses now. */
enum status render_view_offsets_touch(struct view *view, struct tile tile) FURROW_CHECKED;
/* No offset of the tile's subtree is or will be drawn outside these; metres. `expected`: it will be deformed by the time
 * that is looked at. */
enum status render_view_offsets(struct view *view, struct tile tile, bool expected, double *low, double *high) FURROW_CHECKED;

/* view_errors.c: how far off the ground a tile is drawn. With a pixel error alone. */
enum status render_view_errors_create(const struct world *world, struct view_errors **out) FURROW_CHECKED;
void render_view_errors_destroy(struct view_errors *errors); /* takes NULL */
/* render_view_contact's. */
enum status render_view_errors_contact(struct view *view, const struct event *event) FURROW_CHECKED;
/* A tile of the working level is changed, by what presses now. */
enum status render_view_errors_touch(struct view *view, struct tile tile) FURROW_CHECKED;
/* Metres, as terrain_source.error. `expected`: it will be deformed by the time that is looked at. */
enum status render_view_error(struct view *view, struct tile tile, bool expected, double *error) FURROW_CHECKED;

/* view_ahead.c: what pictures will need. */
void render_view_keep_now(struct view *view);
/* Looks at one of the times ahead; call once a frame, after it was selected and kept. */
enum status render_view_look_ahead(struct view *view) FURROW_CHECKED;

#endif
